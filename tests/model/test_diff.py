"""Diffs of maps whose differences are known; frames joined by scans, or by walls alone."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_rebase import moved_map, shuffled
from two_rooms import door, line, make_run, rectangle

from rgcore.errors import RgError
from rgcore.geometry import se2
from rgcore.model.align import align
from rgcore.model.diff import Diff, diff, join
from rgcore.model.diff_text import as_json, as_markdown, as_text
from rgcore.model.difference import Difference
from rgcore.model.draft import split_region
from rgcore.model.edits import ClassifyRegion, DeleteLines, LabelObject, MergeRegions, RenameRegion
from rgcore.model.records import Provenance, RGMap, replace
from rgcore.slam.trajectory import Trajectory

MOTION = st.tuples(st.floats(-40, 40), st.floats(-40, 40), st.floats(-3.1, 3.1))
FIXTURE = [HealthCheck.function_scoped_fixture]


@pytest.fixture
def floor() -> RGMap:
    """A floor without symmetry: rooms of many sizes along a hallway."""
    rng = np.random.default_rng(3)
    regions, lines, x = [rectangle("r1", "Hallway 1", "CDMA", (0, 0), (30, 2))], [], 0.0
    lines += [line("l1", (0.0, 0.0), (30.0, 0.0), "r1")]
    gateways = []
    for n in range(2, 8):
        w, d = float(rng.uniform(2.5, 6)), float(rng.uniform(2, 6))
        a, b, y = x, x + w, 2.1
        regions.append(rectangle(f"r{n}", f"Room {n}", "TOMA", (a, y), (b, y + d)))
        corners = [(a, y), (b, y), (b, y + d), (a, y + d)]
        lines += [line(f"l{n}{k}", corners[k], corners[(k + 1) % 4], f"r{n}") for k in range(4)]
        gateways.append(door(f"g{n}", ("r1", f"r{n}"), a + 1.2, 2.05))
        x = b + 0.1
    return RGMap(
        lines={v.id: v for v in lines}, regions={r.id: r for r in regions}, gateways={g.id: g for g in gateways}
    )


def told(found: Diff) -> list[tuple[str, str, tuple[str, ...], tuple[str, ...]]]:
    return [(d.kind, d.what, d.old, d.new) for d in found.differences]


def only(found: Diff, kind: str) -> Difference:
    (one,) = [d for d in found.differences if d.kind == kind]
    return one


def test_a_map_differs_in_nothing_from_itself(office: RGMap, floor: RGMap) -> None:
    for map in (office, floor):
        found = diff(map, map)
        assert not found
        assert found.differences == ()
        assert as_text(found).endswith("no difference")
        assert "No difference" in as_markdown(found)


@given(by=MOTION, seed=st.integers(0, 100))
@settings(max_examples=15, deadline=None, suppress_health_check=FIXTURE)
def test_nor_from_itself_moved_and_numbered_otherwise(floor: RGMap, by: tuple, seed: int) -> None:
    """No scan is known: the walls alone say how the frames lie."""
    found = diff(floor, moved_map(floor, by, shuffled(floor, seed)))
    assert told(found) == []
    assert np.allclose(found.new_from_old[:2], by[:2], atol=0.02)
    assert abs(math.remainder(found.new_from_old[2] - by[2], 2 * math.pi)) < 0.002
    assert "by their walls, 100 % of which fit" in found.frame


def test_maps_of_other_buildings_are_not_compared(floor: RGMap) -> None:
    star = {
        f"l{k}": line(f"l{k}", (9 * k, 0.3 * k), (9 * k + 3 * math.cos(k), 3 * math.sin(k)), "r1") for k in range(1, 12)
    }
    with pytest.raises(RgError, match="share no known scan and their walls do not fit: at best"):
        diff(floor, RGMap(lines=star))
    with pytest.raises(RgError, match="do not fit; compare maps of one building"):
        diff(floor, RGMap())
    assert align(floor, RGMap()) is None


def test_frames_are_joined_by_common_scans(office: RGMap) -> None:
    by = (1.0, -0.5, 0.3)
    old = make_run(office).trajectory
    new = Trajectory(old.stamps, se2.compose(np.array(by), old.map_from_base), old.base_from_laser)
    moved = moved_map(office, by)
    found = diff(office, moved, join(office, moved, old, new))
    assert found.frame == "joined by the scans that both hold"
    assert np.allclose(found.new_from_old, by, atol=1e-5)
    assert told(found) == []


def test_rooms_that_came_went_were_split_merged_or_called_otherwise(floor: RGMap) -> None:
    without = replace(floor, regions={k: v for k, v in floor.regions.items() if k != "r3"})
    assert told(diff(floor, without)) == [("regions", "removed", ("r3",), ())]
    assert told(diff(without, floor)) == [("regions", "added", (), ("r3",))]
    r = floor.regions["r4"]
    ((x0, y0), (x1, y1)) = r.boundary[0], r.boundary[2]
    split = split_region(floor, "r4", [((x0 + x1) / 2, y0), ((x0 + x1) / 2, y1)]).apply(floor)
    new = next(k for k in split.regions if k not in floor.regions)
    assert told(diff(floor, split)) == [("regions", "split", ("r4",), ("r4", new))]
    assert told(diff(split, floor)) == [("regions", "merged", ("r4", new), ("r4",))]
    called = ClassifyRegion(region="r5", class_="lab").apply(RenameRegion(region="r5", name="Lab").apply(floor))
    found = diff(floor, called)
    assert told(found) == [("regions", "reclassed", ("r5",), ("r5",)), ("regions", "renamed", ("r5",), ("r5",))]
    assert [d.text for d in found.differences] == ["r5 Lab: TOMA is lab now", "r5: Room 5 is called Lab now"]


def test_names_that_the_mapper_gave_anew_are_no_difference(floor: RGMap) -> None:
    other = replace(
        floor, regions={k: replace(r, name=f"Room {9 - i}") for i, (k, r) in enumerate(floor.regions.items())}
    )
    assert not diff(floor, other)


def test_a_merge_by_hand_is_told_with_its_door(office: RGMap) -> None:
    found = diff(office, MergeRegions(regions=("r1", "r2")).apply(office))
    assert [(w, o) for k, w, o, _ in told(found) if k == "regions"] == [("merged", ("r1", "r2"))]
    assert [(w, o) for k, w, o, _ in told(found) if k == "gateways"] == [("closed", ("g1",))]


def test_doors_open_close_move_and_change_their_kind(floor: RGMap) -> None:
    gates = dict(floor.gateways)
    del gates["g2"]
    gates["g9"] = door("g9", ("r1", "r4"), 29.0, 2.05)
    (ax, ay), (bx, by) = gates["g3"].posts
    gates["g3"] = replace(gates["g3"], posts=((ax + 0.4, ay), (bx + 0.4, by)))
    gates["g4"] = replace(gates["g4"], class_="opening", name="Main door")
    found = diff(floor, replace(floor, gateways=gates))
    assert sorted(told(found)) == [
        ("gateways", "closed", ("g2",), ()),
        ("gateways", "moved", ("g3",), ("g3",)),
        ("gateways", "opened", (), ("g9",)),
        ("gateways", "reclassed", ("g4",), ("g4",)),
        ("gateways", "renamed", ("g4",), ("g4",)),
    ]
    assert {d.what: d.colour for d in found.differences} == {
        "closed": "red", "moved": "amber", "opened": "green", "reclassed": "amber", "renamed": "amber"
    }  # fmt: skip
    assert next(d.amount for d in found.differences if d.what == "moved") == pytest.approx(0.4)


@pytest.mark.parametrize(("by", "is_told"), [(0.03, False), (0.15, True)])
def test_a_wall_moved_by_more_than_three_deviations_is_told(floor: RGMap, by: float, is_told: bool) -> None:
    """Residuals of 11 mm either side: three deviations are 5 cm."""
    v = floor.lines["l42"]
    moved = replace(v, start=(v.start[0], v.start[1] + by), end=(v.end[0], v.end[1] + by))
    found = diff(floor, replace(floor, lines={**floor.lines, "l42": moved}))
    assert told(found) == ([("lines", "moved", ("l42",), ("l42",))] if is_told else [])
    if is_told:
        assert only(found, "lines").amount == pytest.approx(by, abs=1e-3)
        assert "sigma" in only(found, "lines").text


def test_walls_that_came_and_went_are_counted_in_metres(floor: RGMap) -> None:
    gone = DeleteLines(lines=("l42",)).apply(floor)
    length = math.dist(floor.lines["l42"].start, floor.lines["l42"].end)
    found = diff(floor, gone)
    assert (found.walls_removed, found.walls_added) == (pytest.approx(length, abs=0.01), 0.0)
    assert told(found) == [("lines", "removed", ("l42",), ())]
    half = replace(floor.lines["l1"], end=(20.0, 0.0))
    found = diff(floor, replace(floor, lines={**floor.lines, "l1": half}))
    assert found.walls_removed == pytest.approx(10.0, abs=0.01)
    (piece,) = only(found, "lines").pieces
    assert np.allclose(piece, ((20.0, 0.0), (30.0, 0.0)), atol=1e-3)


def test_a_wall_in_two_pieces_is_the_same_wall(floor: RGMap) -> None:
    v = floor.lines["l1"]
    pieces = {"l1": replace(v, end=(14.9, 0.0)), "l99": replace(v, id="l99", start=(15.0, 0.0))}
    assert not diff(floor, replace(floor, lines={**floor.lines, **pieces}))


def test_objects_come_go_and_move(office: RGMap) -> None:
    o = office.objects["o1"]
    away = replace(o, center=(o.center[0] - 0.4, *o.center[1:]))
    assert told(diff(office, replace(office, objects={"o1": away}))) == [("objects", "moved", ("o1",), ("o1",))]
    assert told(diff(office, replace(office, objects={}))) == [("objects", "removed", ("o1",), ())]
    human = replace(
        LabelObject(object="o1", label="desk").apply(office).objects["o1"], provenance=Provenance(source="edited")
    )
    assert told(diff(office, replace(office, objects={"o1": human}))) == [("objects", "renamed", ("o1",), ("o1",))]


def test_a_diff_reads_as_text_markdown_and_json(floor: RGMap) -> None:
    new = RenameRegion(region="r5", name="Lab | *x*").apply(DeleteLines(lines=("l42",)).apply(floor))
    found = diff(floor, new)
    text = as_text(found)
    assert "Walls: 0.0 m added" in text
    assert "  - removed l42" in text
    assert "  ~ renamed r5: Room 5 is called Lab" in text
    rows = [row for row in as_markdown(found).splitlines() if "renamed r5" in row or "| renamed |" in row]
    assert rows[0].replace("\\|", "").count("|") == 5, "a name does not break the table"
    tree = json.loads(as_json(found))
    assert tree["differences"][0]["colour"] in ("green", "red", "amber")
    assert {d["what"] for d in tree["differences"]} == {"renamed", "removed"}


def test_on_the_command_line(
    tmp_path: Path, office: RGMap, run: SimpleNamespace, capsys: pytest.CaptureFixture[str]
) -> None:
    from rgcore.model.project import Project
    from rgviz.cli import main

    path = tmp_path / "office.rg"
    with Project.create(path, run) as project:
        assert project.outcomes == ()
        project.do(RenameRegion(region="r2", name="Lab"))
        project.add_run(run)
        assert [o.kind for o in project.outcomes] == ["applied"]
        project.undo()
    assert main(["diff", str(path / "runs" / "0001"), str(path)]) == 0
    assert "renamed r2: Lab is called Room 1 now" in capsys.readouterr().out
    assert main(["diff", str(path), str(path / "runs" / "0002"), "--markdown"]) == 0
    assert "No difference" in capsys.readouterr().out
    assert main(["export", str(path), str(tmp_path / "office.json")]) == 0
    capsys.readouterr()
    assert main(["diff", str(path), str(tmp_path / "office.json"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["differences"] == []
    assert main(["diff", str(path), str(tmp_path / "none.rg")]) == 1
    assert "there is no such project" in capsys.readouterr().err


@pytest.mark.parametrize("by", [0.08, 0.15, 0.18, 0.2, 0.25, 0.29, 0.35, 1.0])
def test_a_wall_that_moved_is_told_however_far(floor: RGMap, by: float) -> None:
    v = floor.lines["l21"]
    (x0, y0), (x1, y1) = v.start, v.end
    moved = replace(v, start=(x0 - by, y0), end=(x1 - by, y1))
    found = told(diff(floor, replace(floor, lines={**floor.lines, "l21": moved})))
    near, far = [("lines", "moved")], [("lines", "removed"), ("lines", "added")]
    assert [(kind, what) for kind, what, *_ in found] in (near, far), found
