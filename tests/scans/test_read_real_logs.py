"""The real logs and the simulated runs, where they are present."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from rgcore.scans.read import read_log

DATA = Path(__file__).parents[2] / "../shared/data"
pytestmark = pytest.mark.skipif(not DATA.exists(), reason="shared data absent")

#        file               scans  beams  first   last   silent  longest
LOGS = [
    ("intel.log.gz", 2726, 180, -90, 89, 13586, 26.23),
    ("intel-dense.log.gz", 5505, 180, -90, 89, 48459, 24.25),
    ("fr079.log.gz", 4791, 360, -90, 89.5, 36004, 36.62),
    ("aces.log.gz", 440, 180, -90, 89, 620, 49.91),
    ("aces-gfs.log.gz", 440, 180, -90, 89, 620, 49.91),
    ("seattle.log.gz", 241, 361, -90, 90, 707, 40.66),
    ("wean-1.txt.gz", 713, 180, -90, 89, 693, 53.67),
    ("wean-5.txt.gz", 954, 180, -90, 89, 4681, 42.15),
]


@pytest.mark.parametrize(("name", "scans", "beams", "first", "last", "silent", "longest"), LOGS)
def test_logs(name: str, scans: int, beams: int, first: float, last: float, silent: int, longest: float) -> None:
    log = read_log(DATA / "logs" / name)
    assert log.ranges.shape == (scans, beams)
    assert np.degrees(log.bearings[[0, -1]]) == pytest.approx([first, last])
    assert np.isinf(log.ranges).sum() == silent
    assert not np.isnan(log.ranges).any()
    assert log.max_range == pytest.approx(longest)
    assert log.has_odometry
    assert (np.abs(log.odom_from_base[:, 2]) <= np.pi).all()


def test_mountings() -> None:
    np.testing.assert_allclose(read_log(DATA / "logs/wean-1.txt.gz").base_from_laser, [0.25, 0, 0], atol=0.001)
    assert read_log(DATA / "logs/intel.log.gz").base_from_laser.tolist() == [0, 0, 0]


def test_simulated_runs_lose_no_echo() -> None:
    runs = sorted((DATA / "runs").glob("*.log.gz"))
    assert runs
    for path in runs:
        log = read_log(path)
        assert 20 < log.max_range < 30.1, path
        assert np.isinf(log.ranges).mean() < 0.01, path
        assert np.isfinite(log.odom_from_base).all()


def test_speed() -> None:
    began = time.process_time()
    read_log(DATA / "logs/intel-dense.log.gz")
    assert time.process_time() - began < 1.0
