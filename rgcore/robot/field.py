"""Likelihood fields of lines (Thrun, Burgard, Fox: Probabilistic Robotics, 2005, section 6.4), one for each facing.

An echo is likely near a line that faces the same way; the back of a wall does not draw it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rgcore.geometry.compiled import inner, kernel

SECTORS = 8
"""Directions that normals are told apart by: 45 degrees each, and the next line beside counts too."""
HALF_WIDTH = 0.7
"""rad, how far a line's normal may be off the middle of a sector: half of it and 18 degrees for the echo's."""


class Field(NamedTuple):
    """``layers`` (SECTORS, H, W) uint8, 255 on a line; ``corner`` (2,) [m] of cell (0, 0), ``resolution`` [m]."""

    layers: np.ndarray
    corner: np.ndarray
    resolution: float


def line_field(ends: np.ndarray, resolution: float, deviation: float, margin: float) -> Field:
    """exp(-d^2 / (2 deviation^2)), d [m] to the nearest line of the sector; ``margin`` [m] around all lines."""
    corner = ends.min((0, 1)) - margin
    width, height = (np.ceil((ends.max((0, 1)) + margin - corner) / resolution) + 1).astype(int)
    layers = np.zeros((SECTORS, height, width), np.uint8)
    d = ends[:, 1] - ends[:, 0]
    _draw(ends.reshape(-1, 4), np.arctan2(d[:, 0], -d[:, 1]), corner, resolution, deviation, layers)
    return Field(layers, corner, resolution)


@inner
def sector_of(angle):  # type: ignore[no-untyped-def]
    """Sector of a direction [rad]."""
    return int(np.rint(angle * SECTORS / (2.0 * np.pi))) % SECTORS


@kernel
def _draw(ends, normals, corner, resolution, deviation, layers):  # type: ignore[no-untyped-def]
    _, height, width = layers.shape
    far = 2.6 * deviation
    for i in range(len(ends)):
        x0, y0, dx, dy = ends[i, 0], ends[i, 1], ends[i, 2] - ends[i, 0], ends[i, 3] - ends[i, 1]
        square = dx * dx + dy * dy
        low, high = min(y0, y0 + dy) - far, max(y0, y0 + dy) + far
        top = min(height, int((high - corner[1]) / resolution) + 1)
        for v in range(max(0, int((low - corner[1]) / resolution)), top):
            y = corner[1] + (v + 0.5) * resolution - y0
            # the part of the line near this row, so that long slanting lines cost no more than straight ones
            first, last = 0.0, 1.0
            if abs(dy) > 1e-9:
                a, b = (y - far) / dy, (y + far) / dy
                first, last = max(0.0, min(a, b)), min(1.0, max(a, b))
            left, right = x0 + min(first * dx, last * dx) - far, x0 + max(first * dx, last * dx) + far
            end = min(width, int((right - corner[0]) / resolution) + 1)
            for u in range(max(0, int((left - corner[0]) / resolution)), end):
                x = corner[0] + (u + 0.5) * resolution - x0
                t = min(max((dx * x + dy * y) / square, 0.0), 1.0)
                d2 = (x - t * dx) ** 2 + (y - t * dy) ** 2
                if d2 > far * far:
                    continue
                value = np.uint8(255.0 * np.exp(-0.5 * d2 / (deviation * deviation)))
                for s in range(SECTORS):
                    off = abs(normals[i] - s * 2.0 * np.pi / SECTORS) % (2.0 * np.pi)
                    if min(off, 2.0 * np.pi - off) <= HALF_WIDTH and value > layers[s, v, u]:
                        layers[s, v, u] = value


@kernel
def responses(points, normals, way, turns, positions, free, least_free, field):  # type: ignore[no-untyped-def]
    """Mean likelihood (T, P), 0..1, of points (n, 2) with normal angles (n,) at turns (T,) [rad] and positions (P, 2).

    Positions are cells (ix, iy) of the field; all points must stay on it. ``way`` (w, 2) are other places of the robot:
    a pose with less than ``least_free`` of them in cells that are ``free`` (H, W) gets 0.
    """
    _, height, width = field.layers.shape
    flat, out = field.layers.reshape(-1), np.zeros((len(turns), len(positions)), np.float32)
    offset, step = np.empty(len(points), np.int64), np.empty((len(way), 2), np.int64)
    for t in range(len(turns)):
        c, s = np.cos(turns[t]), np.sin(turns[t])
        for i in range(len(points)):
            x = int(np.rint((c * points[i, 0] - s * points[i, 1]) / field.resolution))
            y = int(np.rint((s * points[i, 0] + c * points[i, 1]) / field.resolution))
            offset[i] = (sector_of(normals[i] + turns[t]) * height + y) * width + x
        for i in range(len(way)):
            step[i, 0] = int(np.rint((c * way[i, 0] - s * way[i, 1]) / field.resolution))
            step[i, 1] = int(np.rint((s * way[i, 0] + c * way[i, 1]) / field.resolution))
        for p in range(len(positions)):
            inside = 0
            for i in range(len(way)):
                x, y = positions[p, 0] + step[i, 0], positions[p, 1] + step[i, 1]
                inside += 0 <= x < width and 0 <= y < height and free[y, x]
            if inside < least_free * len(way):
                continue
            at, total = positions[p, 1] * width + positions[p, 0], 0
            for i in range(len(points)):
                total += flat[at + offset[i]]
            out[t, p] = total / (255.0 * len(points))
    return out


@kernel
def climb(points, normals, poses, steps, field):  # type: ignore[no-untyped-def]
    """``poses`` (K, 3) moved uphill by ``steps`` (S, 2) [m, rad], coarse to fine; and their responses (K,)."""
    out, score = poses.copy(), np.zeros(len(poses))
    for k in range(len(poses)):
        best = _response(points, normals, out[k, 0], out[k, 1], out[k, 2], field)
        for j in range(len(steps)):
            moved = True
            rounds = 0
            while moved and rounds < 4:
                moved = False
                rounds += 1
                x, y, turn = out[k, 0], out[k, 1], out[k, 2]
                for i in range(27):
                    a, b = x + (i % 3 - 1) * steps[j, 0], y + (i // 3 % 3 - 1) * steps[j, 0]
                    t = turn + (i // 9 - 1) * steps[j, 1]
                    response = _response(points, normals, a, b, t, field)
                    if response > best:
                        best, moved = response, True
                        out[k, 0], out[k, 1], out[k, 2] = a, b, t
        score[k] = best
    return out, score


@inner
def _response(points, normals, x, y, turn, field):  # type: ignore[no-untyped-def]
    _, height, width = field.layers.shape
    c, s, total = np.cos(turn), np.sin(turn), 0
    for i in range(len(points)):
        u = int(np.floor((c * points[i, 0] - s * points[i, 1] + x - field.corner[0]) / field.resolution))
        v = int(np.floor((s * points[i, 0] + c * points[i, 1] + y - field.corner[1]) / field.resolution))
        if 0 <= u < width and 0 <= v < height:
            total += field.layers[sector_of(normals[i] + turn), v, u]
    return total / (255.0 * len(points))
