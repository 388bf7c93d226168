"""What lines are worth, on rooms whose ranges are known."""

from __future__ import annotations

import numpy as np
import pytest

from rgcore.geometry.raycast import cast
from rgcore.lines.worth import Sights

BEARINGS = np.deg2rad(np.arange(-90.0, 91.0))
ROOM = np.array([[[-4, -3], [4, -3]], [[4, -3], [4, 3]], [[4, 3], [-4, 3]], [[-4, 3], [-4, -3]]], float)
GHOST = np.array([[[-1, 1], [1, 1]]], float)
POSES = np.array([[x, 0.0, turn] for x in (-2.0, 0.0, 2.0) for turn in (0.0, np.pi / 2, np.pi, -np.pi / 2)])


def sights(*lines: np.ndarray, world: np.ndarray = ROOM) -> Sights:
    out, number = Sights(POSES, BEARINGS, cast(world, POSES, BEARINGS, 50.0)[0]), 0
    for some in lines:
        out.add(some, number)
        number += len(some)
    return out


def test_beams_meet_what_casting_meets() -> None:
    s = sights(ROOM)
    assert s.distance[:, 0] == pytest.approx(s.ranges.ravel(), abs=1e-4)
    assert not s.unexplained(np.ones(4, bool)).any()


def test_a_true_line_stays_and_a_false_one_before_it_goes() -> None:
    there = sights(ROOM, GHOST).keep(np.ones(5, bool), 1.0)
    assert there.tolist() == [True] * 4 + [False]


def test_of_two_that_say_the_same_one_stays() -> None:
    there = sights(ROOM, ROOM + 0.01).keep(np.ones(8, bool), 1.0)
    assert (there[:4] | there[4:]).all()
    assert there.sum() == 4


def test_false_lines_behind_one_another_go_all() -> None:
    there = sights(ROOM, GHOST, GHOST - [0, 0.3], GHOST - [0, 0.6]).keep(np.ones(7, bool), 1.0)
    assert there.tolist() == [True] * 4 + [False] * 3


def test_the_price_is_in_readings() -> None:
    pillar = np.array([[[1.0, 1.0], [1.2, 1.0]]])
    world = np.concatenate([ROOM, pillar])
    s = sights(world, world=world)
    told = int((np.abs(s.distance[:, 0] - s.ranges.ravel()) < 0.01).sum())
    assert told == s.ranges.size
    worth = int((s.line[:, 0] == 4).sum())  # all of them would be metres off without it
    assert sights(world, world=world).keep(np.ones(5, bool), worth - 0.5)[4]
    assert not sights(world, world=world).keep(np.ones(5, bool), worth + 0.5)[4]


def test_the_least_worth_go_for_few_lines_up_to_the_highest_price() -> None:
    pillar = np.array([[[1.0, 1.0], [1.2, 1.0]]])
    world = np.concatenate([ROOM, pillar])
    assert sights(world, world=world).few(5, 1.0, 4, 1e9).tolist() == [True] * 4 + [False]
    assert sights(world, world=world).few(5, 1.0, 4, 1.0).all()


def test_lines_are_cut_to_what_is_there() -> None:
    world = np.concatenate([ROOM, [[[-3.0, 2.0], [-0.5, 2.0]], [[0.5, 2.0], [3.0, 2.0]]]])  # a wall with a door
    s = sights(np.concatenate([ROOM, [[[-3.5, 2.0], [3.0, 2.0]]]]), world=world)
    parts, of = s.stretches(np.concatenate([ROOM, [[[-3.5, 2.0], [3.0, 2.0]]]]), 3.0, 0.02)
    assert np.sort(parts[of == 4][..., 0].ravel()) == pytest.approx([-3.0, -0.5, 0.5, 3.0], abs=0.08)
    assert (np.bincount(of)[:4] == 1).all()


def test_what_nobody_looks_at_stays() -> None:
    outside = np.array([[[-4, 3.5], [4, 3.5]]], float)
    _, of = sights(np.concatenate([ROOM, outside])).stretches(np.concatenate([ROOM, outside]), 0.0, 0.02)
    assert np.bincount(of, minlength=5)[:4].tolist() == [1] * 4


def test_of_candidates_only_what_is_worth_it() -> None:
    world = np.concatenate([ROOM, [[[1.0, 1.0], [1.2, 1.0]]]])
    found = sights(ROOM, world=world).worthy(
        np.array([[[0.0, 1.0], [2.0, 1.0]], [[-2.0, -1.0], [-1.0, -1.0]]]), 2.0, 0.02
    )
    assert found.shape == (1, 2, 2)
    assert np.sort(found[0, :, 0]) == pytest.approx([1.0, 1.2], abs=0.06)


def test_of_two_lines_on_one_wall_no_stretch_goes_in_both() -> None:
    poses, bearings = np.column_stack([np.zeros(9), np.linspace(-2, 2, 9), np.zeros(9)]), np.deg2rad(np.arange(-90, 91))
    wall = np.array([[[3.0, 3.0], [3.0, -3.0]]])
    ranges = cast(wall, poses, bearings, 20.0)[0]
    s = Sights(poses, bearings, np.where(np.isfinite(ranges), ranges, 0.0))
    twice = np.array([[[3.01, 3.0], [2.99, -3.0]], [[2.99, 3.0], [3.01, -3.0]]])
    s.add(twice)
    runs, of = s.stretches(twice, 20.0, 0.02)
    s.clear()
    s.add(runs)
    assert s.unexplained(np.ones(len(runs), bool)).mean() < 0.01
    assert len(of) < 4
