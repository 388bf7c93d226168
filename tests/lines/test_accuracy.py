"""acc(s) and acc(R) on rooms whose ranges are known."""

from __future__ import annotations

import numpy as np
import pytest

from rgcore.config import Accuracy as Settings
from rgcore.lines.accuracy import measure_accuracy, predict
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

ROOM = np.array([[[-2, -3], [4, -3]], [[4, -3], [4, 3]], [[4, 3], [-2, 3]], [[-2, 3], [-2, -3]]], float)
BEARINGS = np.array([-np.pi / 2, 0.0, np.pi / 2])  # 3 m, 4 m, 3 m from the origin


def scan(*ranges: float, base_from_laser: tuple[float, float, float] = (0, 0, 0)) -> tuple[ScanLog, Trajectory]:
    zero, mount = np.zeros((1, 3)), np.array(base_from_laser, float)
    return ScanLog(np.zeros(1), np.array([ranges]), zero, BEARINGS, mount, 50.0), Trajectory(np.zeros(1), zero, mount)


def test_prediction_of_a_room() -> None:
    assert predict(ROOM, np.zeros((1, 3)), BEARINGS, 50.0)[0] == pytest.approx([3, 4, 3])


def test_perfect_map_costs_nothing() -> None:
    a = measure_accuracy(*scan(3, 4, 3), ROOM, Settings())
    assert a.scan[0] == pytest.approx(0, abs=1e-9)
    assert (a.readings[0], a.missed[0]) == (3, 0)


def test_root_mean_square_by_hand() -> None:
    a = measure_accuracy(*scan(3.3, 4.0, 2.6), ROOM, Settings())
    assert a.scan[0] == pytest.approx(np.sqrt((0.3**2 + 0.4**2) / 3))
    assert a.median[0] == pytest.approx(0.3)


def test_missing_line_costs_the_penalty() -> None:
    a = measure_accuracy(*scan(3, 4, 3), ROOM[[0, 2, 3]], Settings(penalty=0.5))  # without the wall ahead
    assert a.scan[0] == pytest.approx(np.sqrt(0.5**2 / 3))
    assert a.missed[0] == 1


def test_unrelated_line_behind_a_missing_one_costs_no_more_than_the_penalty() -> None:
    far = np.concatenate([ROOM[[0, 2, 3]], [[[11.0, -3.0], [11.0, 3.0]]]])
    a = measure_accuracy(*scan(3, 4, 3), far, Settings(penalty=1.0))
    assert a.scan[0] == pytest.approx(np.sqrt(1.0 / 3))
    assert a.missed[0] == 1


def test_far_readings_and_missing_echoes_are_left_out() -> None:
    a = measure_accuracy(*scan(3.1, np.inf, np.nan), ROOM, Settings())
    assert (a.readings[0], a.scan[0]) == (1, pytest.approx(0.1))
    assert measure_accuracy(*scan(3, 13.0, 3), ROOM, Settings(max_range=12)).readings[0] == 2


def test_scan_without_readings_is_no_evidence() -> None:
    a = measure_accuracy(*scan(np.inf, np.inf, np.inf), ROOM, Settings())
    assert np.isnan(a.scan[0])
    assert a.of(np.array([True])) is None


def test_the_mounting_of_the_laser_counts() -> None:
    a = measure_accuracy(*scan(3, 3.5, 3, base_from_laser=(0.5, 0, 0)), ROOM, Settings())
    assert a.scan[0] == pytest.approx(0, abs=1e-9)


def test_region_accuracy_is_the_root_mean_square_of_its_scans() -> None:
    log = ScanLog(np.zeros(2), np.array([[3.3, 4, 3], [3, 4.4, 3]]), np.zeros((2, 3)), BEARINGS, np.zeros(3), 50.0)
    a = measure_accuracy(log, Trajectory(np.zeros(2), np.zeros((2, 3)), np.zeros(3)), ROOM, Settings())
    assert a.of(np.array([0, 1])) == pytest.approx(np.sqrt((0.3**2 / 3 + 0.4**2 / 3) / 2))


def test_no_lines_at_all() -> None:
    assert measure_accuracy(*scan(3, 4, 3), np.zeros((0, 2, 2)), Settings(penalty=1)).scan[0] == pytest.approx(1.0)
