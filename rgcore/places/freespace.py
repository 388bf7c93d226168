"""Free space: where the laser saw through."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rgcore.config import Places as Settings
from rgcore.errors import RgError
from rgcore.evidence import Evidence
from rgcore.geometry.compiled import kernel
from rgcore.geometry.grid import Grid
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

MARGIN = 10
"""Cells of unknown space around everything that was seen, so that no later step has to care for the raster's edge."""

MOST_CELLS = 64_000_000
"""Cells of a raster: 400 x 400 m at 5 cm, some GB for the masks made of it. Mapped buildings stay far below; what goes
beyond is odometry that jumps."""

SHORT_SIGHTED = 10.0
"""m: no echo of a laser with a shorter range means far; of any other it means glass, sky or black."""


@dataclass(frozen=True, eq=False)
class FreeSpace(Evidence):
    """Counts of beams on one raster.

    hits    (H, W) beams that ended in the cell
    passes  (H, W) beams that went through it
    origin, resolution: the frame of the raster, as in Grid
    """

    hits: np.ndarray
    passes: np.ndarray
    origin: np.ndarray
    resolution: float

    @classmethod
    def whole(cls) -> frozenset[str]:
        return frozenset({"hits", "passes", "origin"})

    def grid(self, values: np.ndarray) -> Grid:
        return Grid(values, self.origin, self.resolution)


def free_space(log: ScanLog, trajectory: Trajectory, settings: Settings) -> FreeSpace:
    """Cast every beam of every scan into a raster that holds them all.

    A beam counts as a pass in each cell between the laser and its echo and as a hit in the cell of the echo, which is
    the counting model of a reflection map (Haehnel et al. 2003). A beam without an echo is free as far as
    ``settings.no_echo_reach`` (a laser with a short range: nearly as far as that), but only where its neighbours have
    none either: single ones are drop-outs. Raises RgError if the raster would take more than ``MOST_CELLS``.
    """
    reach, ends = reaches(log.ranges, log.max_range, settings)
    poses = trajectory.map_from_laser
    tips = tips_of(poses, log.bearings, reach)
    used = reach > 0
    corners = np.concatenate([tips[used], poses[:, :2]])
    res = settings.resolution
    low = np.floor(corners.min(0) / res) - MARGIN
    width, height = (np.ceil(corners.max(0) / res) - low + MARGIN).astype(int)
    if int(width) * int(height) > MOST_CELLS:
        raise RgError(too_large(width * res, height * res, settings))
    counts = np.zeros((2, height, width), np.int32)
    cast(poses[:, :2] / res - low, tips / res - low, used, ends, counts, 1)
    return FreeSpace(counts[0], counts[1], low * res, res)


def too_large(width: float, height: float, settings: Settings) -> str:
    """What to tell of a map of so many metres."""
    coarsest = 0.5
    needed = math.sqrt(width * height / MOST_CELLS)
    text = f"the map spans {width:.0f} x {height:.0f} m, too much for cells of {settings.resolution:g} m"
    if needed > coarsest:
        return f"{text}; look for jumps in the log's odometry"
    coarser = math.ceil(needed * 100 + 1) / 100
    return f"{text}; look for jumps in the log's odometry, or give places.resolution={min(coarser, coarsest):g}"


def tips_of(poses: np.ndarray, bearings: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """(N, B, 2) where beams end that come as far as ``reach`` (N, B) from ``poses`` (N, 3)."""
    angle = poses[:, None, 2] + bearings[None]
    return poses[:, None, :2] + reach[..., None] * np.stack([np.cos(angle), np.sin(angle)], -1)


def reaches(ranges: np.ndarray, max_range: float, settings: Settings) -> tuple[np.ndarray, np.ndarray]:
    """How far each beam is known to be free (N, B), 0 where nothing is known; and whether it ends in an echo (N, B)."""
    limit = min(max_range, settings.max_range)
    r = np.where(ranges > 0, ranges, np.nan)
    echo = r < limit
    lost = np.isinf(r)
    group = lost.copy()
    for shift in (1, 2):
        before, after = np.zeros_like(lost), np.zeros_like(lost)
        before[:, shift:], after[:, :-shift] = lost[:, :-shift], lost[:, shift:]
        group &= before | after
    reach = np.where(np.isnan(r), 0.0, np.minimum(np.nan_to_num(r, posinf=0.0), limit))
    reach[lost] = 0.0
    reach[group] = 0.9 * limit if limit < SHORT_SIGHTED else min(limit, settings.no_echo_reach)
    return reach, echo


@kernel
def cast(starts, tips, used, ends, counts, weight):  # type: ignore[no-untyped-def]
    """Step along each beam, one cell of its longer axis at a time, and add ``weight``; coordinates are in cells.

    With a weight of -1 it takes back what was cast before.
    """
    n, beams = used.shape
    for i in range(n):
        sx, sy = starts[i, 0], starts[i, 1]
        for j in range(beams):
            if not used[i, j]:
                continue
            tx, ty = tips[i, j, 0], tips[i, j, 1]
            ix, iy = int(tx), int(ty)
            dx, dy = tx - sx, ty - sy
            steps = int(max(abs(dx), abs(dy))) + 1
            dx /= steps
            dy /= steps
            px, py = -1, -1
            for k in range(steps + 1):
                cx, cy = int(sx + k * dx), int(sy + k * dy)
                if cx == ix and cy == iy:
                    break
                if cx != px or cy != py:
                    counts[1, cy, cx] += weight
                    px, py = cx, cy
            if ends[i, j]:
                counts[0, iy, ix] += weight
