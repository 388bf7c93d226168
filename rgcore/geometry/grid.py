"""Raster of the plane: a 2D array with an origin and a cell size.

Row 0 is the *smallest* y (so ``values[iy, ix]``), cell (ix, iy) covers ``origin + resolution * [ix..ix+1, iy..iy+1]``.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from rgcore.evidence import Evidence
from rgcore.geometry.compiled import kernel


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


def clearance(free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance of each free cell to the nearest one that is not [cells], and that cell (H, W, 2) as (ix, iy)."""
    distance, label = cv2.distanceTransformWithLabels(
        free.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    iy, ix = np.nonzero(~free)
    nearest = np.zeros((len(ix) + 1, 2), np.int32)
    nearest[label[iy, ix]] = np.stack([ix, iy], 1)
    return distance, nearest[label]


def components(mask: np.ndarray, diagonal: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Connected pieces of a mask: labels (H, W) from 1 on, and (n + 1, 5) x y width height area [cells]."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8 if diagonal else 4)
    return labels, stats


def dilate(mask: np.ndarray, radius: int) -> np.ndarray:
    """The mask grown by a disc [cells]."""
    return cv2.dilate(mask.astype(np.uint8), _disc(radius)) > 0


def erode(mask: np.ndarray, radius: int) -> np.ndarray:
    """The mask shrunk by a disc [cells]."""
    return cv2.erode(mask.astype(np.uint8), _disc(radius)) > 0


def grow(labels: np.ndarray, mask: np.ndarray, steps: int) -> np.ndarray:
    """Labels (0 = none) grown into a mask by so many cells, without ever taking a cell from one another."""
    out = labels.astype(np.float32)
    kernels = np.ones((3, 3), np.uint8), cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    for i in range(steps):
        out = np.where((out == 0) & mask, cv2.dilate(out, kernels[i % 2]), out)
    return out.astype(np.int32)


def _disc(radius: int) -> np.ndarray:
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    return (x * x + y * y <= (radius + 0.5) ** 2).astype(np.uint8)


def draw_lines(shape: tuple[int, int], starts: np.ndarray, ends: np.ndarray, width: int = 1) -> np.ndarray:
    """Mask of lines between cells (K, 2) given as (ix, iy)."""
    image = np.zeros(shape, np.uint8)
    for a, b in zip(np.asarray(starts, int), np.asarray(ends, int), strict=True):
        cv2.line(image, a.tolist(), b.tolist(), 1, width)
    return image > 0


def fill_polygons(mask: np.ndarray, polygons: list[np.ndarray], value: bool) -> np.ndarray:
    """The mask with polygons (n, 2) [cells, a cell's centre at .5] set to a value."""
    image = mask.astype(np.uint8)
    for p in polygons:
        cv2.fillPoly(image, [np.round((p - 0.5) * 16).astype(np.int32)], int(value), shift=4)
    return image > 0


@kernel
def reach(free: np.ndarray, starts: np.ndarray, directions: np.ndarray, limit: float) -> np.ndarray:
    """How far (K,) one comes in free cells from ``starts`` (K, 2) along unit ``directions`` (K, 2), at most ``limit``.

    All in cells; a start that is not free gives 0. Steps of half a cell.
    """
    out = np.zeros(len(starts))
    height, width = free.shape
    for i in range(len(starts)):
        s = 0.0
        while s <= limit:
            ix = int(np.floor(starts[i, 0] + s * directions[i, 0]))
            iy = int(np.floor(starts[i, 1] + s * directions[i, 1]))
            if ix < 0 or iy < 0 or ix >= width or iy >= height or not free[iy, ix]:
                break
            s += 0.5
        out[i] = s
    return out
