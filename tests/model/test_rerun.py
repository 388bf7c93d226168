"""A new run is looked at before it is accepted; what it cannot take over waits, can be settled, and is tried again."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from two_rooms import door, line, make_run

from rgcore.errors import EditError, ProjectError
from rgcore.model.edits import (
    AddGateway,
    AddNote,
    ClassifyGateway,
    ClassifyRegion,
    Confirm,
    DeleteGateway,
    DeleteLines,
    LabelObject,
    MarkClutter,
    MergeRegions,
    RenameRegion,
    Several,
)
from rgcore.model.outcome import LEAVE
from rgcore.model.project import Project
from rgcore.model.records import RGMap, replace
from rgcore.model.rerun import plan_rerun


@pytest.fixture
def project(tmp_path: Path, run: Any) -> Iterator[Project]:
    with Project.create(tmp_path / "office.rg", run) as project:
        yield project


def again(map: RGMap) -> Any:
    """Another run of the same log that gave this map."""
    return make_run(map)


def without(map: RGMap, kind: str, *ids: str) -> RGMap:
    return replace(map, **{kind: {k: v for k, v in getattr(map, kind).items() if k not in ids}})


def test_a_plan_writes_nothing_and_tells_all(project: Project, office: RGMap) -> None:
    project.do(RenameRegion(region="r2", name="Lab"))
    project.do(ClassifyRegion(region="r3", class_="kitchen"))
    before = sorted(p.name for p in project.path.rglob("*"))
    plan = plan_rerun(project, again(without(office, "regions", "r3")))
    assert sorted(p.name for p in project.path.rglob("*")) == before
    assert plan.counts() == {"applied": 1, "shifted": 0, "conflict": 0, "stale": 1}
    assert plan.map.regions["r2"].name == "Lab"
    assert project.run_name == "0001"
    lost = plan.outcomes[1]
    assert (lost.title, lost.place) == ("relabel r3 as kitchen", office.regions["r3"].box.center)
    assert [r.name for r in lost.remedies] == ["let it go"]


def test_a_choice_leaves_an_edit_out_and_it_waits(project: Project, office: RGMap) -> None:
    project.do(RenameRegion(region="r2", name="Lab"))
    project.do(RenameRegion(region="r3", name="Store"))
    (waits,) = project.accept(plan_rerun(project, again(office)), {0: LEAVE})
    assert (waits.title, waits.kind) == ("rename r2 to Lab", "conflict")
    assert [r.name for r in project.map.regions.values()] == ["Hallway 1", "Room 1", "Store"]
    with pytest.raises(ProjectError, match="there is no outcome 9 in this plan of 2"):
        project.accept(plan_rerun(project, again(office)), {9: LEAVE})


def test_a_plan_of_before_an_edit_is_not_accepted(project: Project, office: RGMap) -> None:
    plan = plan_rerun(project, again(office))
    project.do(RenameRegion(region="r2", name="Lab"))
    with pytest.raises(ProjectError, match="was edited since the new run was looked at"):
        project.accept(plan)
    assert (project.run_name, project.map.regions["r2"].name) == ("0001", "Lab")


def test_a_remedy_settles_what_waits_and_undo_lets_it_wait_again(project: Project, office: RGMap) -> None:
    """The new run made one room of two: the person says that it is this one."""
    project.do(RenameRegion(region="r2", name="Lab"), by="ann")
    r2 = office.regions["r2"]
    wide = replace(r2, boundary=((0.0, 2.1), (8.0, 2.1), (8.0, 6.0), (0.0, 6.0)))
    new = replace(without(office, "regions", "r3"), regions={"r1": office.regions["r1"], "r2": wide})
    new = replace(
        new, regions={**new.regions, "r2": replace(wide, boundary=((0, 2.1), (9.0, 2.1), (9.0, 6.0), (0, 6.0)))}
    )
    (waits,) = project.add_run(again(new))
    assert [r.name for r in waits.remedies] == ["apply to r2", "let it go"]
    project.settle(waits, waits.remedies[0], by="bob")
    assert project.conflicts == ()
    assert project.map.regions["r2"].name == "Lab"
    assert project.history.undo_title == "rename r2 to Lab: apply to r2"
    with pytest.raises(EditError, match="waits no more"):
        project.settle(waits, waits.remedies[0])
    project.undo()
    assert project.conflicts == (waits,)
    project.settle(waits, waits.remedies[-1])  # let go: an entry that changes nothing is kept all the same
    with Project.open(project.path) as same:
        assert same.conflicts == ()
        assert same.history.undo_title == "rename r2 to Lab: let it go"


def test_a_remedy_may_be_chosen_before_the_run_is_accepted(project: Project, office: RGMap) -> None:
    project.do(ClassifyRegion(region="r3", class_="kitchen"))
    plan = plan_rerun(project, again(without(office, "regions", "r3")))
    assert project.accept(plan, {0: plan.outcomes[0].remedies[-1]}) == ()
    assert project.history.undo_title == "relabel r3 as kitchen: let it go"
    project.undo()
    assert [o.title for o in project.conflicts] == ["relabel r3 as kitchen"]


def test_a_third_run_knows_again_what_the_second_did_not(project: Project, office: RGMap) -> None:
    project.do(ClassifyRegion(region="r3", class_="kitchen"), by="bob")
    assert len(project.add_run(again(without(office, "regions", "r3")))) == 1
    assert project.add_run(again(office)) == ()
    assert project.map.regions["r3"].class_ == "kitchen"
    assert project.map.regions["r3"].provenance.by == "bob"


def test_undo_and_redo_go_on_across_a_run(project: Project, office: RGMap) -> None:
    project.do(RenameRegion(region="r1", name="Flur"))
    project.do(RenameRegion(region="r2", name="Lab"))
    project.do(DeleteGateway(gateway="g1"))
    project.undo()
    project.undo()
    project.add_run(again(office))
    assert (project.history.undo_title, project.history.redo_title) == ("rename r1 to Flur", "rename r2 to Lab")
    project.redo()
    assert project.history.redo_title == "delete g1"
    assert "g1" not in project.redo().gateways
    project.undo(), project.undo(), project.undo()
    assert project.map == office


def test_what_the_new_run_does_by_itself_is_not_done_twice(project: Project, office: RGMap) -> None:
    """A door drawn by hand that the new run finds, of another class: one door, of the class that the hand gave."""
    made = AddGateway(id="gu00000001", posts=((4.0, 3.0), (4.0, 4.0)), regions=("r2", "r3"), class_="door")
    project.do(made)
    found = replace(door("g9", ("r2", "r3"), 4.05, 3.5), posts=((4.05, 3.05), (4.05, 4.05)))
    plan = plan_rerun(project, again(replace(office, gateways={**office.gateways, "g9": found})))
    assert sorted(plan.map.gateways) == ["g1", "g2", "g9"]
    assert plan.map.gateways["g9"].class_ == "door"


def test_what_is_deleted_and_gone_by_itself_is_done_but_not_forgotten(project: Project, office: RGMap) -> None:
    project.do(DeleteLines(lines=("l5",)))
    assert project.add_run(again(without(office, "lines", "l5"))) == ()
    assert (project.outcomes[0].kind, project.outcomes[0].edit) == ("applied", None)
    assert project.add_run(again(office)) == ()
    assert "l5" not in project.map.lines


def test_a_wall_in_pieces_is_marked_in_all_of_them(project: Project, office: RGMap) -> None:
    project.do(MarkClutter(lines=("l1",)))
    halves = {"l1": line("l1", (0.0, 0.0), (3.9, 0.0), "r1"), "l40": line("l40", (4.0, 0.0), (8.0, 0.0), "r1")}
    assert project.add_run(again(replace(office, lines={**office.lines, **halves}))) == ()
    assert [v.id for v in project.map.lines.values() if v.clutter] == ["l1", "l40"]


def test_several_are_carried_as_far_as_they_go_and_the_rest_waits(project: Project, office: RGMap) -> None:
    both = tuple(ClassifyRegion(region=r, class_="lab") for r in ("r2", "r3"))
    project.do(Several(name="make labs", edits=both))
    project.do(Confirm(items=("r1", "g2")))
    new = without(without(office, "regions", "r3"), "gateways", "g2")
    waits = project.add_run(again(new))
    assert project.map.regions["r2"].class_ == "lab"
    assert project.map.regions["r1"].provenance.confirmed
    assert [o.entry.edit for o in waits] == [Several(name="make labs", edits=both[1:]), Confirm(items=("g2",))]
    assert [o.kind for o in project.outcomes] == ["applied", "stale", "applied", "stale"]


def test_a_thing_that_was_confirmed_and_looks_other_is_to_be_looked_at_again(project: Project, office: RGMap) -> None:
    project.do(Confirm(items=("r2",)))
    smaller = replace(office.regions["r2"], boundary=((0.0, 2.1), (4.0, 2.1), (4.0, 4.8), (0.0, 4.8)))
    (waits,) = project.add_run(again(replace(office, regions={**office.regions, "r2": smaller})))
    assert (waits.kind, waits.reason) == ("conflict", "r2 has another outline: 69 % alike")
    assert not project.map.regions["r2"].provenance.confirmed


def test_an_edit_that_would_do_something_else_is_not_made(project: Project, office: RGMap) -> None:
    """Two rooms were merged by hand; in the new run one of them is another one, with four times the ground."""
    project.do(MergeRegions(regions=("r1", "r2")))
    huge = replace(office.regions["r1"], boundary=((0.0, -7.0), (8.0, -7.0), (8.0, 2.0), (0.0, 2.0)))
    (waits,) = project.add_run(again(replace(office, regions={**office.regions, "r1": huge})))
    assert waits.waits
    assert set(project.map.regions) == {"r1", "r2", "r3"}


def test_a_note_outlives_its_item(project: Project, office: RGMap) -> None:
    project.do(AddNote(id="nu00000001", text="leaks", place=(6.0, 4.0), item="r3"))
    assert project.add_run(again(without(office, "regions", "r3"))) == ()
    assert (project.map.notes["nu00000001"].place, project.map.notes["nu00000001"].item) == ((6.0, 4.0), None)
    assert project.outcomes[0].kind == "shifted"


def test_conflicts_of_an_older_version_are_read(project: Project, office: RGMap, run: SimpleNamespace) -> None:
    project.do(ClassifyRegion(region="r3", class_="kitchen"))
    project.add_run(again(without(office, "regions", "r3")))
    project.close()
    old = """[{"entry": {"type": "do", "number": 1, "at": "2026-01-01T00:00:00Z", "by": null, "edit":
      {"edit": "ClassifyRegion", "region": "r3", "class": "kitchen"}}, "outcome": "stale", "run": "0001",
      "title": "relabel r3 as kitchen", "reason": "r3 has no clear counterpart in the new map"}]"""
    (project.path / "runs/0002/conflicts.json").write_text(old)
    with Project.open(project.path) as same:
        assert [str(o) for o in same.conflicts] == ["relabel r3 as kitchen: r3 has no clear counterpart in the new map"]
        assert same.add_run(again(office)) == ()


def test_a_box_whose_sides_change_names_is_the_same(project: Project, office: RGMap) -> None:
    project.do(LabelObject(object="o1", label="shelf"))
    o = office.objects["o1"]
    turned = replace(o, id="o4", size=(o.size[1], o.size[0], o.size[2]), yaw=0.0)
    assert project.add_run(again(replace(office, objects={"o4": turned}))) == ()
    assert project.map.objects["o4"].label == "shelf"


def test_a_wide_opening_is_known_though_its_posts_stand_elsewhere(project: Project, office: RGMap) -> None:
    wide = replace(office.gateways["g1"], posts=((0.2, 2.05), (3.8, 2.05)), class_="opening")
    other = replace(wide, posts=((0.8, 2.05), (3.1, 2.05)))
    project.accept(plan_rerun(project, again(replace(office, gateways={"g1": wide}))))
    project.do(ClassifyGateway(gateway="g1", class_="counter"))
    assert project.add_run(again(replace(office, gateways={"g1": other}))) == ()
    assert project.map.gateways["g1"].class_ == "counter"


def test_a_wall_that_fell_to_crumbs_is_not_gone_by_itself(project: Project, office: RGMap) -> None:
    project.do(DeleteLines(lines=("l5",)))
    crumbs = {
        f"l{60 + n}": line(f"l{60 + n}", (4.0, y), (4.02, y + 0.1), "r2") for n, y in enumerate((2.5, 3.5, 4.5, 5.5))
    }
    rest = {k: v for k, v in office.lines.items() if k != "l5"}
    (waits,) = project.add_run(again(replace(office, lines={**rest, **crumbs})))
    assert waits.title == "delete l5"


def test_a_room_without_its_niche_keeps_its_name_and_says_nothing_of_it(project: Project, office: RGMap) -> None:
    project.do(RenameRegion(region="r2", name="Lab"))
    project.do(Confirm(items=("r2",)))
    smaller = replace(office.regions["r2"], boundary=((0.0, 2.1), (4.0, 2.1), (4.0, 4.8), (0.0, 4.8)))
    plan = plan_rerun(project, again(replace(office, regions={**office.regions, "r2": smaller})))
    assert [(o.title, o.kind) for o in plan.outcomes] == [("rename r2 to Lab", "applied"), ("confirm r2", "conflict")]


def test_merged_rooms_may_have_grown_less(project: Project, office: RGMap) -> None:
    project.do(MergeRegions(regions=("r3", "r1")))
    small = replace(office.regions["r1"], boundary=((3.0, 0.0), (8.0, 0.0), (8.0, 2.0), (3.0, 2.0)))
    plan = plan_rerun(project, again(replace(office, regions={**office.regions, "r1": small})))
    assert plan.counts()["conflict"] == 0, plan.outcomes[0].reason
