"""Logs with next to nothing in them, or with nonsense: a map of what there is, or one clear line."""

from __future__ import annotations

import numpy as np
import pytest

from rgcore.errors import InputError
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
    """The map as JSON, which all formats can be made of."""
    for ending in FORMATS:
        assert render(ending, made.map, made.trajectory)
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
        InputError, match=r"^room\.log: none of its 5 scans holds an echo nearer than slam\.max_range=25"
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
