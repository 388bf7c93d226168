"""Compact and faithful on real buildings, with the true poses: the lines alone are to blame."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rgcore.config import Config
from rgcore.lines.accuracy import measure_accuracy, predict
from rgcore.lines.merge import Lines, merge_lines
from rgcore.scans.extract import extract
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log
from rgcore.slam.trajectory import Trajectory

RUNS = Path(__file__).parents[2] / "../shared/data/runs"
pytestmark = pytest.mark.skipif(not RUNS.exists(), reason="shared data absent")

NAMES = ["lab-ipa-furnitures", "school-Sabadell1-furnished", "Freiburg79-scan-plain", "lab-c-scan-furnitures"]
CONFIG = Config()


@pytest.fixture(scope="module", params=NAMES)
def run(request: pytest.FixtureRequest) -> tuple[str, ScanLog, Trajectory, Lines, int]:
    log = read_log(RUNS / f"{request.param}.log.gz")
    t = np.loadtxt(RUNS / f"{request.param}.poses.tum")
    poses = np.stack([t[:, 1], t[:, 2], 2 * np.arctan2(t[:, 6], t[:, 7])], 1)
    trajectory = Trajectory(log.stamps, poses, log.base_from_laser)
    segments = extract(log, CONFIG.extract)
    lines, _ = merge_lines(segments, trajectory, np.zeros(len(segments), np.int64), CONFIG.lines)
    return request.param, log, trajectory, lines, len(segments)


def test_far_fewer_lines_than_segments(run: tuple[str, ScanLog, Trajectory, Lines, int]) -> None:
    _, _, _, lines, segments = run
    assert segments / len(lines) > 17


def test_the_lines_predict_the_scans(run: tuple[str, ScanLog, Trajectory, Lines, int]) -> None:
    _, log, trajectory, lines, _ = run
    usable = log.usable(12.0)
    predicted = predict(lines.ends, trajectory.map_from_laser, log.bearings, 13.0)
    off = np.abs(predicted[usable] - log.ranges[usable])
    assert np.median(off) < 0.02
    assert (off < 0.1).mean() > 0.89
    assert measure_accuracy(log, trajectory, lines.ends, CONFIG.accuracy).of(np.ones(len(log), bool)) < 0.27


def test_no_line_closes_a_door_that_the_robot_passed(run: tuple[str, ScanLog, Trajectory, Lines, int]) -> None:
    name, _, _, lines, _ = run
    truth = json.loads((RUNS / f"{name}.truth.json").read_text())
    passed = [np.array(g["posts"]) for g in truth["gateways"] if g.get("passed")]
    assert passed
    start, d = lines.ends[:, 0], lines.ends[:, 1] - lines.ends[:, 0]
    for a, b in passed:
        middle, across = (a + b) / 2, np.array([a[1] - b[1], b[0] - a[0]]) / np.hypot(*(b - a)) * 0.15
        # does any line cut the short way through the middle of the opening, from 15 cm before it to 15 cm behind it?
        p, u = middle - across, 2 * across
        det = u[0] * d[:, 1] - u[1] * d[:, 0]
        det = np.where(det == 0, np.inf, det)
        t = ((start[:, 0] - p[0]) * d[:, 1] - (start[:, 1] - p[1]) * d[:, 0]) / det
        s = ((start[:, 0] - p[0]) * u[1] - (start[:, 1] - p[1]) * u[0]) / det
        assert not ((t > 0) & (t < 1) & (s > 0) & (s < 1)).any(), f"{name}: door at {middle}"
