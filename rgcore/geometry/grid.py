"""Raster of the plane: a 2D array with an origin and a cell size.

Row 0 is the *smallest* y (so ``values[iy, ix]``), cell (ix, iy) covers ``origin + resolution * [ix..ix+1, iy..iy+1]``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.evidence import Evidence


@dataclass(frozen=True, eq=False)
class Grid(Evidence):
    """``values (H, W)`` of any dtype, ``origin (2,)`` [m] the lower left corner, ``resolution`` [m] the cell size."""

    values: np.ndarray
    origin: np.ndarray
    resolution: float

    @classmethod
    def whole(cls) -> frozenset[str]:
        return frozenset({"values", "origin"})

    @property
    def shape(self) -> tuple[int, int]:
        return self.values.shape[0], self.values.shape[1]

    def cells(self, points: np.ndarray) -> np.ndarray:
        """Cell indices (..., 2) as ``(ix, iy)`` of points (..., 2) [m]; may lie outside the raster."""
        return np.floor((np.asarray(points, float) - self.origin) / self.resolution).astype(np.int64)

    def centers(self, cells: np.ndarray) -> np.ndarray:
        """Centres (..., 2) [m] of cells (..., 2) given as ``(ix, iy)``."""
        return self.origin + (np.asarray(cells, float) + 0.5) * self.resolution

    def at(self, points: np.ndarray, outside: float | int = 0) -> np.ndarray:
        """Values (...) at points (..., 2) [m]; ``outside`` where a point lies off the raster."""
        c = self.cells(points)
        h, w = self.shape
        inside = (c[..., 0] >= 0) & (c[..., 0] < w) & (c[..., 1] >= 0) & (c[..., 1] < h)
        out = np.full(inside.shape, outside, self.values.dtype)
        out[inside] = self.values[c[..., 1][inside], c[..., 0][inside]]
        return out

    def like(self, values: np.ndarray) -> Grid:
        """A raster of the same frame with other values."""
        return Grid(values, self.origin, self.resolution)
