"""The cost of correcting, on the demo building: the script that counts it makes the edits that a person would."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rgcore.model.draft import split_region
from rgcore.model.edits import DeleteGateway, DeleteRegion, Edit, MergeRegions, MoveGateway
from rgcore.model.records import RGMap
from rgcore.pipeline import Run
from rgviz.demo import POSES, ROOMS, TRUTH

sys.path.insert(0, str(Path(__file__).parent / "bench"))
from correcting import Corrected, Truth, correct


@pytest.fixture(scope="module")
def truth(office: Run) -> Truth:
    mine, true = office.trajectory.map_from_laser[:, :2], np.loadtxt(POSES)[:, 1:3]
    flat = [np.c_[p - p.mean(0), np.zeros(len(p))] for p in (true, mine)]
    turn = Rotation.align_vectors(*flat)[0].as_matrix()[:2, :2]
    return Truth.of(TRUTH, ROOMS, turn, true.mean(0) - turn @ mine.mean(0))


@pytest.fixture(scope="module")
def right(office: Run, truth: Truth) -> Corrected:
    return correct(office.map, truth)


def kinds(edits: list[Edit]) -> list[str]:
    return sorted(type(e).__name__ for e in edits)


def test_the_demo_needs_less_than_three_edits_for_ten_rooms(right: Corrected, truth: Truth) -> None:
    assert len(right.edits) < 0.3 * len(truth.ids)
    assert right.after.faults == 0


def test_the_edits_are_counted_that_were_made(office: Run, right: Corrected, truth: Truth) -> None:
    again = office.map
    for edit in right.edits + right.classes:
        again = edit.apply(again)
    assert again == right.map
    assert truth.cost(again).faults == right.after.faults


def damaged(map_: RGMap, truth: Truth) -> dict[str, RGMap]:
    """The right map with one fault of each sort."""
    door = next(
        g for g in map_.gateways.values() if g.width < 1.2 and truth.gateways[truth.doors(map_)[g.id]]["passed"]
    )
    room = min(door.regions, key=lambda id: truth.covered(map_.regions[id]).sum())
    (ax, ay), (bx, by) = door.posts
    away = ((ax + 1.5, ay + 1.0), (bx + 1.5, by + 1.0))
    x, y = map_.regions[room].box.center
    return {
        "no door": DeleteGateway(gateway=door.id).apply(map_),
        "door elsewhere": MoveGateway(gateway=door.id, posts=away).apply(map_),
        "two rooms in one": MergeRegions(regions=door.regions).apply(map_),
        "room in two": split_region(map_, room, [(x - 0.3, y), (x + 0.3, y)]).apply(map_),
        "no room": DeleteRegion(region=room).apply(map_),
    }


@pytest.mark.parametrize(
    ("fault", "remedy"),
    [
        ("no door", ["AddGateway"]),
        ("door elsewhere", ["MoveGateway"]),
        ("two rooms in one", ["SplitRegion"]),
        ("room in two", ["MergeRegions"]),
        ("no room", ["AddGateway", "AddRegion"]),
    ],
)
def test_each_fault_costs_what_a_person_would_do(right: Corrected, truth: Truth, fault: str, remedy: list[str]) -> None:
    wrong = damaged(right.map, truth)[fault]
    assert truth.cost(wrong).faults > 0
    done = correct(wrong, truth)
    assert done.after.faults == 0
    assert kinds(done.edits) == remedy
