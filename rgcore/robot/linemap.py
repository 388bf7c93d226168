"""The lines of a map, found by place: what a localization compares scans with."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rgcore.geometry.compiled import inner, kernel
from rgcore.geometry.raycast import cast

CELL = 0.5
"""Side of the cells [m] by which lines are found."""


class LineMap(NamedTuple):
    """Lines from ``start`` (L, 2) along ``along`` (L, 2), unit, for ``length`` (L,) [m]; free space lies to their left.

    The lines within ``reach`` [m] of cell c of a grid with ``corner`` (2,) and ``shape`` (columns, rows) are
    ``members[first[c]..first[c + 1]]``.
    """

    start: np.ndarray
    along: np.ndarray
    length: np.ndarray
    members: np.ndarray
    first: np.ndarray
    corner: np.ndarray
    shape: tuple[int, int]


def line_map(ends: np.ndarray, reach: float) -> LineMap:
    """The LineMap of lines ``ends`` (L, 2, 2), to be asked for the lines within ``reach`` [m] of a point."""
    start, d = np.array(ends[:, 0], float), ends[:, 1] - ends[:, 0]
    length = np.hypot(d[:, 0], d[:, 1])
    along = d / length[:, None]
    corner = ends.min((0, 1)) - reach - CELL
    shape = np.floor((ends.max((0, 1)) + reach - corner) / CELL).astype(int) + 2
    first = np.zeros(shape[0] * shape[1] + 1, np.int64)
    _bucket(start, along, length, corner, shape[0], shape[1], reach, first, np.zeros(0, np.int64))
    index = np.zeros(first.sum(), np.int64)
    first[1:] = np.cumsum(first[:-1])
    first[0] = 0
    _bucket(start, along, length, corner, shape[0], shape[1], reach, first[:-1].copy(), index)
    return LineMap(start, along, length, index, first, corner, (int(shape[0]), int(shape[1])))


def facing(lines: LineMap, eye: np.ndarray) -> np.ndarray:
    """(k,) indices of the lines whose free side an eye (2,) is on: the only ones that it can see."""
    off = eye - lines.start
    return np.flatnonzero(lines.along[:, 0] * off[:, 1] - lines.along[:, 1] * off[:, 0] > 0.0)


def expect(lines: LineMap, pose: np.ndarray, bearings: np.ndarray, max_range: float) -> tuple[np.ndarray, np.ndarray]:
    """Ranges (B,) [m] that the lines give a laser at ``pose`` (3,), inf for none; which lines it sees, mask (L,)."""
    front = facing(lines, pose[:2])
    start = lines.start[front]
    ends = np.stack([start, start + lines.along[front] * lines.length[front, None]], 1)
    ranges, hit = cast(ends, pose[None], bearings, max_range)
    seen = np.zeros(len(lines.start), np.bool_)
    seen[front[hit[0][hit[0] >= 0]]] = True
    return ranges[0], seen


@kernel
def _bucket(start, along, length, corner, columns, rows, reach, cursor, index):  # type: ignore[no-untyped-def]
    """Writes the lines of each cell from ``cursor`` on; without room in ``index`` it only counts them there."""
    far = reach + 0.71 * CELL
    for i in range(len(start)):
        x0, y0 = start[i, 0], start[i, 1]
        x1, y1 = x0 + along[i, 0] * length[i], y0 + along[i, 1] * length[i]
        for v in range(
            max(0, int((min(y0, y1) - far - corner[1]) / CELL)),
            min(rows - 1, int((max(y0, y1) + far - corner[1]) / CELL)) + 1,
        ):
            for u in range(
                max(0, int((min(x0, x1) - far - corner[0]) / CELL)),
                min(columns - 1, int((max(x0, x1) + far - corner[0]) / CELL)) + 1,
            ):
                x, y = corner[0] + (u + 0.5) * CELL - x0, corner[1] + (v + 0.5) * CELL - y0
                t = min(max(along[i, 0] * x + along[i, 1] * y, 0.0), length[i])
                x, y = x - t * along[i, 0], y - t * along[i, 1]
                if x * x + y * y > far * far:
                    continue
                c = v * columns + u
                if len(index) > 0:
                    index[cursor[c]] = i
                cursor[c] += 1


@inner
def nearest(lines, seen, x, y, dx, dy, agree, reach):  # type: ignore[no-untyped-def]
    """The nearest line within ``reach`` of (x, y) that is ``seen`` and whose normal agrees with (dx, dy), or -1."""
    u, v = int(np.floor((x - lines.corner[0]) / CELL)), int(np.floor((y - lines.corner[1]) / CELL))
    if u < 0 or v < 0 or u >= lines.shape[0] or v >= lines.shape[1]:
        return -1
    c = v * lines.shape[0] + u
    best, found = reach * reach, -1
    for k in range(lines.first[c], lines.first[c + 1]):
        i = lines.members[k]
        if not seen[i] or dy * lines.along[i, 0] - dx * lines.along[i, 1] < agree:
            continue
        ox, oy = x - lines.start[i, 0], y - lines.start[i, 1]
        t = min(max(lines.along[i, 0] * ox + lines.along[i, 1] * oy, 0.0), lines.length[i])
        ox, oy = ox - t * lines.along[i, 0], oy - t * lines.along[i, 1]
        d = ox * ox + oy * oy
        if d < best:
            best, found = d, i
    return found
