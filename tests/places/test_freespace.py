"""Counts of beams."""

from __future__ import annotations

import numpy as np
import pytest

from rgcore.config import Places as Settings
from rgcore.errors import RgError
from rgcore.places.freespace import FreeSpace, free_space
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory


def look(ranges: list[float], bearings: list[float], max_range: float = 80.0) -> FreeSpace:
    """One scan from the origin."""
    one = np.array([0.0])
    log = ScanLog(one, np.array([ranges]), np.zeros((1, 3)), np.array(bearings), np.zeros(3), max_range)
    return free_space(log, Trajectory(one, np.zeros((1, 3)), np.zeros(3)), Settings())


def test_a_beam_is_free_up_to_its_echo_and_tells_nothing_beyond() -> None:
    free = look([3.01], [0.0])
    hits, passes = free.grid(free.hits), free.grid(free.passes)
    x = np.array([[0.5, 0.01], [2.9, 0.01], [3.02, 0.01], [3.2, 0.01]])
    assert passes.at(x).tolist() == [1, 1, 0, 0]
    assert hits.at(x).tolist() == [0, 0, 1, 0]
    assert free.hits.sum() == 1


def test_a_single_beam_without_echo_is_a_drop_out() -> None:
    free = look([2.0, np.inf, 2.0], [-0.2, 0.0, 0.2])
    assert free.grid(free.passes).at(np.array([0.5, 0.0])) == 0


def test_many_beams_without_echo_are_free_but_not_far() -> None:
    free = look([np.inf] * 7, np.linspace(-0.1, 0.1, 7).tolist())
    passes = free.grid(free.passes)
    assert passes.at(np.array([0.5, 0.0])) > 0
    assert passes.at(np.array([2.0, 0.0])) == 0


def test_no_echo_means_far_for_a_laser_that_sees_only_four_metres() -> None:
    free = look([np.inf] * 7, np.linspace(-0.1, 0.1, 7).tolist(), max_range=4.0)
    assert free.grid(free.passes).at(np.array([3.5, 0.0])) > 0


@pytest.mark.parametrize("bad", [np.nan, 0.0, -1.0])
def test_readings_without_information_count_for_nothing(bad: float) -> None:
    free = look([2.0, bad], [0.0, 1.0])
    assert free.hits.sum() == 1
    assert free.grid(free.passes).at(np.array([0.3, 0.45])) == 0


def test_a_map_too_large_for_its_raster_is_refused_with_the_remedy() -> None:
    poses = np.array([[0.0, 0, 0], [1000, 900, 0], [30000, 2e6, 0]])
    log = ScanLog(np.arange(3.0), np.full((3, 1), 2.0), poses, np.zeros(1), np.zeros(3), 80.0)
    with pytest.raises(RgError, match=r"1003 x 901 m.*odometry.*places\.resolution=0\.13"):
        free_space(log[:2], Trajectory(log.stamps, poses, np.zeros(3))[:2], Settings())
    free_space(log[:2], Trajectory(log.stamps, poses, np.zeros(3))[:2], Settings(resolution=0.13))
    with pytest.raises(RgError, match=r"30003 x 2000001 m.*odometry$"):
        free_space(log, Trajectory(log.stamps, poses, np.zeros(3)), Settings())
