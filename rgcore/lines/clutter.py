"""Short lines through echoes that no line explains: table legs, chairs, pillars, corners that segments leave out.

Such things are a few echoes in each scan, too few for a segment (paper, section IV-C: "particularly true for
table-legs"), but all scans together show them well. Where echoes of several scans lie densest a strip begins; it
grows both ways as long as echoes follow, fitted anew each time. Whether it stays, its worth decides.
"""

from __future__ import annotations

import numpy as np

from rgcore.geometry.compiled import kernel

_CELL = 0.04  # m, of the hash
_RADIUS = 0.06  # m: echoes of one leg, with the noise of ranges and poses
_ASIDE = 0.03  # m: echoes of one strip lie nearer to its line
_GAP = 0.06  # m: within a strip
_ROUNDS = 4  # of fitting anew
_LEAST = 3  # echoes
_PAD = 0.02  # m: things reach a little farther than their outermost echoes; what is too much its worth cuts
_SHORT = 0.2  # m: of shorter strips the direction is chance, so that across is tried, too
_SHIFT = 1 << 21  # cells: farther than any map reaches


def strips(points: np.ndarray, beams: np.ndarray) -> np.ndarray:
    """Lines (K, 2, 2) through points (P, 2) [m] that the beams of directions ``beams`` (P, 2) hit; free space left."""
    cells = np.floor(points / _CELL).astype(np.int64)
    keys = (cells[:, 0] + _SHIFT // 2) * _SHIFT + cells[:, 1] + _SHIFT // 2
    by_key = np.argsort(keys, kind="stable")
    known, first, count = np.unique(keys[by_key], return_index=True, return_counts=True)
    around = sum(_count_at(known, count, known + dx * _SHIFT + dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1))
    density = np.zeros(len(points))
    density[by_key] = np.repeat(around, count)
    order = np.argsort(-density, kind="stable")
    order = order[density[order] >= _LEAST]
    lines = _grow(points, beams, known, np.append(first, len(keys)), by_key, order)
    d = lines[:, 1] - lines[:, 0]
    d[~d.any(1)] = (1e-6, 0.0)  # echoes all in one place: any direction does
    length = np.hypot(*d.T)
    along = d / np.maximum(length, 1e-9)[:, None] * (0.5 * np.maximum(length, _CELL) + _PAD)[:, None]
    middle, short = lines.mean(1), length < _SHORT
    across = np.stack([-along[:, 1], along[:, 0]], 1) * (_RADIUS / np.hypot(*along.T))[:, None]
    return np.concatenate(
        [
            np.stack([middle - along, middle + along], 1),
            np.stack([middle - across, middle + across], 1)[short],
        ]
    )


def _count_at(known: np.ndarray, count: np.ndarray, keys: np.ndarray) -> np.ndarray:
    at = np.minimum(np.searchsorted(known, keys), len(known) - 1)
    return np.where(known[at] == keys, count[at], 0)


@kernel
def _grow(points, beams, known, first, members, order):  # type: ignore[no-untyped-def]
    n = len(points)
    used, asked, group = np.zeros(n, np.bool_), np.full(n, -1), np.zeros(n, np.int64)
    out, found = np.zeros((len(order), 2, 2)), 0
    for seed in order:
        if used[seed]:
            continue
        cx, cy, ux, uy, low, high, size = points[seed, 0], points[seed, 1], 0.0, 0.0, 0.0, 0.0, 0
        for turn in range(_ROUNDS):
            size, steps = 0, int((high - low + 2 * _RADIUS) / _CELL) + 2
            for step in range(steps):
                t = low - _RADIUS + (high - low + 2 * _RADIUS) * step / (steps - 1)
                ix, iy = int(np.floor((cx + t * ux) / _CELL)), int(np.floor((cy + t * uy) / _CELL))
                for look in range(25):
                    key = (ix + look // 5 - 2 + _SHIFT // 2) * _SHIFT + iy + look % 5 - 2 + _SHIFT // 2
                    c = np.searchsorted(known, key)
                    if c == len(known) or known[c] != key:
                        continue
                    for e in range(first[c], first[c + 1]):
                        i = members[e]
                        if used[i] or asked[i] == seed * _ROUNDS + turn:
                            continue
                        dx, dy = points[i, 0] - cx, points[i, 1] - cy
                        s, off = dx * ux + dy * uy, abs(dy * ux - dx * uy)
                        near = low - _GAP < s < high + _GAP and off < _ASIDE
                        if near if turn else dx * dx + dy * dy < _RADIUS * _RADIUS:
                            asked[i], group[size] = seed * _ROUNDS + turn, i
                            size += 1
            if size < _LEAST:
                break
            cx, cy, ux, uy, low, high = _fit(points, group, size)
        if size < _LEAST:
            used[seed] = True
            continue
        side = 0.0
        for k in range(size):
            used[group[k]] = True
            side += ux * beams[group[k], 1] - uy * beams[group[k], 0]
        if side > 0:  # beams come from the left
            ux, uy, low, high = -ux, -uy, -high, -low
        out[found, 0, 0], out[found, 0, 1] = cx + low * ux, cy + low * uy
        out[found, 1, 0], out[found, 1, 1] = cx + high * ux, cy + high * uy
        found += 1
    return out[:found]


@kernel
def _fit(points, group, size):  # type: ignore[no-untyped-def]
    """Middle, direction and reach of a group of points: total least squares."""
    x, y, xx, yy, xy = 0.0, 0.0, 0.0, 0.0, 0.0
    ox, oy = points[group[0], 0], points[group[0], 1]
    for k in range(size):
        dx, dy = points[group[k], 0] - ox, points[group[k], 1] - oy
        x, y, xx, yy, xy = x + dx, y + dy, xx + dx * dx, yy + dy * dy, xy + dx * dy
    mx, my = x / size, y / size
    angle = 0.5 * np.arctan2(2 * (xy / size - mx * my), xx / size - mx * mx - yy / size + my * my)
    cx, cy, ux, uy = ox + mx, oy + my, np.cos(angle), np.sin(angle)
    low, high = np.inf, -np.inf
    for k in range(size):
        s = (points[group[k], 0] - cx) * ux + (points[group[k], 1] - cy) * uy
        low, high = min(low, s), max(high, s)
    return cx, cy, ux, uy, low, high
