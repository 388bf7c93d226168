"""Finding a robot that may be anywhere: right where the map allows it, honest where it does not."""

from __future__ import annotations

import numpy as np
import pytest
from robot_rooms import BEARINGS, drive, odometry, office, scan, wall

from rgcore.geometry import se2
from rgcore.robot.localize import Found, Localizer

WAY = drive((1, 1), (4.5, 1), (4.5, 4), (6.5, 4.5), (4.5, 4), (4.5, 1), (14.5, 1), (14.5, 4), (16, 5))
WINDOW = 20


@pytest.fixture
def chance() -> np.random.Generator:
    return np.random.default_rng(3)


def seen(poses: np.ndarray, chance: np.random.Generator, lines: np.ndarray | None = None) -> np.ndarray:
    return np.array([scan(office() if lines is None else lines, p, chance) for p in poses])


def is_at(found: Found, pose: np.ndarray) -> bool:
    off = se2.relative(pose, found.poses[0])
    return bool(np.hypot(off[0], off[1]) < 0.05 and abs(off[2]) < 0.02)


@pytest.mark.parametrize("first", range(0, len(WAY) - WINDOW, 23))
def test_a_robot_is_found_anywhere_on_its_way(first: int, chance: np.random.Generator) -> None:
    poses = WAY[first : first + WINDOW]
    found = Localizer(office(), BEARINGS).find(seen(poses, chance), odometry(poses, chance))
    assert found.sure
    assert is_at(found, poses[-1])
    assert found.quality[0] > 0.9
    assert (np.diff(found.quality) <= 0).all()


def test_found_among_people_and_without_odometry(chance: np.random.Generator) -> None:
    poses = WAY[100:120]
    scans = seen(poses, chance)
    hidden = chance.random(scans.shape) < 0.3
    scans = np.where(hidden, scans * chance.uniform(0.2, 0.9, scans.shape), scans)
    assert is_at(Localizer(office(), BEARINGS).find(scans, odometry(poses, chance)), poses[-1])
    found = Localizer(office(), BEARINGS).find(seen(poses, chance), None)
    assert found.sure
    assert is_at(found, poses[-1])


def test_tracking_goes_on_from_the_place_that_was_found(chance: np.random.Generator) -> None:
    scans, odom = seen(WAY[:60], chance), odometry(WAY[:60], chance)
    robot = Localizer(office(), BEARINGS)
    assert robot.lost
    assert robot.find(scans[:WINDOW], odom[:WINDOW]).sure
    assert not robot.lost
    after = [robot.add(s, o) for s, o in zip(scans[WINDOW:], odom[WINDOW:], strict=True)]
    off = se2.relative(WAY[WINDOW:60], np.array([e.pose for e in after]))
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.03


def test_a_kidnapped_robot_says_that_it_is_lost_and_is_found_again(chance: np.random.Generator) -> None:
    here, there = WAY[:20], WAY[-45:]
    robot = Localizer(office(), BEARINGS)
    robot.start(here[0])
    before, carried = odometry(here, chance), odometry(there, chance)
    for s, o in zip(seen(here, chance), before, strict=True):
        assert not robot.add(s, o).lost
    as_if_nothing = se2.compose(before[-1], se2.relative(carried[0], carried))
    lost = [robot.add(s, o).lost for s, o in zip(seen(there, chance), as_if_nothing, strict=True)]
    assert all(lost[15:])
    found = robot.recover()
    assert found is not None
    assert found.sure
    assert is_at(found, there[-1])
    assert not robot.lost


def test_nothing_is_recovered_before_a_window_is_full(chance: np.random.Generator) -> None:
    robot = Localizer(office(), BEARINGS)
    for s, o in zip(seen(WAY[:WINDOW], chance), odometry(WAY[:WINDOW], chance), strict=True):
        assert robot.recover() is None
        assert robot.add(s, o).lost
    assert robot.recover() is not None
    assert not robot.lost


def test_two_rooms_alike_are_ambiguous(chance: np.random.Generator) -> None:
    room = wall((0, 0), (4, 0), (4, 1), (5, 1), (5, 4), (0, 4), (0, 0))
    lines = np.concatenate([room, room + np.array([20.0, 3.0])])
    poses = drive((1, 1), (3, 2), (3, 3.2))
    robot = Localizer(lines, BEARINGS)
    found = robot.find(seen(poses, chance, lines), odometry(poses, chance))
    assert not found.sure
    assert robot.lost
    assert len(found.poses) >= 2
    ways = sorted(np.round(found.poses[:2, 0] - poses[-1, 0]).tolist())
    assert ways == [0.0, 20.0]


def test_scans_of_another_building_are_not_placed(chance: np.random.Generator) -> None:
    elsewhere = wall((0, 0), (9, 3), (7, 9), (3, 6), (-3, 8), (0, 0))
    poses = drive((1, 1.5), (4, 3.5), (5, 5.5))
    found = Localizer(office(), BEARINGS).find(seen(poses, chance, elsewhere), odometry(poses, chance))
    assert not found.sure


def test_scans_that_show_nothing_are_nowhere() -> None:
    found = Localizer(office(), BEARINGS).find(np.full((WINDOW, 181), np.inf), np.zeros((WINDOW, 3)))
    assert not found.sure
    assert len(found.poses) == 0


def test_one_wall_is_a_map_too(chance: np.random.Generator) -> None:
    """It shows how far from it the robot is, not where along: no one place is sure."""
    lines = wall((30, 0), (-30, 0))[:, ::-1]
    poses = drive((0, 2), (3, 2.5))
    found = Localizer(lines, BEARINGS).find(seen(poses, chance, lines), odometry(poses, chance))
    assert not found.sure
    assert found.poses[0, 1] == pytest.approx(2.5, abs=0.1)
