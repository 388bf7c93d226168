"""Poses where it is hard: no odometry, an empty corridor, a robot that stands, long ways, a wide hall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drives import BEARINGS, LASER, chain, error

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.geometry.raycast import cast
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log
from rgcore.scans.simulate import Laser, Odometry, measure_odometry, measure_ranges
from rgcore.slam.local import covariance
from rgcore.slam.lrgc import Lrgc, lrgc
from rgviz.demo import LOG

OFFICE = read_log(LOG)[:1500]
TRUE = np.loadtxt(LOG.with_name("office.poses.tum"))[:1500]
TRUE = np.column_stack([TRUE[:, 1:3], 2.0 * np.arctan2(TRUE[:, 6], TRUE[:, 7])])
CORRIDOR = np.concatenate([chain((-20, -1), (80, -1)), chain((80, 1), (-20, 1))])

HALL = chain((-60, -10), (140, -10), (140, 70), (-60, 70), (-60, -10))


def measure(walls: np.ndarray, poses: np.ndarray, reach: float, odometry: np.ndarray) -> ScanLog:
    """What a robot at ``poses`` (N, 3) logs whose laser sees no farther than ``reach`` [m]."""
    exact, _ = cast(walls, se2.compose(poses, LASER), BEARINGS, reach)
    ranges = measure_ranges(exact, Laser(max_range=reach), np.random.default_rng(2))
    return ScanLog(0.2 * np.arange(len(poses)), ranges, odometry, BEARINGS, LASER, reach)


def way(*corners: tuple[float, float], step: float = 0.2) -> np.ndarray:
    """(N, 3) poses of a robot that drives from corner to corner and turns on the spot."""
    out: list[np.ndarray] = []
    heading: float | None = None
    for a, b in zip(np.array(corners[:-1], float), np.array(corners[1:], float), strict=True):
        length, goal = float(np.hypot(*(b - a))), float(np.arctan2(*(b - a)[::-1]))
        if heading is not None:
            turn = float(se2.wrap(np.array(goal - heading)))
            out += [np.append(a, heading + turn * k / 10) for k in range(1, 10)]
        out += [np.append(a + (b - a) * s / length, goal) for s in np.arange(0.0, length, step)]
        heading = goal
    poses = np.array(out)
    poses[:, 2] = se2.wrap(poses[:, 2])
    return poses


def aligned(poses: np.ndarray, true: np.ndarray) -> float:
    """Absolute trajectory error [m] after the best rigid motion."""
    a, b = poses[:, :2] - poses[:, :2].mean(0), true[:, :2] - true[:, :2].mean(0)
    turn = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    back = se2.transform(np.array([0.0, 0.0, turn]), a)
    return float(np.sqrt(((back - b) ** 2).sum(1).mean()))


@pytest.mark.parametrize(("walls", "reach", "step"), [(CORRIDOR, 8.0, 0.2), (HALL, 30.0, 0.3)])
def test_where_nothing_is_seen_along_the_way_it_is_as_long_as_odometry_says(
    walls: np.ndarray, reach: float, step: float
) -> None:
    """It must neither shrink nor stretch. In the hall the echoes of one scan lie far apart; they must not draw the next
    scan to where the robot stood.
    """
    true = np.column_stack([step * np.arange(200), np.zeros(200), np.zeros(200)])
    counted = true * [1.03, 1.0, 1.0]
    log = measure(walls, true, reach, counted)
    mapper = Lrgc(log.bearings, Slam())
    for ranges, odometry in zip(log.ranges, log.odom_from_laser, strict=True):
        mapper.add(ranges, odometry)
    for poses in (mapper.poses(), mapper.finish()):
        off = se2.compose(poses, se2.invert(LASER)) - counted
        assert np.abs(off[:, 0]).max() < 0.02 * counted[-1, 0]
        assert np.abs(off[:, 1]).max() < 0.3, "the corridor is straight"
        assert np.abs(off[:, 2]).max() < 0.015


def test_the_covariance_knows_what_a_scan_does_not_see() -> None:
    for heading in (0.0, 0.7):
        turned = se2.transform(np.array([0.0, 0.0, heading]), CORRIDOR.reshape(-1, 2)).reshape(-1, 2, 2)
        poses = se2.compose(np.array([0.0, 0.0, heading]), way((0, 0), (2, 0)))
        log = measure(turned, poses, 8.0, poses)
        mapper = Lrgc(log.bearings, Slam())
        for ranges, odometry in zip(log.ranges, log.odom_from_laser, strict=True):
            mapper.add(ranges, odometry)
        assert mapper.match is not None
        spread, axes = np.linalg.eigh(covariance(mapper.match)[:2, :2])
        assert spread[1] > 0.5**2, "next to nothing along"
        assert spread[0] < 0.01**2, "sharp across"
        assert abs(axes[:, 1] @ [np.cos(heading), np.sin(heading)]) > 0.99


def test_an_office_without_odometry() -> None:
    blind = replace(OFFICE, odom_from_base=np.zeros_like(OFFICE.odom_from_base), has_odometry=False)
    trajectory = lrgc(blind, Slam())
    assert aligned(trajectory.map_from_base, TRUE) < 0.05
    assert not len(trajectory.breaks)


def test_odometry_that_freezes_for_a_while() -> None:
    moved = se2.relative(OFFICE.odom_from_base[:-1], OFFICE.odom_from_base[1:])
    moved[200:260] = 0.0
    odometry = [OFFICE.odom_from_base[0]]
    for m in moved:
        odometry.append(se2.compose(odometry[-1], m))
    frozen = replace(OFFICE, odom_from_base=np.array(odometry))[:600]
    assert aligned(lrgc(frozen, Slam()).map_from_base, TRUE[:600]) < 0.05


def test_a_minute_of_standing_makes_no_keyframes_and_no_drift() -> None:
    stop = 150
    still = np.r_[np.arange(stop), np.full(300, stop), np.arange(stop, 300)]
    ranges = np.array(OFFICE.ranges[still])
    ranges[stop : stop + 300] += np.random.default_rng(3).normal(0.0, 0.012, (300, ranges.shape[1]))
    log = replace(OFFICE[:600], ranges=ranges, odom_from_base=OFFICE.odom_from_base[still])
    mapper = Lrgc(log.bearings, Slam(), log.has_odometry)
    grown = []
    for k in range(len(log)):
        mapper.add(log.ranges[k], log.odom_from_laser[k])
        grown.append(len(mapper.keyframes))
    assert grown[stop + 299] - grown[stop] <= 1
    poses = mapper.finish()
    assert np.abs(poses[stop : stop + 300] - poses[stop]).max() < 0.01
    assert aligned(se2.compose(poses, se2.invert(log.base_from_laser)), TRUE[still]) < 0.05


def test_stamps_all_equal_and_a_third_of_the_beams_missing() -> None:
    ranges = np.array(OFFICE.ranges)
    ranges[np.random.default_rng(1).random(ranges.shape) < 0.3] = np.nan
    poor = replace(OFFICE, ranges=ranges, stamps=np.full(len(OFFICE), 7.0))
    trajectory = lrgc(poor, Slam())
    assert aligned(trajectory.map_from_base, TRUE) < 0.05
    assert not len(trajectory.breaks)


def test_a_wide_hall_with_few_pillars() -> None:
    """The walls are out of sight most of the time; what is seen must be enough where it is seen."""
    chance = np.random.default_rng(3)
    pillars = [chain((x, y), (x, y + 0.6), (x + 0.6, y + 0.6), (x + 0.6, y), (x, y)) for x, y in
               zip(chance.uniform(3, 57, 12), chance.uniform(3, 37, 12), strict=True)]  # fmt: skip
    walls = np.concatenate([chain((0, 0), (60, 0), (60, 40), (0, 40), (0, 0)), *pillars])
    true = way((5, 5), (55, 5), (55, 35), (5, 35), (5, 5), (30, 20), step=0.3)
    log = measure(walls, true, 30.0, measure_odometry(true, Odometry(), np.random.default_rng(5)))
    trajectory = lrgc(log, Slam())
    assert error(log.odom_from_base, true) > 0.5
    assert aligned(trajectory.map_from_base, true) < 0.1
    assert not len(trajectory.breaks)
