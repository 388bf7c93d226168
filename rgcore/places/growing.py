"""The free space while it grows: a raster that takes scans one by one, and follows when their poses move."""

from __future__ import annotations

import numpy as np

from rgcore.config import Places as Settings
from rgcore.errors import RgError
from rgcore.places.freespace import MARGIN, MOST_CELLS, FreeSpace, cast, reaches, tips_of, too_large

STEP = 128
"""Cells that the raster grows by at least, so that it seldom has to."""


class GrowingSpace:
    """Counts of beams as in :func:`rgcore.places.freespace.free_space`, scan by scan.

    A scan that turns out to stand elsewhere is taken out again and cast from there: the counts are then those of
    scans that have never stood anywhere else.
    """

    def __init__(self, bearings: np.ndarray, max_range: float, settings: Settings) -> None:
        self.bearings, self.max_range, self.settings = np.asarray(bearings, float), max_range, settings
        self._low = np.zeros(2, np.int64)  # number of its first cell; cell 0 begins at the origin of the map
        self._counts = np.zeros((2, 0, 0), np.int32)

    def add(self, ranges: np.ndarray, poses: np.ndarray) -> None:
        """Cast scans (K, B) from ``poses`` (K, 3), map_from_laser. Raises RgError if the raster gets too large."""
        self._cast(ranges, poses, 1)

    def move(self, ranges: np.ndarray, before: np.ndarray, after: np.ndarray) -> None:
        """Move scans (K, B) that were cast from poses ``before`` (K, 3) to ``after`` (K, 3)."""
        self._cast(ranges, before, -1)
        self._cast(ranges, after, 1)

    def free_space(self) -> FreeSpace:
        """A copy of what there is."""
        hits, passes = self._counts.copy()
        res = self.settings.resolution
        return FreeSpace(hits, passes, self._low * res, res)

    def window(self, center: np.ndarray, half: float) -> FreeSpace:
        """A view of the part within ``half`` [m] of ``center`` (2,)."""
        res = self.settings.resolution
        size = np.array(self._counts.shape[:0:-1])
        a = np.clip(np.floor((center - half) / res).astype(int) - self._low, 0, size)
        b = np.clip(np.ceil((center + half) / res).astype(int) - self._low, 0, size)
        hits, passes = self._counts[:, a[1] : b[1], a[0] : b[0]]
        return FreeSpace(hits, passes, (self._low + a) * res, res)

    def _cast(self, ranges: np.ndarray, poses: np.ndarray, weight: int) -> None:
        reach, ends = reaches(ranges, self.max_range, self.settings)
        res = self.settings.resolution
        tips = tips_of(poses, self.bearings, reach) / res
        used = reach > 0
        starts = poses[:, :2] / res
        if weight > 0:
            self._make_room(np.concatenate([tips[used], starts]))
        cast(starts - self._low, tips - self._low, used, ends, self._counts, weight)

    def _make_room(self, cells: np.ndarray) -> None:
        """Grow so far that all cells lie well inside."""
        low, high = np.floor(cells.min(0)).astype(int) - MARGIN, np.ceil(cells.max(0)).astype(int) + MARGIN
        size = np.array(self._counts.shape[:0:-1])
        if self._counts.size == 0:
            self._low = low
        before = np.where(low < self._low, self._low - low + STEP, 0)
        after = np.where(high > self._low + size, high - self._low - size + STEP, 0)
        if not (before.any() or after.any()):
            return
        width, height = size + before + after
        if int(width) * int(height) > MOST_CELLS:
            res = self.settings.resolution
            raise RgError(too_large(width * res, height * res, self.settings))
        self._counts = np.pad(self._counts, ((0, 0), (before[1], after[1]), (before[0], after[0])))
        self._low = self._low - before
