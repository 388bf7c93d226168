"""Logs with next to nothing in them, or with nonsense: a map of what there is, or one clear line."""

from __future__ import annotations

import numpy as np
import pytest

from rgcore.errors import InputError, RgError
from rgcore.exports import rgjson
from rgcore.exports.formats import FORMATS, render
from rgcore.pipeline import Run, run
from rgcore.scans.log import ScanLog

BEARINGS = np.radians(np.arange(-90, 90, 2.0))


def room(scans: int, bearings: np.ndarray = BEARINGS) -> ScanLog:
    """A robot that stands in a room of 6 x 4 m and turns."""
    odom = np.column_stack([np.zeros(scans), np.zeros(scans), np.linspace(0, 3, scans)])
    angle = odom[:, 2:] + bearings
    with np.errstate(divide="ignore"):
        walls = np.minimum(3 / np.abs(np.cos(angle)), 2 / np.abs(np.sin(angle)))
    return ScanLog(np.arange(scans) * 0.2, walls, odom, bearings, np.zeros(3), 10.0, source="room.log")


def with_ranges(log: ScanLog, ranges: np.ndarray) -> ScanLog:
    return ScanLog(log.stamps, ranges, log.odom_from_base, log.bearings, log.base_from_laser, 10.0, source=log.source)


def exported(made: Run) -> str:
    """The map as JSON; all formats can be made of it, or say that there is nothing in it."""
    for ending in FORMATS:
        try:
            assert render(ending, made.map, made.trajectory)
        except RgError as e:
            if "the map is empty" not in str(e) or made.map.lines or made.map.regions:
                raise
    return rgjson.render(made.map, made.trajectory, None).data.decode()  # type: ignore[arg-type]


@pytest.mark.parametrize("scans", [1, 2, 3])
def test_few_scans_give_a_small_map(scans: int) -> None:
    made = run(room(scans))
    assert len(made.trajectory) == scans
    assert len(made.map.regions) <= 1
    assert '"format": "rgmap"' in exported(made)


def test_a_laser_of_one_beam_gives_a_map_without_lines() -> None:
    made = run(room(20, np.zeros(1)))
    assert not made.map.lines
    assert '"lines": []' in exported(made)


@pytest.mark.parametrize("nothing", [np.inf, np.nan, -1.0, 0.0, 1e9])
def test_a_log_without_echoes_is_refused(nothing: float) -> None:
    log = room(5)
    with pytest.raises(
        InputError, match=r"^room\.log: none of its 5 scans holds an echo nearer than slam\.max_range=\d+ m"
    ):
        run(with_ranges(log, np.full(log.ranges.shape, nothing)))


def test_nonsense_between_the_readings_does_not_disturb_the_map() -> None:
    log = room(40)
    ranges = log.ranges.copy()
    for beam, value in ((3, np.nan), (20, np.inf), (33, -4.0), (50, 0.0), (71, -np.inf), (80, 1e9)):
        ranges[:, beam] = value
    found = run(with_ranges(log, ranges)).map
    assert len(found.regions) == 1
    ends = np.abs([(line.start, line.end) for line in found.lines.values()])
    off = np.minimum(np.abs(ends[..., 0] - 3), np.abs(ends[..., 1] - 2))
    assert len(ends) >= 4
    assert off.max() < 0.05


def test_the_place_of_the_origin_does_not_matter() -> None:
    log = room(40)
    far = ScanLog(
        log.stamps, log.ranges, log.odom_from_base + np.array([1e6, -1e6, 0]), log.bearings, log.base_from_laser, 10.0
    )
    near, off = run(log).map, run(far).map
    assert len(near.lines) == len(off.lines)
    assert len(near.regions) == len(off.regions) == 1


def walls_off(made: Run) -> float:
    """[m] how far the ends of the lines lie from the walls of the room, at most; there are some."""
    ends = np.abs([(line.start, line.end) for line in made.map.lines.values()])
    assert len(ends) >= 4
    return float(np.minimum(np.abs(ends[..., 0] - 3), np.abs(ends[..., 1] - 2)).max())


def taken(log: ScanLog, scans: np.ndarray, stamps: np.ndarray, odom: np.ndarray | None = None) -> ScanLog:
    """Some scans of a log, in that order."""
    odom = log.odom_from_base[scans] if odom is None else odom
    return ScanLog(stamps, log.ranges[scans], odom, log.bearings, log.base_from_laser, 10.0, source=log.source)


@pytest.mark.parametrize("nothing", [np.inf, np.nan])
def test_a_laser_that_wakes_up_late_gives_the_same_room(nothing: float) -> None:
    log = room(40)
    ranges = log.ranges.copy()
    ranges[:15] = nothing
    made = run(with_ranges(log, ranges))
    assert len(made.map.regions) == 1
    assert walls_off(made) < 0.05
    np.testing.assert_allclose(made.trajectory.map_from_base, log.odom_from_base, atol=0.02)


def test_every_scan_twice_is_the_same_map() -> None:
    log, twice = room(40), np.repeat(np.arange(40), 2)
    made = run(taken(log, twice, log.stamps[twice]))
    assert len(made.map.regions) == 1
    assert walls_off(made) < 0.05
    pairs = made.trajectory.map_from_base.reshape(40, 2, 3)
    np.testing.assert_allclose(pairs[:, 0], pairs[:, 1], atol=1e-3)


def test_odometry_that_never_moves_does_not_hold_the_robot_back() -> None:
    log = room(60)
    made = run(taken(log, np.arange(60), log.stamps, np.zeros((60, 3))))
    assert len(made.map.regions) == 1
    assert walls_off(made) < 0.06
    turned = np.unwrap(made.trajectory.map_from_base[:, 2])
    np.testing.assert_allclose(turned, log.odom_from_base[:, 2], atol=0.03)


def test_time_that_runs_backwards_keeps_the_order_of_the_file() -> None:
    log = room(40)
    made = run(taken(log, np.arange(40), log.stamps[::-1].copy()))
    forward = run(log)
    assert walls_off(made) < 0.05
    np.testing.assert_allclose(made.trajectory.map_from_base, forward.trajectory.map_from_base, atol=1e-9)
    assert '"format": "rgmap"' in exported(made)
