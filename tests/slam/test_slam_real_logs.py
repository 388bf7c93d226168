"""The real logs and the simulated runs, where they are present: the scores that the README quotes."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from rgcore.config import Slam
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log
from rgcore.slam.lrgc import lrgc
from rgcore.slam.trajectory import Trajectory

SHARED = Path(__file__).parents[2] / "../shared"
DATA = SHARED / "data"
pytestmark = pytest.mark.skipif(not DATA.exists(), reason="shared data absent")

RUNS = ("lab-ipa-furnitures", "Freiburg79-scan-plain", "office-chewlane-furnished", "school-Sabadell1-furnished")


def write_tum(trajectory: Trajectory, path: Path) -> None:
    p = trajectory.map_from_laser
    zero = np.zeros(len(p))
    columns = [trajectory.stamps, p[:, 0], p[:, 1], zero, zero, zero, np.sin(p[:, 2] / 2), np.cos(p[:, 2] / 2)]
    np.savetxt(path, np.column_stack(columns), fmt="%.9f")


def relations(trajectory: Trajectory, tmp_path: Path, *options: str) -> dict[str, float]:
    """What score_relations.py says of a trajectory."""
    write_tum(trajectory, tmp_path / "out.tum")
    command = [sys.executable, str(SHARED / "tools/score_relations.py"), str(tmp_path / "out.tum"), *options]
    scores: dict[str, float] = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return scores


def aligned_rmse(poses: np.ndarray, true: np.ndarray) -> float:
    """Absolute trajectory error [m] after the best rigid motion (Umeyama without scale)."""
    a, b = poses[:, :2] - poses[:, :2].mean(0), true[:, :2] - true[:, :2].mean(0)
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return float(np.sqrt(((a @ turn.T - b) ** 2).sum(1).mean()))


@cache
def log(name: str) -> ScanLog:
    return read_log(DATA / "logs" / name)


@cache
def mapped(name: str) -> Trajectory:
    return lrgc(log(name), Slam())


@pytest.mark.parametrize(("name", "rows"), [("intel.log.gz", "-4,5"), ("intel-dense.log.gz", "0,1")])
def test_intel(name: str, rows: str, tmp_path: Path) -> None:
    folder = DATA / "relations"
    options = [
        str(folder / "intel-by-row.relations"),
        "--odometry",
        str(folder / "intel-odometry.csv.gz"),
        f"--rows={rows}",
    ]
    scores = relations(mapped(name), tmp_path, *options)
    assert scores["trans_mean"] < 0.021
    assert scores["rot_mean"] < 0.7
    assert scores["trans_max"] < 0.15


def test_fr079(tmp_path: Path) -> None:
    """Its odometry has stretches whose translation has the wrong sign."""
    scores = relations(mapped("fr079.log.gz"), tmp_path, str(DATA / "relations/fr079.relations"), "--forward", "0.04")
    assert scores["trans_mean"] < 0.039
    assert scores["rot_mean"] < 0.54


@pytest.mark.parametrize("name", RUNS)
def test_simulated_runs(name: str) -> None:
    trajectory = lrgc(read_log(DATA / "runs" / f"{name}.log.gz"), Slam())
    true = np.loadtxt(DATA / "runs" / f"{name}.poses.tum")
    assert np.abs(trajectory.stamps - true[:, 0]).max() < 1e-3
    assert aligned_rmse(trajectory.map_from_base, true[:, 1:3]) < 0.05


@pytest.mark.parametrize(
    ("name", "stride", "bound"),
    [("intel.log.gz", 2, 0.1), ("intel.log.gz", 3, 0.1), ("fr079.log.gz", 2, 0.1), ("aces.log.gz", 3, 1.5)],
)
def test_thinned_logs_give_the_same_map(name: str, stride: int, bound: float) -> None:
    """A wrong closure would bend one of the two by metres."""
    thinned = lrgc(log(name)[::stride], Slam()).map_from_base
    assert aligned_rmse(thinned, mapped(name).map_from_base[::stride]) < bound


def test_aces_closes_its_loops() -> None:
    """The weak reference was corrected by a particle filter, scan by scan."""
    assert aligned_rmse(mapped("aces.log.gz").map_from_base, log("aces-gfs.log.gz").odom_from_base) < 1.0
