"""Table II and global localization on mapped logs, where these are present."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rgcore.geometry import se2
from rgcore.pipeline import Run, run
from rgcore.robot.localize import Localizer
from rgcore.robot.table import localization_table
from rgcore.scans.read import read_log

DATA = Path(__file__).parents[2] / "../shared/data"
pytestmark = pytest.mark.skipif(not DATA.exists(), reason="shared data absent")


@pytest.fixture(scope="module")
def simulated() -> Run:
    return run(read_log(DATA / "runs/lab-ipa-furnitures.log.gz"))


@pytest.fixture(scope="module")
def recorded() -> Run:
    """Odometry that jumps by 80 degrees on the way."""
    return run(read_log(DATA / "logs/seattle.log.gz"))


def test_a_simulated_robot_is_followed_better_than_in_the_paper(simulated: Run) -> None:
    row = localization_table(simulated.log, simulated.trajectory.map_from_laser, simulated.map)
    assert row.lost == 0
    assert row.dx[1] < 0.011
    assert row.dy[1] < 0.011
    assert row.dalpha[1] < 0.01
    assert 0 <= row.d_min < 0.002
    assert row.d_max < 0.1


def test_a_recorded_robot_is_followed_better_than_in_the_paper(recorded: Run) -> None:
    row = localization_table(recorded.log, recorded.trajectory.map_from_laser, recorded.map)
    assert row.lost == 0
    assert row.dx[1] < 0.083
    assert row.dy[1] < 0.083
    assert abs(row.dx[0]) < 0.01
    assert row.d_max < 0.6


@pytest.mark.parametrize("which", ["simulated", "recorded"])
def test_a_robot_is_found_from_twenty_scans(which: str, request: pytest.FixtureRequest) -> None:
    mapped: Run = request.getfixturevalue(which)
    log, poses = mapped.log, mapped.trajectory.map_from_laser
    robot = Localizer(mapped.map, log.bearings)
    right = []
    for k in np.random.default_rng(1).choice(len(log) - 20, 15, replace=False):
        found = robot.find(log.ranges[k : k + 20], log.odom_from_laser[k : k + 20])
        off = se2.relative(poses[k + 19], found.poses[0])
        right.append(np.hypot(off[0], off[1]) < 0.25 and abs(off[2]) < np.deg2rad(5))
        assert right[-1] or not found.sure
    assert np.mean(right) >= 0.9
