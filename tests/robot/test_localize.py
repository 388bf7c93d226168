"""Following a robot on a line map: accurate, honest about what the lines do not show, and about being lost."""

from __future__ import annotations

import numpy as np
import pytest
from robot_rooms import BEARINGS, corridor, drive, odometry, office, scan

from rgcore.errors import RgError
from rgcore.geometry import se2
from rgcore.robot.localize import Estimate, Localizer

WAY = drive((1, 1), (4.5, 1), (4.5, 4), (6.5, 4.5), (4.5, 4), (4.5, 1), (14.5, 1), (14.5, 4), (16, 5))


def follow(
    lines: np.ndarray, poses: np.ndarray, scans: np.ndarray, odom: np.ndarray
) -> tuple[list[Estimate], np.ndarray]:
    """The estimates, and how far they are off, (N, 3)."""
    robot = Localizer(lines, BEARINGS)
    robot.start(poses[0])
    out = [robot.add(s, o) for s, o in zip(scans, odom, strict=True)]
    return out, se2.relative(poses, np.array([e.pose for e in out]))


@pytest.fixture
def chance() -> np.random.Generator:
    return np.random.default_rng(7)


@pytest.fixture
def scans(chance: np.random.Generator) -> np.ndarray:
    return np.array([scan(office(), p, chance) for p in WAY])


def test_a_robot_is_followed_to_the_centimetre(scans: np.ndarray, chance: np.random.Generator) -> None:
    found, off = follow(office(), WAY, scans, odometry(WAY, chance))
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.03
    assert np.abs(off[:, 2]).max() < 0.01
    assert min(e.explained for e in found) > 0.9
    assert not any(e.lost for e in found)


def test_people_in_front_of_the_laser(scans: np.ndarray, chance: np.random.Generator) -> None:
    hidden = chance.random(scans.shape) < 0.3
    scans = np.where(hidden, scans * chance.uniform(0.2, 0.9, scans.shape), scans)
    found, off = follow(office(), WAY, scans, odometry(WAY, chance))
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.05
    assert not any(e.lost for e in found)
    assert np.mean([e.explained for e in found]) < 0.85
    assert np.mean([e.crossed for e in found]) < 0.05


@pytest.mark.parametrize("nothing", [np.nan, np.inf])
def test_beams_without_an_answer(scans: np.ndarray, chance: np.random.Generator, nothing: float) -> None:
    scans = np.where(chance.random(scans.shape) < 0.3, nothing, scans)
    _, off = follow(office(), WAY, scans, odometry(WAY, chance))
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.03


@pytest.mark.parametrize("scale", [0.7, 1.3])
def test_odometry_of_a_wrong_scale(scans: np.ndarray, chance: np.random.Generator, scale: float) -> None:
    found, off = follow(office(), WAY, scans, odometry(WAY, chance, scale))
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.05
    assert not any(e.lost for e in found)


def test_a_corridor_does_not_tell_how_far_along(chance: np.random.Generator) -> None:
    poses = drive((0, 1), (10, 1))
    scans = np.array([scan(corridor(), p, chance) for p in poses])
    found, off = follow(corridor(), poses, scans, odometry(poses, chance))
    along, across = np.sqrt(found[-1].covariance[0, 0]), np.sqrt(found[-1].covariance[1, 1])
    assert along > 0.15
    assert across < 0.03
    assert np.abs(off[:, 1]).max() < 0.02
    assert (np.abs(off[:, 0]) < 3 * np.sqrt([e.covariance[0, 0] for e in found])).all()
    assert not any(e.lost for e in found)


def test_one_wall_shows_the_distance_from_it(chance: np.random.Generator) -> None:
    lines, pose = corridor()[:1], np.array([0.0, 1.3, -0.5])
    robot = Localizer(lines, BEARINGS)
    robot.start([0.0, 1.2, -0.5], (0.3, 0.3, 0.1))
    found = robot.add(scan(lines, pose, chance), np.zeros(3))
    assert found.pose[1:] == pytest.approx(pose[1:], abs=0.02)
    assert np.sqrt(found.covariance[0, 0]) == pytest.approx(0.3, rel=0.2)
    assert np.sqrt(found.covariance[1, 1]) < 0.05


def test_a_wall_is_not_seen_from_behind(chance: np.random.Generator) -> None:
    """Two faces of a wall 10 cm thick: a robot on one side is drawn to that face, though the other is nearer."""
    near, far = np.array([[-5.0, 1.0], [5.0, 1.0]])[::-1], np.array([[-5.0, 1.1], [5.0, 1.1]])
    robot = Localizer(np.array([near, far]), BEARINGS)
    robot.start([0.0, 0.08, np.pi / 2])
    found = robot.add(scan(near[None], np.array([0.0, 0.0, np.pi / 2]), chance), np.zeros(3))
    assert found.pose[1] == pytest.approx(0.0, abs=0.01)


def test_a_scan_without_a_reading_leaves_odometry(chance: np.random.Generator) -> None:
    robot = Localizer(office(), BEARINGS)
    robot.start(WAY[0])
    robot.add(scan(office(), WAY[0], chance), np.zeros(3))
    before = robot.add(np.full(181, np.inf), np.zeros(3))
    after = robot.add(np.full(181, np.nan), np.array([0.5, 0.0, 0.0]))
    assert after.pose == pytest.approx(se2.compose(before.pose, np.array([0.5, 0.0, 0.0])))
    assert np.trace(after.covariance) > np.trace(before.covariance)
    assert not after.lost


def test_a_robot_that_was_carried_off_says_so(scans: np.ndarray, chance: np.random.Generator) -> None:
    jump = len(WAY) - 25
    order = np.r_[0:20, jump : len(WAY)]
    robot = Localizer(office(), BEARINGS)
    robot.start(WAY[0])
    before = odometry(WAY[:20], chance)
    after = np.tile(before[-1], (25, 1))
    lost = [robot.add(scans[k], o).lost for k, o in zip(order, np.r_[before, after], strict=True)]
    assert not any(lost[:20])
    assert all(lost[30:])


def test_before_the_start_it_is_lost() -> None:
    assert Localizer(office(), BEARINGS).add(np.full(181, 1.0), np.zeros(3)).lost


def test_a_scan_of_another_laser_is_refused() -> None:
    robot = Localizer(office(), BEARINGS)
    with pytest.raises(RgError, match="180 readings, but 181 bearings"):
        robot.add(np.ones(180), None)
    with pytest.raises(RgError, match="180 readings, but 181 bearings"):
        robot.find(np.ones((20, 180)), None)


def test_a_map_without_lines_is_refused() -> None:
    with pytest.raises(RgError, match="no lines"):
        Localizer(np.zeros((0, 2, 2)), BEARINGS)
    with pytest.raises(RgError, match="no numbers"):
        Localizer(np.full((1, 2, 2), np.nan), BEARINGS)
