"""Fans of beams: where each reading of a scan points, and how scans of different fans become one table."""

from __future__ import annotations

from collections import Counter
from math import pi
from typing import NamedTuple

import numpy as np

_HUNDRED_DEGREES = {400: 401, 401: 401}
"""SICK scanners give 401 beams (400 where the last one is left out) only in their 100 degree mode of 0.25 degree steps."""


class Fan(NamedTuple):
    """``count`` beams from ``start`` [rad] on, counter-clockwise, ``step`` [rad] apart."""

    count: int
    start: float
    step: float

    @property
    def bearings(self) -> np.ndarray:
        """(count,) rad in the laser frame."""
        return self.start + self.step * np.arange(self.count)


def usual_fan(count: int) -> Fan:
    """The fan of a laser that a log says nothing of but its number of readings: 180 degrees, straight ahead in its middle.

    Odd counts include both ends (181, 361), even ones leave the last beam out (180, 360); 401 is the 100 degree mode.
    """
    if count in _HUNDRED_DEGREES:
        return Fan(count, -pi * 50 / 180, pi / 720)
    return Fan(count, -pi / 2, pi / max(count - count % 2, 1))


def one_table(rows: list[np.ndarray], fans: list[Fan]) -> tuple[np.ndarray, np.ndarray, int]:
    """All scans on the fan that most of them have: ``ranges (N, B)``, ``bearings (B,)``, number of scans that were moved.

    A scan of another fan gives each beam its reading of nearest bearing, ``nan`` where it has none near enough.
    """
    common, _ = Counter(fans).most_common(1)[0]
    bearings = common.bearings
    if all(fan == common for fan in fans):
        return np.array(rows), bearings, 0
    table, moved = np.full((len(rows), common.count), np.nan), 0
    for i, (row, fan) in enumerate(zip(rows, fans, strict=True)):
        moved += fan != common
        table[i] = row if fan == common else _resample(row, fan, bearings)
    return table, bearings, moved


def _resample(row: np.ndarray, fan: Fan, bearings: np.ndarray) -> np.ndarray:
    if fan.count == 0:
        return np.full(len(bearings), np.nan)
    index = np.rint((bearings - fan.start) / fan.step).astype(int) if fan.step else np.zeros(len(bearings), int)
    inside = (index >= 0) & (index < fan.count)
    return np.where(inside, row[np.clip(index, 0, fan.count - 1)], np.nan)
