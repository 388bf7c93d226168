"""Global correlation: P(l | m, s), where on a map a scan fits, over a whole window of poses.

The likelihood field of the map is correlated with the scan over x, y and theta; branch and bound over sliding maxima of
the field finds the global maximum without visiting every pose (Olson, ICRA 2009; Hess et al., ICRA 2016).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rgcore.geometry.compiled import inner, kernel
from rgcore.slam.small import wrapped

LEVELS = 5
"""Levels of the search: blocks of 2**(LEVELS - 1) = 16 cells a side at the top."""
APART = (0.6, 0.25)
"""[m, rad] farther than this from the maximum is another answer, not the same one."""


FREE = np.zeros(3)
"""No pose costs more than another."""


class Field(NamedTuple):
    """``levels`` (LEVELS, H, W) uint8: level k holds, a cell, the maximum of the likelihood (0..255) over the 2**k
    cells right of it and above; ``corner`` (2,) [m] of cell (0, 0), ``resolution`` [m].
    """

    levels: np.ndarray
    corner: np.ndarray
    resolution: float


class Peak(NamedTuple):
    """The maximum: ``pose`` (3,), its ``response`` (mean likelihood of the scan's points, 0..1), and the
    ``covariance`` (3, 3) of the distribution around it.
    """

    pose: np.ndarray
    response: float
    covariance: np.ndarray


def likelihood_field(points: np.ndarray, resolution: float = 0.05, deviation: float = 0.06) -> Field:
    """The field of a map with surface points (n, 2): exp(-d^2 / (2 deviation^2)), d the distance to the nearest."""
    margin = 2 ** (LEVELS - 1) + int(3 * deviation / resolution) + 1
    corner = points.min(0) - margin * resolution
    size = np.floor((points.max(0) - corner) / resolution).astype(int) + margin + 1
    return Field(_levels(points, corner, size[0], size[1], resolution, deviation), corner, resolution)


def correlate(
    points: np.ndarray,
    field: Field,
    centre: np.ndarray,
    window: np.ndarray,
    least: float,
    rival: float,
    cost: np.ndarray = FREE,
) -> Peak | None:
    """The best pose of a scan within ``centre`` (3,) +- ``window`` (3,); None if no response there exceeds ``least``,
    or if another answer reaches ``rival`` times the best one.

    ``points`` (n, 2) are the scan's surface points in its own frame. ``cost`` (3,) is what a pose away from the centre
    loses of its response: by square metre, by square radian, and at most.
    """
    far = max(1.0, float(np.quantile(np.hypot(points[:, 0], points[:, 1]), 0.8)))
    step = min(0.02, field.resolution / far)
    turns = np.arange(-np.ceil(window[2] / step), np.ceil(window[2] / step) + 1) * step + centre[2]
    cells = np.ceil(np.asarray(window[:2]) / field.resolution).astype(np.int64)
    nowhere = np.full(3, 1 << 40, np.int64)
    span = np.array([APART[0] / field.resolution, APART[0] / field.resolution, APART[1] / step]).astype(np.int64)
    best, top = _search(points, field, centre, turns, cells, nowhere, span, least, cost)
    if top <= 0 or _search(points, field, centre, turns, cells, best, span, rival * top, cost)[1] > 0:
        return None
    pose, covariance = _moments(points, field, centre, turns, best)
    return Peak(pose, top, covariance)


@kernel
def _levels(points, corner, width, height, resolution, deviation):  # type: ignore[no-untyped-def]
    levels = np.zeros((LEVELS, height, width), np.uint8)
    r = int(3 * deviation / resolution) + 1
    for i in range(len(points)):
        u, v = (points[i, 0] - corner[0]) / resolution, (points[i, 1] - corner[1]) / resolution
        cu, cv = int(u), int(v)
        for y in range(cv - r, cv + r + 1):
            for x in range(cu - r, cu + r + 1):
                d2 = ((x + 0.5 - u) ** 2 + (y + 0.5 - v) ** 2) * resolution * resolution
                value = np.uint8(255.0 * np.exp(-0.5 * d2 / (deviation * deviation)))
                if value > levels[0, y, x]:
                    levels[0, y, x] = value
    for k in range(1, LEVELS):
        h = 1 << (k - 1)
        for y in range(height):
            up = min(y + h, height - 1)
            for x in range(width):
                right = min(x + h, width - 1)
                a = max(levels[k - 1, y, x], levels[k - 1, y, right])
                levels[k, y, x] = max(a, max(levels[k - 1, up, x], levels[k - 1, up, right]))
    return levels


@inner
def _score(level, cx, cy, u, v):  # type: ignore[no-untyped-def]
    """Mean likelihood 0..1 of points whose cells are (cx, cy), moved by (u, v) cells."""
    height, width = level.shape
    total = 0
    for i in range(len(cx)):
        x, y = cx[i] + u, cy[i] + v
        if 0 <= x < width and 0 <= y < height:
            total += level[y, x]
    return total / (255.0 * len(cx))


@inner
def _cells(points, field, centre, turn, cx, cy):  # type: ignore[no-untyped-def]
    c, s = np.cos(turn), np.sin(turn)
    for i in range(len(points)):
        cx[i] = int(np.floor((c * points[i, 0] - s * points[i, 1] + centre[0] - field.corner[0]) / field.resolution))
        cy[i] = int(np.floor((s * points[i, 0] + c * points[i, 1] + centre[1] - field.corner[1]) / field.resolution))


@inner
def _loss(u, v, side, turn, resolution, cost):  # type: ignore[no-untyped-def]
    """Least cost of a pose in the block of cells u..u + side, v..v + side, ``turn`` from the centre."""
    x, y = max(0, max(u, -u - side)) * resolution, max(0, max(v, -v - side)) * resolution
    return min(cost[2], cost[0] * (x * x + y * y) + cost[1] * turn * turn)


@kernel
def _search(points, field, centre, turns, cells, taken, span, least, cost):  # type: ignore[no-untyped-def]
    """Branch and bound: the best (u, v, turn) outside ``taken`` +- ``span``, and its score if above ``least``, else
    0.
    """
    top = LEVELS - 1
    block = 1 << top
    columns, rows = 2 * cells[0] // block + 1, 2 * cells[1] // block + 1
    cx, cy = np.empty((len(turns), len(points)), np.int64), np.empty((len(turns), len(points)), np.int64)
    bounds = np.empty(len(turns) * columns * rows)
    for t in range(len(turns)):
        _cells(points, field, centre, turns[t], cx[t], cy[t])
        for b in range(columns * rows):
            u, v = b % columns * block - cells[0], b // columns * block - cells[1]
            loss = _loss(u, v, block - 1, turns[t] - centre[2], field.resolution, cost)
            bounds[t * columns * rows + b] = _score(field.levels[top], cx[t], cy[t], u, v) - loss
    best, found = least, np.zeros(3, np.int64)
    found[2] = -1
    stack = np.empty((4 * LEVELS, 3), np.int64)
    promising = np.argmax(bounds)  # first, for a high bar from the start
    for order in range(-1, len(bounds)):
        index = promising if order < 0 else order
        if bounds[index] <= best or order == promising:
            continue
        t, b = index // (columns * rows), index % (columns * rows)
        stack[0, 0], stack[0, 1], stack[0, 2] = b % columns * block - cells[0], b // columns * block - cells[1], top
        size = 1
        while size > 0:
            size -= 1
            u, v, k = stack[size, 0], stack[size, 1], stack[size, 2]
            side = (1 << k) - 1
            if (
                abs(t - taken[2]) <= span[2]
                and abs(u - taken[0]) <= span[0]
                and abs(u + side - taken[0]) <= span[0]
                and abs(v - taken[1]) <= span[1]
                and abs(v + side - taken[1]) <= span[1]
            ):
                continue
            if k == top:
                score = bounds[index]
            else:
                loss = _loss(u, v, side, turns[t] - centre[2], field.resolution, cost)
                score = _score(field.levels[k], cx[t], cy[t], u, v) - loss
            if score <= best:
                continue
            if k == 0:
                best = score
                found[0], found[1], found[2] = u, v, t
                continue
            half = 1 << (k - 1)
            for q in range(4):
                stack[size, 0], stack[size, 1], stack[size, 2] = u + (q & 1) * half, v + (q >> 1) * half, k - 1
                size += 1
    return found, best if found[2] >= 0 else 0.0


@kernel
def _moments(points, field, centre, turns, best):  # type: ignore[no-untyped-def]
    """Mean (3,) and covariance (3, 3) of the distribution around its maximum (Olson 2009, section IV)."""
    cx, cy = np.empty(len(points), np.int64), np.empty(len(points), np.int64)
    _cells(points, field, centre, turns[best[2]], cx, cy)
    peak = _score(field.levels[0], cx, cy, best[0], best[1])
    step = turns[1] - turns[0] if len(turns) > 1 else 0.01
    total, first, second, x = 0.0, np.zeros(3), np.zeros((3, 3)), np.zeros(3)
    for t in range(-4, 5):
        x[2] = t * step
        _cells(points, field, centre, turns[best[2]] + x[2], cx, cy)
        for v in range(-12, 13, 2):
            for u in range(-12, 13, 2):
                score = _score(field.levels[0], cx, cy, best[0] + u, best[1] + v)
                w = np.exp((score - peak) * len(points) / 4.0)  # neighbouring points err together, four by four
                x[0], x[1] = u * field.resolution, v * field.resolution
                total += w
                for i in range(3):
                    first[i] += w * x[i]
                    for j in range(3):
                        second[i, j] += w * x[i] * x[j]
    for i in range(3):
        first[i] /= total
    for i in range(3):
        for j in range(3):
            second[i, j] = second[i, j] / total - first[i] * first[j]
        second[i, i] += (step if i == 2 else 2.0 * field.resolution) ** 2 / 12.0
    first[0] += centre[0] + best[0] * field.resolution
    first[1] += centre[1] + best[1] * field.resolution
    first[2] = wrapped(first[2] + turns[best[2]])
    return first, second
