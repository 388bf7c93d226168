"""Things that stand in one room, surveyed from a way around it: what is found of them, and what is not."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from building import BEARINGS, block, chain
from hypothesis import given, settings
from hypothesis import strategies as st

from rgcore.config import Config
from rgcore.geometry.raycast import cast
from rgcore.lines.merge import Lines, merge_lines
from rgcore.places.freespace import FreeSpace, free_space
from rgcore.places.objects import FoundObject, find_objects
from rgcore.places.places import Places
from rgcore.places.regions import find_places, region_of_segments
from rgcore.scans.extract import extract
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

ROOM = chain((0, 0), (8, 0), (8, 6), (0, 6), (0, 0))
AROUND = ((1.5, 1.5), (6.5, 1.5), (6.5, 4.5), (1.5, 4.5), (1.5, 1.5))
C = Config()
Seen = tuple[Lines, Places, FreeSpace]


def turned_block(x: float, y: float, w: float, h: float, yaw: float) -> list[list[tuple[float, float]]]:
    c, s = math.cos(yaw), math.sin(yaw)
    corners = [(-w / 2, -h / 2), (w / 2, -h / 2), (w / 2, h / 2), (-w / 2, h / 2)]
    ring = [(x + c * a - s * b, y + s * a + c * b) for a, b in [*corners, corners[0]]]
    return chain(*ring)


def survey(things: list[list[tuple[float, float]]], stops: tuple[tuple[float, float], ...] = AROUND) -> Seen:
    """Lines, places and free space of the room with things in it."""
    legs = [np.linspace(a, b, 12, endpoint=False) for a, b in itertools.pairwise(np.array(stops))]
    at = np.concatenate(legs)
    poses = np.c_[at, 0.7 * np.arange(len(at)) % 6]
    ranges = cast(np.array(ROOM + things, float), poses, BEARINGS, 30.0)[0]
    ranges = ranges + np.random.default_rng(1).normal(0, 0.012, ranges.shape)
    stamps = np.arange(len(poses), dtype=float)
    log = ScanLog(stamps, ranges, poses, BEARINGS, np.zeros(3), 30.0)
    trajectory = Trajectory(stamps, poses, np.zeros(3))
    segments = extract(log, C.extract)
    free = free_space(log, trajectory, C.places)
    places = find_places(free, log, trajectory, segments, C.places)
    lines, _ = merge_lines(segments, trajectory, region_of_segments(segments, trajectory, places), C.lines)
    return lines, places, free


def objects_of(seen: Seen) -> tuple[FoundObject, ...]:
    return find_objects(*seen, C.objects)


def test_an_empty_room_holds_nothing() -> None:
    assert objects_of(survey([])) == ()


@settings(max_examples=12, deadline=None)
@given(st.floats(3.4, 4.6), st.floats(2.8, 3.2), st.floats(0.5, 1.6), st.floats(0.4, 0.9), st.floats(0, 3.1))
def test_a_box_in_the_middle_is_found_as_it_stands(x: float, y: float, w: float, h: float, yaw: float) -> None:
    found = objects_of(survey(turned_block(x, y, w, h, yaw)))
    assert len(found) == 1
    box = found[0]
    assert box.label == "box"
    assert box.center[:2] == pytest.approx((x, y), abs=0.06)
    assert sorted(box.size[:2]) == pytest.approx(sorted((w, h)), abs=0.1)
    assert box.confidence > 0.8
    assert len(box.lines) >= 3


def test_two_cabinets_side_by_side_are_two() -> None:
    found = objects_of(survey([*block(2, 0, 3.2, 0.45), *block(3.2, 0, 4.6, 0.6)]))
    assert len(found) == 2
    for want in ((2.6, 0.225), (3.9, 0.3)):
        assert min(math.dist(o.center[:2], want) for o in found) < 0.12
    assert {o.label for o in found} == {"cabinet"}


def test_a_cabinet_in_a_corner_shows_two_faces() -> None:
    (found,) = objects_of(survey(block(7.2, 0, 8, 0.5)))
    assert found.center[:2] == pytest.approx((7.6, 0.25), abs=0.1)
    assert sorted(found.size[:2]) == pytest.approx((0.5, 0.8), abs=0.12)


def test_a_free_standing_wall_is_no_object() -> None:
    assert objects_of(survey(block(2, 2.95, 6, 3.05))) == ()


def test_no_line_is_in_two_objects_and_confidence_falls_with_what_is_hidden() -> None:
    things = [*turned_block(3, 3, 1.2, 0.6, 0.3), *block(5, 2.7, 5.6, 3.4), *block(0, 2, 0.4, 3)]
    around, aside = survey(things), survey(things, ((5.2, 1.2), (5.4, 1.2)))
    for seen in (around, aside):
        used = [k for o in objects_of(seen) for k in o.lines]
        assert len(used) == len(set(used))
    middle = [
        max((o.confidence for o in objects_of(s) if math.dist(o.center[:2], (5.3, 3.05)) < 0.4), default=0.0)
        for s in (around, aside)
    ]
    assert middle[0] > middle[1]


def legs(x: float, y: float, w: float, h: float, yaw: float) -> list[list[tuple[float, float]]]:
    c, s = math.cos(yaw), math.sin(yaw)
    corners = [(sx * w / 2, sy * h / 2) for sx in (-1, 1) for sy in (-1, 1)]
    return [side for a, b in corners for side in turned_block(x + c * a - s * b, y + s * a + c * b, 0.06, 0.06, yaw)]


@pytest.mark.parametrize(("w", "h", "yaw"), [(1.4, 0.7, 0.0), (1.6, 0.8, 0.5), (0.8, 0.8, 1.1)])
def test_four_legs_are_a_table(w: float, h: float, yaw: float) -> None:
    (table,) = objects_of(survey(legs(4.0, 3.0, w, h, yaw)))
    assert table.label == "table"
    assert table.center[:2] == pytest.approx((4, 3), abs=0.08)
    assert sorted(table.size[:2]) == pytest.approx(sorted((w, h)), abs=0.1)
    assert table.region == 0


def test_three_legs_and_a_chair_are_no_table() -> None:
    assert objects_of(survey([*legs(3, 3, 1.4, 0.7, 0.2)[:12], *legs(5.5, 3, 0.3, 0.3, 0.4)])) == ()
