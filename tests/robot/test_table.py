"""Table II: signs, frames and counts of a row."""

from __future__ import annotations

import numpy as np
import pytest
from robot_rooms import BEARINGS, drive, odometry, office, scan

from rgcore.geometry import se2
from rgcore.robot.table import localization_table
from rgcore.scans.log import ScanLog


@pytest.fixture(scope="module")
def poses() -> np.ndarray:
    return drive((14.5, 2.5), (14.5, 5.5))


@pytest.fixture(scope="module")
def log(poses: np.ndarray) -> ScanLog:
    """A robot that drives along +y, its laser 0.2 m ahead of its centre."""
    chance = np.random.default_rng(5)
    base_from_laser = np.array([0.2, 0.0, 0.0])
    ranges = np.array([scan(office(), pose, chance) for pose in poses])
    odom = odometry(se2.compose(poses, se2.invert(base_from_laser)), chance)
    return ScanLog(np.arange(len(poses), dtype=float), ranges, odom, BEARINGS, base_from_laser, 30.0)


def test_a_row_of_a_right_map_is_near_zero(log: ScanLog, poses: np.ndarray) -> None:
    row = localization_table(log, poses, office())
    assert (row.scans, row.lost) == (len(poses), 0)
    for mean, deviation in (row.dx, row.dy, row.dalpha):
        assert abs(mean) < 0.01
        assert 0 < deviation < 0.01
    assert 0 < row.d_min < row.d_max < 0.03


def test_differences_are_ahead_and_to_the_left_of_the_aligned_scan(log: ScanLog, poses: np.ndarray) -> None:
    """Lines shifted to the right of the robot (+x), by 5 cm, and back by 2 cm: so is the estimate."""
    row = localization_table(log, poses, office() + np.array([0.05, -0.02]))
    assert row.dx[0] == pytest.approx(-0.02, abs=0.01)
    assert row.dy[0] == pytest.approx(-0.05, abs=0.01)
    assert row.d_min > 0.03


def test_a_log_without_odometry_is_followed_too(log: ScanLog, poses: np.ndarray) -> None:
    blind = ScanLog(
        log.stamps, log.ranges, np.zeros_like(poses), BEARINGS, log.base_from_laser, 30.0, has_odometry=False
    )
    row = localization_table(blind, poses, office())
    assert row.lost == 0
    assert row.d_max < 0.05
