"""Fans of beams: where each reading of a scan points, and how scans of different fans become one table."""

from __future__ import annotations

from collections import Counter
from math import pi
from typing import NamedTuple

import numpy as np

_HUNDRED_DEGREES = (400, 401)
"""Readings of SICK scanners in their 100 degree mode, a quarter of a degree apart (400: the last one left out)."""


class Fan(NamedTuple):
    """``beams`` beams from ``start`` [rad] on, counter-clockwise, ``step`` [rad] apart."""

    beams: int
    start: float
    step: float

    @property
    def bearings(self) -> np.ndarray:
        """(beams,) rad in the laser frame."""
        return self.start + self.step * np.arange(self.beams)


def usual_fan(count: int) -> Fan:
    """The fan of a laser of which a log tells the number of readings only: 180 degrees, straight ahead in its middle.

    Odd counts include both ends (181, 361), even ones leave the last beam out (180, 360).
    """
    if count in _HUNDRED_DEGREES:
        return Fan(count, -pi * 50 / 180, pi / 720)
    return Fan(count, -pi / 2, pi / max(count - count % 2, 1))


def one_table(rows: list[np.ndarray], fans: list[Fan]) -> tuple[np.ndarray, np.ndarray, int]:
    """All scans on the fan that most of them have: ``ranges (N, B)``, ``bearings (B,)``, number of scans moved to it.

    A scan of another fan gives each beam its reading of nearest bearing, ``nan`` where it has none near enough.
    """
    common, _ = Counter(fans).most_common(1)[0]
    bearings = common.bearings
    if all(fan == common for fan in fans):
        return np.array(rows), bearings, 0
    table, moved = np.full((len(rows), common.beams), np.nan), 0
    for i, (row, fan) in enumerate(zip(rows, fans, strict=True)):
        moved += fan != common
        table[i] = row if fan == common else _resample(row, fan, bearings)
    return table, bearings, moved


def _resample(row: np.ndarray, fan: Fan, bearings: np.ndarray) -> np.ndarray:
    if fan.beams == 0:
        return np.full(len(bearings), np.nan)
    index = np.rint((bearings - fan.start) / fan.step).astype(int) if fan.step else np.zeros(len(bearings), int)
    inside = (index >= 0) & (index < fan.beams)
    return np.where(inside, row[np.clip(index, 0, fan.beams - 1)], np.nan)
