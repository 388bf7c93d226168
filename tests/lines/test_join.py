"""Lines made one where the readings do not need two, and only there."""

from __future__ import annotations

import numpy as np

from rgcore.geometry import segments as geometry
from rgcore.geometry.raycast import cast
from rgcore.lines.join import joined
from rgcore.lines.worth import Sights

BEARINGS = np.deg2rad(np.arange(-90.0, 91.0))
EYES = np.column_stack([np.zeros(9), np.linspace(-2, 2, 9), np.zeros(9)])
WALL = np.array([[[3.0, -4.0], [3.0, 4.0]]])[:, ::-1]
STEP = np.array([[[3.0, 0.0], [3.0, -4.0]], [[3.3, 4.0], [3.3, 0.0]]])
HALVES = np.array([[[3.0, 4.0], [3.01, 0.1]], [[2.99, -0.1], [3.0, -4.0]]])
ONE_ROOM = np.zeros(2, int)


def sights(world: np.ndarray) -> Sights:
    ranges = cast(world, EYES, BEARINGS, 20.0)[0]
    return Sights(EYES, BEARINGS, np.where(np.isfinite(ranges), ranges, 0.0))


def test_a_wall_in_two_pieces_is_one() -> None:
    lines, of, name = joined(sights(WALL), HALVES, np.arange(2), ONE_ROOM, 20.0)
    assert len(lines) == 1
    assert geometry.lengths(lines) > 7.9
    assert np.abs(lines[0, :, 0] - 3.0).max() < 0.02
    assert lines[0, 0, 1] > lines[0, 1, 1]  # free space stays on its left
    assert of.tolist() == [0]
    assert name.tolist() == [0, 0]


def test_a_step_that_readings_show_stays() -> None:
    lines, of, _ = joined(sights(STEP), STEP, np.arange(2), ONE_ROOM, 20.0)
    assert len(lines) == 2
    assert of.tolist() == [0, 1]


def test_a_wall_of_two_regions_stays_two() -> None:
    assert len(joined(sights(WALL), HALVES, np.arange(2), np.array([0, 1]), 20.0)[0]) == 2


def test_lines_of_scattered_echoes_join_those_of_any_region() -> None:
    lines, of, name = joined(sights(WALL), HALVES, np.array([1, 2]), np.array([0, 1]), 20.0)
    assert len(lines) == 1
    assert of.tolist() == [1]
    assert name.tolist() == [0, 1, 1]


def test_an_opening_that_beams_pass_is_not_closed() -> None:
    door = HALVES + np.array([[[0, 0], [0, 0.08]], [[0, -0.08], [0, 0]]])
    room = np.concatenate([door, [[[8.0, 4.0], [8.0, -4.0]]]])  # behind which beams end
    assert len(joined(sights(room), door, np.arange(2), ONE_ROOM, 20.0)[0]) == 2


def test_nothing_joins_nothing() -> None:
    lines, of, name = joined(sights(WALL), WALL[:0], np.zeros(0, int), np.zeros(0, int), 20.0)
    assert len(lines) == len(of) == len(name) == 0
