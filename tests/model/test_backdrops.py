"""Floor plans under a map: laid in its middle, aligned by points, kept by the project, undone, carried to a new run."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from two_rooms import make_run

from rgcore.errors import EditError, InputError, ProjectError
from rgcore.exports.formats import FORMATS, exported
from rgcore.exports.options import Options
from rgcore.exports.rgjson import read_json, render
from rgcore.model.backdrops import corners, laid, placed, title
from rgcore.model.edits import AlignBackdrop, DeleteBackdrop
from rgcore.model.edits_backdrops import aligned
from rgcore.model.project import Project
from rgcore.model.records import RGMap, replace

sys.path.append(str(Path(__file__).parents[1] / "scans"))

from make_plans import WALLS, drawing, image

PLACE = st.tuples(*[st.floats(-50, 50).map(lambda v: round(v, 3))] * 2)


def with_plan(map_: RGMap, data: bytes | None = None) -> tuple[RGMap, str]:
    edit = laid(map_, data or image(), "plan.png")
    return edit.apply(map_), edit.id


def test_a_plan_lies_in_the_middle_as_large_as_it_says_else_as_the_map(office: RGMap) -> None:
    bounds = np.array([p for r in office.regions.values() for p in r.boundary])
    low, high = bounds.min(0), bounds.max(0)
    map_, id = with_plan(office)
    spread = corners(map_.backdrops[id])
    np.testing.assert_allclose(spread.mean(0), (low + high) / 2)
    assert np.ptp(spread, axis=0).max() == pytest.approx((high - low).max())
    map_, id = with_plan(office, drawing())
    np.testing.assert_allclose(np.ptp(corners(map_.backdrops[id]), axis=0), np.ptp(WALLS, axis=0), atol=1e-6)
    assert map_.backdrops[id].scale == pytest.approx(1.0)
    assert laid(RGMap(), image(), "a").length > 0


@given(a=PLACE, b=PLACE, c=PLACE, d=PLACE)
def test_two_pairs_bring_both_points_to_where_they_belong(a: tuple, b: tuple, c: tuple, d: tuple) -> None:
    map_, id = with_plan(RGMap())
    before = map_.backdrops[id]
    pairs = [(a, b), (c, d)]
    if min(np.hypot(*np.subtract(a, c)), np.hypot(*np.subtract(b, d))) < 0.1:
        return
    if not 0.01 <= before.length * np.hypot(*np.subtract(b, d)) / np.hypot(*np.subtract(a, c)) <= 1e5:
        return
    on_plan = [_on_plan(before, p) for p, _ in pairs]
    try:
        after = aligned(map_, id, pairs).apply(map_).backdrops[id]
    except EditError:  # a wild pair throws the middle of the plan out of the world
        by = complex(*np.subtract(d, b)) / complex(*np.subtract(c, a))
        assert abs(complex(*b) + by * complex(*np.subtract(before.center, a))) > 99_000
        return
    reach = max(1.0, np.abs(on_plan).max() * after.scale)
    np.testing.assert_allclose([placed(after, p) for p in on_plan], [b, d], atol=1e-5 * reach)


def _on_plan(plan: object, at: tuple) -> np.ndarray:
    c, s = np.cos(plan.yaw), np.sin(plan.yaw)  # type: ignore[attr-defined]
    return (np.subtract(at, plan.center) @ np.array([[c, -s], [s, c]])) / plan.scale  # type: ignore[attr-defined]


def test_one_pair_shifts_and_points_that_are_one_are_refused(office: RGMap) -> None:
    map_, id = with_plan(office)
    plan = map_.backdrops[id]
    moved = aligned(map_, id, [((1.0, 1.0), (3.0, 0.0))]).apply(map_).backdrops[id]
    assert moved.center == pytest.approx((plan.center[0] + 2, plan.center[1] - 1))
    assert (moved.length, moved.yaw) == (plan.length, plan.yaw)
    for pairs in ([((1, 1), (2, 2)), ((1, 1), (4, 4))], [((1, 1), (2, 2)), ((3, 1), (2, 2))], []):
        with pytest.raises(EditError):
            aligned(map_, id, pairs)
    with pytest.raises(EditError, match="no floor plan bu99"):
        aligned(map_, "bu99", [((1, 1), (2, 2))])


def test_a_name_is_never_a_path() -> None:
    assert title("../../etc/passwd") == "passwd"
    assert title("C:\\plans\\floor 1.png") == "floor 1.png"
    assert title("a\x00b\n\u202e.png") == "ab.png"
    assert title("/") == title("") == title("  ") == "plan"
    assert len(title("x" * 500)) == 80


def test_a_project_keeps_the_plan_through_restart_undo_and_a_new_run(office: RGMap, tmp_path: Path) -> None:
    run = make_run(office)
    with Project.create(tmp_path / "a.rg", run) as project:
        edit = project.add_backdrop(image(), "../plan.png")
        project.do(aligned(project.map, edit.id, [((0, 0), (1, 1)), ((4, 0), (5, 1.5))]))
        lies = project.map.backdrops[edit.id]
        assert lies.name == "plan.png"
        assert lies.provenance.source == "human"
        project.undo()
        assert project.map.backdrops[edit.id].yaw == 0
        project.redo()
    files = [p for p in (tmp_path / "a.rg").rglob("*") if p.is_file() and p.read_bytes() == image()]
    assert [p.name for p in files] == [lies.sha256]
    with Project.open(tmp_path / "a.rg") as project:
        assert project.map.backdrops[edit.id] == lies
        assert project.backdrop(lies.sha256) == image()
        project.add_run(run)
        carried = project.map.backdrops[edit.id]
        assert replace(carried, provenance=lies.provenance) == lies
        assert project.backdrop(carried.sha256) == image()
        project.do(DeleteBackdrop(backdrop=edit.id))
        assert project.map.backdrops == {}
        project.undo()
        assert edit.id in project.map.backdrops


def test_a_refused_plan_leaves_nothing_behind(office: RGMap, tmp_path: Path) -> None:
    with Project.create(tmp_path / "a.rg", make_run(office)) as project:
        with pytest.raises(InputError, match=r"plan\.png: no floor plan"):
            project.add_backdrop(b"hello", "plan.png")
        assert not (tmp_path / "a.rg" / "backdrops").exists()
        with pytest.raises(ProjectError, match="lay the plan under the map again"):
            project.backdrop("0" * 64)
        with pytest.raises(ProjectError, match="cannot be read"):
            project.backdrop("../current")
        edit = project.add_backdrop(image(), "plan.png")
        (tmp_path / "a.rg" / "backdrops" / edit.sha256).write_bytes(b"other")
        with pytest.raises(ProjectError, match="is not the plan"):
            project.backdrop(edit.sha256)
        with pytest.raises(EditError, match="length must be the metres"):
            project.do(AlignBackdrop(backdrop=edit.id, center=(0, 0), yaw=0, length=0))


def test_json_keeps_where_the_plan_lies_and_every_format_says_what_it_lacks(office: RGMap) -> None:
    map_, _ = with_plan(office)
    assert read_json(render(map_, None, Options()).data).backdrops == map_.backdrops
    for ending in FORMATS:
        if ending != ".tum":
            lost = " ".join(exported(ending, map_).lost)
            assert "floor plans" in lost, ending
            assert "floor plans" not in " ".join(exported(ending, office).lost)
