"""Proposals of a class that a person gave to some regions."""

from __future__ import annotations

from pathlib import Path

import pytest
from two_rooms import make_run

from rgcore.errors import EditError
from rgcore.model.edits import ClassifyRegion, Confirm
from rgcore.model.project import Project
from rgcore.model.records import Box2, Region, RGMap
from rgcore.model.similar import own_classes, propose
from rgviz.cli import main


def square(id: str, size: float, at: float) -> Region:
    corners = ((at, 0.0), (at + size, 0.0), (at + size, size), (at, size))
    return Region(
        id=id,
        name=id,
        class_="TOMA",
        class_scores={"TOMA": 0.9, "CC": 0.1},
        boundary=corners,
        box=Box2(center=(at + size / 2, size / 2), size=(size - 0.4, size - 0.4), yaw=0.0),
    )


@pytest.fixture
def floor() -> RGMap:
    """Six closets and twelve halls."""
    sizes = [1.5 + 0.05 * k for k in range(6)] + [6.0 + 0.3 * k for k in range(12)]
    regions = [square(f"r{k + 1}", size, 12.0 * k) for k, size in enumerate(sizes)]
    return RGMap(regions={r.id: r for r in regions})


def classed(map: RGMap, *ids: str) -> RGMap:
    for id in ids:
        map = ClassifyRegion(region=id, class_="closet").apply(map)
    return map


def test_the_other_closets_are_proposed_and_no_hall(floor: RGMap) -> None:
    found = propose(classed(floor, "r1", "r6", "r3"), "closet")
    assert {p.region for p in found} == {"r2", "r4", "r5"}
    assert [p.score for p in found] == sorted((p.score for p in found), reverse=True)
    assert all(0.5 <= p.score < 1 for p in found)


def test_accepted_proposals_class_the_regions(floor: RGMap) -> None:
    map = classed(floor, "r1", "r6", "r3")
    for p in propose(map, "closet"):
        map = p.edit.apply(map)
    assert own_classes(map) == {"closet": 6}
    assert propose(map, "closet") == []


def test_what_a_person_confirmed_is_not_proposed(floor: RGMap) -> None:
    map = Confirm(items=("r2",)).apply(classed(floor, "r1", "r6", "r3"))
    assert "r2" not in {p.region for p in propose(map, "closet")}


def test_examples_of_another_map_count(floor: RGMap) -> None:
    other = classed(floor, "r1", "r3", "r6")
    assert {f"r{k}" for k in range(1, 7)} >= {p.region for p in propose(floor, "closet", [other])} != set()


@pytest.mark.parametrize("ids", [(), ("r1",)])
def test_too_few_examples_are_refused_with_the_remedy(floor: RGMap, ids: tuple[str, ...]) -> None:
    with pytest.raises(EditError, match="give that class to at least 2"):
        propose(classed(floor, *ids), "closet")


def test_the_command_line_proposes_and_then_makes_edits(
    floor: RGMap, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "floor.rg"
    Project.create(path, make_run(classed(floor, "r1", "r6", "r3"))).close()
    assert main(["classes", str(path), "--learn", "closet"]) == 0
    assert "3 regions proposed as closet" in capsys.readouterr().out
    assert main(["classes", str(path), "--learn", "closet", "--apply"]) == 0
    assert main(["classes", str(path)]) == 0
    assert capsys.readouterr().out.endswith("closet: 6 regions\n")
    assert main(["classes", str(path), "--learn", "kitchen"]) == 1
    assert "give that class to at least 2" in capsys.readouterr().err
