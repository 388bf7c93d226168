"""A robot that is lifted and put elsewhere: it is told, in words, and bends nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log
from rgcore.slam.lrgc import lrgc
from rgcore.slam.trajectory import Trajectory
from rgviz.demo import LOG

OFFICE = read_log(LOG)
TRUE = np.loadtxt(LOG.with_name("office.poses.tum"))
TRUE = np.column_stack([TRUE[:, 1:3], 2.0 * np.arctan2(TRUE[:, 6], TRUE[:, 7])])
BEFORE, AFTER = 100, 40


def carried(start: int, goal: int) -> tuple[ScanLog, np.ndarray]:
    """The office log with the robot carried from where it was at scan ``start`` to where it was at ``goal``, and the
    true poses; its wheels stood still meanwhile.
    """
    part, odometry = np.r_[start - BEFORE : start, goal : goal + AFTER], OFFICE.odom_from_base
    elsewhere = se2.compose(odometry[start - 1], se2.relative(odometry[goal], odometry[goal : goal + AFTER]))
    log = OFFICE[part]
    return replace(log, odom_from_base=np.concatenate([odometry[start - BEFORE : start], elsewhere])), TRUE[part]


@pytest.mark.parametrize(("start", "goal"), [(2671, 2037), (1318, 2691), (366, 2918), (1516, 3105), (669, 2560)])
def test_a_robot_put_elsewhere_is_told_and_bends_nothing(start: int, goal: int) -> None:
    log, true = carried(start, goal)
    trajectory = lrgc(log, Slam())
    assert trajectory.breaks.tolist() == [BEFORE]
    for part in (slice(0, BEFORE), slice(BEFORE, None)):
        found = se2.relative(trajectory.map_from_base[part][0], trajectory.map_from_base[part])
        assert np.abs(found - se2.relative(true[part][0], true[part]))[:, :2].max() < 0.15


def test_a_robot_put_back_to_where_it_had_been_is_found_there() -> None:
    start, goal = 2081, 1668
    part, odometry = np.r_[start - 500 : start, goal : goal + 200], OFFICE.odom_from_base
    elsewhere = se2.compose(odometry[start - 1], se2.relative(odometry[goal], odometry[goal : goal + 200]))
    log = replace(OFFICE[part], odom_from_base=np.concatenate([odometry[start - 500 : start], elsewhere]))
    trajectory = lrgc(log, Slam())
    assert trajectory.breaks.tolist() == []
    assert trajectory.healed.tolist() == [500]
    assert "found on the map again" in trajectory.notes[0]
    found = se2.relative(trajectory.map_from_base[0], trajectory.map_from_base)
    assert np.abs(found - se2.relative(TRUE[part][0], TRUE[part]))[:, :2].max() < 0.2


@pytest.mark.parametrize("jump", [50.0, 3e6])
def test_odometry_that_jumps_breaks_nothing(jump: float) -> None:
    odometry = OFFICE[:300].odom_from_base.copy()
    odometry[150:, 0] += jump
    trajectory = lrgc(replace(OFFICE[:300], odom_from_base=odometry), Slam())
    assert trajectory.breaks.tolist() == []
    assert trajectory.jumps.tolist() == [150]
    found = se2.relative(trajectory.map_from_base[0], trajectory.map_from_base)
    assert np.abs(found - se2.relative(TRUE[0], TRUE[:300]))[:, :2].max() < 0.15


def test_a_whole_drive_has_no_breaks() -> None:
    trajectory = lrgc(OFFICE[:400], Slam())
    assert len(trajectory.breaks) == 0
    assert trajectory.notes == ()


@pytest.mark.parametrize(
    ("breaks", "told"),
    [
        ([812], "scan 812 could not be joined to the one before: the robot was moved, or scans are missing"),
        ([5, 812], "scans 5, 812 could not be joined"),
        (list(range(10, 18)), "scans 10, 11, 12, 13, 14 and 3 more could not"),
    ],
)
def test_breaks_are_told_in_one_line(breaks: list[int], told: str) -> None:
    (line,) = Trajectory(np.zeros(900), np.zeros((900, 3)), np.zeros(3), np.array(breaks)).notes
    assert line.startswith(told)


def test_breaks_are_kept_and_files_without_them_are_read(tmp_path: Path) -> None:
    kept = Trajectory(np.arange(9.0), np.zeros((9, 3)), np.zeros(3), np.array([3, 7]))
    kept.save(tmp_path / "new.npz")
    assert Trajectory.load(tmp_path / "new.npz").breaks.tolist() == [3, 7]
    np.savez(
        tmp_path / "old.npz",
        stamps=kept.stamps,
        map_from_base=kept.map_from_base,
        base_from_laser=kept.base_from_laser,
    )
    assert Trajectory.load(tmp_path / "old.npz").breaks.tolist() == []


@pytest.mark.parametrize("which", range(6))
def test_a_turn_that_the_odometry_missed_is_seen(which: int) -> None:
    """Look-alike corners fit as well as they do where the robot stands; the likeliest answer counts, not the first."""
    log, true = OFFICE[:900:8], TRUE[:900:8]
    steps = se2.relative(log.odom_from_base[:-1], log.odom_from_base[1:])
    steps[np.argsort(-np.abs(steps[:, 2]))[which]] = 0.0
    odometry = [log.odom_from_base[0]]
    for step in steps:
        odometry.append(se2.compose(odometry[-1], step))
    trajectory = lrgc(replace(log, odom_from_base=np.array(odometry)), Slam())
    assert trajectory.breaks.tolist() == []
    found = se2.relative(trajectory.map_from_base[0], trajectory.map_from_base)
    assert np.abs(found - se2.relative(true[0], true))[:, :2].max() < 0.1
