"""Review: the state of items, going back to what the mapper made, several edits as one, notes."""

from __future__ import annotations

from types import SimpleNamespace

import msgspec
import pytest
from two_rooms import make_run

from rgcore.errors import EditError
from rgcore.geometry import se2
from rgcore.model.checks import broken
from rgcore.model.edits import (
    AddNote,
    ClassifyRegion,
    Confirm,
    ConfirmObject,
    DeleteGateway,
    DeleteNote,
    DeleteRegion,
    Edit,
    HeedFinding,
    IgnoreFinding,
    LabelObject,
    MergeRegions,
    RenameRegion,
    ReshapeRegion,
    RevertToAutomatic,
    SeedObject,
    Several,
    SplitRegion,
    Unconfirm,
    decode_edit,
)
from rgcore.model.history import Do, History, Undo, step
from rgcore.model.project import Project
from rgcore.model.rebase import ids_of
from rgcore.model.records import Provenance, RGMap, replace
from rgcore.slam.trajectory import Trajectory

AT = "2026-01-01T00:00:00Z"


def made(base: RGMap, *edits: Edit) -> History:
    history = History.of(base)
    for number, edit in enumerate(edits, 1):
        history = step(history, Do(number=number, at=AT, by="ann", edit=edit))  # type: ignore[arg-type]
    return history


def bare(map: RGMap) -> RGMap:
    """The map without provenance."""
    kinds = ("lines", "regions", "gateways", "objects")
    return replace(
        map,
        **{k: {id: replace(v, provenance=Provenance()) for id, v in sorted(getattr(map, k).items())} for k in kinds},
    )


def test_what_was_confirmed_stays_automatic(office: RGMap) -> None:
    history = made(office, Confirm(items=("r1", "g1")), ClassifyRegion(region="r2", class_="CC"))
    p = history.map.regions["r1"].provenance
    assert (p.source, p.confirmed, p.by, p.edits) == ("auto", True, "ann", (1,))
    assert not history.map.regions["r2"].provenance.confirmed
    assert not made(office, Confirm(items=("r1",)), Unconfirm(items=("r1",))).map.regions["r1"].provenance.confirmed


def test_a_confirmed_item_that_is_edited_stays_confirmed(office: RGMap) -> None:
    p = made(office, Confirm(items=("r1",)), RenameRegion(region="r1", name="Flur")).map.regions["r1"].provenance
    assert (p.source, p.confirmed, p.edits) == ("edited", True, (1, 2))


def test_a_confirmed_object_is_sure(office: RGMap) -> None:
    o = made(office, ConfirmObject(object="o1")).map.objects["o1"]
    assert (o.confidence, o.provenance.confirmed, o.provenance.source) == (1.0, True, "edited")


def test_what_changes_as_a_consequence_says_by_which_edit(office: RGMap) -> None:
    map = made(office, MergeRegions(regions=("r1", "r2"))).map
    for item in (map.regions["r1"], map.lines["l3"]):
        assert (item.provenance.source, item.provenance.edits) == ("edited", (1,))
    assert map.gateways["g2"].provenance == Provenance(), "it joins r1 as before"


CHANGES: list[tuple[str, tuple[Edit, ...]]] = [
    ("r3", (ClassifyRegion(region="r3", class_="CC"), RenameRegion(region="r3", name="Lab"))),
    ("g1", (DeleteGateway(gateway="g1"),)),
    ("o1", (LabelObject(object="o1", label="x"), Confirm(items=("o1",)))),
    ("r2", (ReshapeRegion(region="r2", boundary=((0.0, 2.1), (3.0, 2.1), (3.0, 6.0), (0.0, 6.0))),)),
]


@pytest.mark.parametrize(("item", "edits"), CHANGES)
def test_an_item_goes_back_to_what_the_mapper_made(office: RGMap, item: str, edits: tuple[Edit, ...]) -> None:
    history = made(office, *edits, RevertToAutomatic(item=item))
    assert bare(history.map) == bare(office)
    for kind in ("regions", "gateways", "objects"):
        if item in getattr(history.map, kind):
            p = getattr(history.map, kind)[item].provenance
            assert (p.source, p.confirmed, p.edits[-1]) == ("auto", False, len(edits) + 1)
    history = step(history, Undo(number=99, at=AT))
    assert history.map == made(office, *edits).map


def test_a_deleted_region_comes_back_and_then_its_gateway(office: RGMap) -> None:
    history = made(office, DeleteRegion(region="r3"))
    with pytest.raises(EditError, match="g2 joins r3, which is not in the map; bring that back first"):
        RevertToAutomatic(item="g2").apply(history.map, office)
    map = made(office, DeleteRegion(region="r3"), RevertToAutomatic(item="r3"), RevertToAutomatic(item="g2")).map
    assert map.regions["r3"].boundary == office.regions["r3"].boundary
    assert map.gateways["g2"].regions == ("r1", "r3")
    assert map.lines["l4"].regions == ("r3",), "the ground has its lines again"
    assert broken(map) == []


def test_what_would_not_fit_any_more_is_refused(office: RGMap) -> None:
    split = made(office, SplitRegion(region="r1", cut=((5.0, 0.5), (5.0, 1.5)), id="ru00000001")).map
    with pytest.raises(EditError, match="r1 would lie over ru00000001; delete or revert that first"):
        RevertToAutomatic(item="r1").apply(split, office)
    with pytest.raises(EditError, match="ru00000001 was made by a person; there is no automatic one"):
        RevertToAutomatic(item="ru00000001").apply(split, office)
    with pytest.raises(EditError, match="there is no r77 in this map"):
        RevertToAutomatic(item="r77").apply(office, office)


def test_after_a_new_run_automatic_means_the_new_map(tmp_path: object, office: RGMap, run: SimpleNamespace) -> None:
    """The edit is carried by the id, not with a copy of the old record."""
    with Project.create(tmp_path / "office.rg", run) as project:  # type: ignore[operator]
        project.do(ClassifyRegion(region="r3", class_="CC"))
        project.do(RevertToAutomatic(item="r3"))
        project.do(Several(name="tidy", edits=(RenameRegion(region="r2", name="Lab"), Confirm(items=("r2", "l3")))))
        new = replace(office, regions={**office.regions, "r3": replace(office.regions["r3"], class_="ODMA")})
        again = make_run(new)
        again.trajectory = Trajectory(
            run.trajectory.stamps,
            se2.compose([0.0, 0.0, 0.0], run.trajectory.map_from_base),
            run.trajectory.base_from_laser,
        )
        assert project.add_run(again) == ()
        r2, r3 = project.map.regions["r2"], project.map.regions["r3"]
        assert (r3.class_, r3.provenance.source) == ("ODMA", "auto")
        assert (r2.name, r2.provenance.confirmed) == ("Lab", True)


def test_several_edits_are_one_step_or_none(office: RGMap) -> None:
    good = RenameRegion(region="r2", name="Lab"), DeleteGateway(gateway="g1")
    history = made(office, Several(name="tidy up", edits=good))
    assert (history.map.regions["r2"].name, list(history.map.gateways)) == ("Lab", ["g2"])
    assert history.undo_title == "tidy up"
    assert step(history, Undo(number=2, at=AT)).map == office
    with pytest.raises(EditError, match=r"^edit 3 of 3: there is no gateway g1 in this map$"):
        made(office, Several(name="tidy up", edits=(*good, DeleteGateway(gateway="g1"))))
    assert ids_of(Several(name="tidy up", edits=good)) == {"r2", "g1"}


@pytest.mark.parametrize(
    ("edits", "words"),
    [
        ([], "edits must be 1 to 10000 single edits"),
        ([{"edit": "RenameRegion", "region": "r1", "name": ""}], "name must be a name of 1 to 80 characters"),
        (
            [{"edit": "Confirm", "items": ["r1"]}, {"edit": "Explode"}],
            "edit 2 of 2: unknown edit 'Explode'; known are ClassifyRegion",
        ),
        ([{"edit": "Several", "title": "x", "edits": [{"edit": "Confirm", "items": ["r1"]}]}], "single edits|Several"),
        ("r1", "edits must be 1 to 10000 single edits"),
    ],
)
def test_several_say_which_of_them_is_wrong(edits: object, words: str) -> None:
    with pytest.raises(EditError, match=words):
        decode_edit(msgspec.json.encode({"edit": "Several", "title": "all", "edits": edits}))


def test_a_note_outlives_its_item(office: RGMap) -> None:
    note = AddNote(id="nu00000001", text="door is always shut", place=(2.0, 2.05), item="g1")
    history = made(office, note, DeleteGateway(gateway="g1"))
    left = history.map.notes["nu00000001"]
    assert (left.item, left.place, left.provenance.source, left.provenance.edits) == (
        None,
        (2.0, 2.05),
        "human",
        (1, 2),
    )
    assert made(office, note, DeleteNote(note="nu00000001")).map.notes == {}
    with pytest.raises(EditError, match="there is no g9 in this map"):
        made(office, AddNote(id="nu00000001", text="x", place=(0.0, 0.0), item="g9"))
    for text in ("", "  \n ", "x" * 1001, "a\x00b"):
        with pytest.raises(EditError, match="text must be a text of 1 to 1000 characters"):
            AddNote(id="nu00000001", text=text, place=(0.0, 0.0)).apply(office)


def test_an_ignored_finding_is_kept_until_its_item_goes(office: RGMap) -> None:
    ignore = IgnoreFinding(code="narrow-gateway", items=("g1",))
    map = made(office, ignore).map
    assert list(map.ignored) == ["narrow-gateway:g1"]
    assert HeedFinding(code="narrow-gateway", items=("g1",)).apply(map).ignored == {}
    assert DeleteGateway(gateway="g1").apply(map).ignored == {}


def test_a_seed_is_a_persons_and_cannot_be_reverted(office: RGMap) -> None:
    seed = SeedObject(id="ou00000001", lines=("l6",), center=(1.0, 1.0, 0.5), size=(1.0, 1.0, 1.0), yaw=0.0)
    with pytest.raises(EditError, match="made by a person"):
        made(office, seed, RevertToAutomatic(item="ou00000001"))
