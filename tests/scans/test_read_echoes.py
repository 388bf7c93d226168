"""What a reading means: codes for "no echo" are found, echoes are kept."""

from __future__ import annotations

import time

import numpy as np
import pytest

from rgcore.scans.echoes import mark_echoes


def hall(longest: float, scans: int = 200, beams: int = 181, seed: int = 0) -> np.ndarray:
    """Readings of a robot that moves, in centimetres' steps, up to ``longest`` [m], all different from each other."""
    random = np.random.default_rng(seed)
    far = longest * random.uniform(0.05, 1, (scans, beams)) ** 2
    return np.maximum(np.round(far, 2), 0.1)


@pytest.mark.parametrize("code", [81.83, 81.91, 80.0, 51.11, 50.0, 32.77, 8.19, 8.191])
def test_known_codes_are_no_echo_even_if_seen_once(code: float) -> None:
    readings = hall(0.9 * code)
    readings[3, 7] = code
    ranges, longest, notes = mark_echoes(readings)
    assert np.isinf(ranges[3, 7])
    assert np.isinf(ranges).sum() == 1
    assert longest == readings[readings < code].max()
    assert "no echo is written as" in notes[0]


def test_several_codes_of_one_scanner() -> None:
    readings = hall(30.0)
    codes = [81.91, 81.89, 81.87, 81.83]
    readings[0, :4] = codes
    ranges, _, _ = mark_echoes(readings)
    assert np.isinf(ranges[0, :4]).all()
    assert np.isinf(ranges).sum() == 4


def test_a_clip_that_nobody_announced_is_found_by_its_repetition() -> None:
    readings = np.minimum(hall(20.0), 12.34)
    ranges, longest, _ = mark_echoes(readings)
    np.testing.assert_array_equal(np.isinf(ranges), readings == 12.34)
    assert longest < 12.34


def test_a_clip_below_a_code_is_found_too() -> None:
    readings = np.minimum(hall(30.0), 20.0)
    readings[0, 0] = 81.91
    ranges, _, _ = mark_echoes(readings)
    np.testing.assert_array_equal(np.isinf(ranges), readings >= 20.0)


def test_echoes_are_kept_up_to_the_longest() -> None:
    readings = hall(30.0)
    ranges, longest, notes = mark_echoes(readings)
    np.testing.assert_array_equal(ranges, readings)
    assert longest == readings.max()
    assert notes == []


def test_real_echoes_at_a_code_of_another_scanner_are_kept() -> None:
    readings = hall(30.0)
    readings[:, 90] = 8.19
    readings[5, 5] = 81.83
    ranges, _, _ = mark_echoes(readings)
    assert (ranges[:, 90] == 8.19).all()


def test_a_robot_that_stands_still_keeps_its_longest_echo() -> None:
    readings = np.tile(np.round(1.5 / np.cos(np.linspace(-1.4, 1.4, 181)), 2), (100, 1))
    ranges, longest, _ = mark_echoes(readings)
    np.testing.assert_array_equal(ranges, readings)
    assert longest == readings.max()


def test_equal_ranges_all_around_are_a_round_room_not_a_code() -> None:
    assert np.isfinite(mark_echoes(np.full((1, 180), 2.0))[0]).all()


def test_declared_maximum() -> None:
    readings = hall(5.0)
    readings[2, 2] = 5.6
    assert np.isfinite(mark_echoes(readings)[0]).all()
    ranges, longest, _ = mark_echoes(readings, declared=5.6)
    assert np.isinf(ranges[2, 2])
    assert longest < 5.6


def test_a_declared_maximum_that_echoes_exceed_is_not_believed() -> None:
    readings = hall(20.0)
    np.testing.assert_array_equal(mark_echoes(readings, declared=8.0)[0], readings)


def test_zero_is_no_echo_only_where_the_log_has_no_other_code() -> None:
    readings = hall(10.0)
    readings[1, 1] = 0
    assert np.isinf(mark_echoes(readings)[0][1, 1])
    readings[2, 2] = 81.91
    ranges, _, _ = mark_echoes(readings)
    assert np.isnan(ranges[1, 1])
    assert np.isinf(ranges[2, 2])


def test_numbers_that_are_no_distance() -> None:
    readings = hall(10.0)
    readings[0, :5] = [np.nan, -1.0, np.inf, -np.inf, 1e9]
    ranges, longest, _ = mark_echoes(readings)
    assert np.isnan(ranges[0, [0, 1, 3, 4]]).all()
    assert np.isinf(ranges[0, 2])
    assert longest == readings[np.isfinite(readings) & (readings < 200)].max()


def test_no_echo_at_all() -> None:
    ranges, longest, _ = mark_echoes(np.full((3, 5), 81.91))
    assert np.isinf(ranges).all()
    assert longest == 0


def test_a_log_in_millimetres_is_told_at_once() -> None:
    readings = np.random.default_rng(0).uniform(300, 8000, (1000, 180))
    began = time.process_time()
    ranges, _, notes = mark_echoes(readings)
    assert time.process_time() - began < 2
    assert np.isnan(ranges).all()
    assert notes == ["180000 readings above 200 m ignored"]
