"""Growing lines from their strongest segment until nothing changes; the inner loop of the merging."""

from __future__ import annotations

import numpy as np
from numba import njit

from rgcore.config import Lines as Settings
from rgcore.geometry import segments as geometry
from rgcore.geometry.moments import line_through
from rgcore.lines.distance import measure

_CELL = 0.5  # m, of the hash: about the length of a usual segment
_TURNS = 12  # bins of direction, 30 degrees each: a segment's own and its neighbours hold all that may join it
_MOST_ROUNDS = 8  # of fitting anew; nearly all lines stand still after three


def grow_lines(
    ends: np.ndarray, points: np.ndarray, region: np.ndarray, settings: Settings
) -> tuple[np.ndarray, np.ndarray]:
    """Infinite lines (G, 4), a point and the unit direction, and the line of each segment (M,), -1 = none.

    ``ends`` (M, 2, 2) [m], ``points`` (M,) echoes and ``region`` (M,) are those of the segments. Lines of fewer than
    ``min_support`` segments are left out.
    """
    order = np.lexsort((np.arange(len(ends)), -geometry.lengths(ends) * np.sqrt(points)))
    keys, members = _entries(ends, region)
    by_key = np.argsort(keys, kind="stable")
    cells, first = np.unique(keys[by_key], return_index=True)
    first = np.append(first, len(keys))
    limits = (settings.distance, settings.ratio, settings.gap, np.cos(settings.angle))
    return _grow_all(ends, region, order, cells, first, members[by_key], limits, settings.min_support)


@njit(cache=True, nogil=True)
def _key(region, turn, ix, iy):  # type: ignore[no-untyped-def]
    return ((region + 1) * _TURNS + turn % _TURNS) * (1 << 40) + (ix + (1 << 19)) * (1 << 20) + (iy + (1 << 19))


@njit(cache=True, nogil=True)
def _turn(ux, uy):  # type: ignore[no-untyped-def]
    return int(np.floor((np.arctan2(uy, ux) / (2 * np.pi) + 0.5) * _TURNS))


@njit(cache=True, nogil=True)
def _entries(ends, region):  # type: ignore[no-untyped-def]
    """The cells that each segment touches: keys and segments, one entry each."""
    total = 0
    for i in range(len(ends)):
        total += int(np.hypot(ends[i, 1, 0] - ends[i, 0, 0], ends[i, 1, 1] - ends[i, 0, 1]) / (0.5 * _CELL)) + 2
    keys, members = np.zeros(total, np.int64), np.zeros(total, np.int64)
    k = 0
    for i in range(len(ends)):
        dx, dy = ends[i, 1, 0] - ends[i, 0, 0], ends[i, 1, 1] - ends[i, 0, 1]
        steps = int(np.hypot(dx, dy) / (0.5 * _CELL)) + 1
        turn = _turn(dx, dy)
        last = -1
        for s in range(steps + 1):
            x, y = ends[i, 0, 0] + dx * s / steps, ends[i, 0, 1] + dy * s / steps
            key = _key(region[i], turn, int(np.floor(x / _CELL)), int(np.floor(y / _CELL)))
            if key != last:
                keys[k], members[k], last = key, i, key
                k += 1
    return keys[:k], members[:k]


@njit(cache=True, nogil=True)
def _grow_all(ends, region, order, cells, first, members, limits, min_support):  # type: ignore[no-untyped-def]
    n = len(ends)
    line_of, used = np.full(n, -1, np.int64), np.zeros(n, np.bool_)
    seen, group = np.zeros(n, np.int64), np.zeros(n, np.int64)
    frames = np.zeros((n, 4))
    count, stamp = 0, 0
    for seed in order:
        if used[seed]:
            continue
        size, stamp, frame = _grow(seed, ends, region, used, cells, first, members, limits, seen, group, stamp)
        for k in range(size):
            used[group[k]] = True
        if size < min_support:
            continue
        for k in range(size):
            line_of[group[k]] = count
        frames[count, 0], frames[count, 1], frames[count, 2], frames[count, 3] = frame
        count += 1
    return frames[:count].copy(), line_of


@njit(cache=True, nogil=True)
def _add_moments(m, e, px, py):  # type: ignore[no-untyped-def]
    """Add the length-weighted moments of one segment about p (paper, "Updating Lines")."""
    x1, y1, x2, y2 = e[0, 0] - px, e[0, 1] - py, e[1, 0] - px, e[1, 1] - py
    length = np.hypot(x2 - x1, y2 - y1)
    m[0] += 2 * length
    m[1] += length * (x1 + x2)
    m[2] += length * (y1 + y2)
    m[3] += length * (x1 * x1 + x2 * x2)
    m[4] += length * (y1 * y1 + y2 * y2)
    m[5] += length * (x1 * y1 + x2 * y2)


@njit(cache=True, nogil=True)
def _grow(seed, ends, region, used, cells, first, members, limits, seen, group, stamp):  # type: ignore[no-untyped-def]
    """All unused segments that are one line with the seed: their number (they stand in ``group``), the line (p, u)."""
    gap = limits[2]
    px, py = ends[seed, 0, 0], ends[seed, 0, 1]
    ux, uy = ends[seed, 1, 0] - px, ends[seed, 1, 1] - py
    length = np.hypot(ux, uy)
    ux, uy = ux / length, uy / length
    low, high = 0.0, length
    before = -1
    size = 0
    for _round in range(_MOST_ROUNDS):
        stamp += 1
        size, check = 0, 0
        m = np.zeros(6)
        turn = _turn(ux, uy)
        middle = 0.5 * (low + high)
        up, down = middle, middle  # how far along the line the cells have been looked at
        while True:
            if up < high + gap:
                t = up
                up += 0.5 * _CELL
            elif down > low - gap:
                down -= 0.5 * _CELL
                t = down
            else:
                break
            for side in (-1.0, 1.0):
                x, y = px + t * ux - side * limits[0] * uy, py + t * uy + side * limits[0] * ux
                for bin in (turn - 1, turn, turn + 1):
                    key = _key(region[seed], bin + _TURNS, int(np.floor(x / _CELL)), int(np.floor(y / _CELL)))
                    c = np.searchsorted(cells, key)
                    if c == len(cells) or cells[c] != key:
                        continue
                    for k in range(first[c], first[c + 1]):
                        i = members[k]
                        if used[i] or seen[i] == stamp:
                            continue
                        verdict, s, e = _joins(ends[i], px, py, ux, uy, low, high, limits)
                        if verdict == 0:
                            continue
                        seen[i] = stamp
                        if verdict == 2:
                            group[size] = i
                            size += 1
                            check += i
                            low, high = min(low, s), max(high, e)
                            _add_moments(m, ends[i], px, py)
        if size == 0:  # the fit has left its own seed: keep that alone
            group[0], size = seed, 1
            break
        if check == before:
            break
        before = check
        cx, cy, vx, vy, _ = line_through(m)
        if vx * ux + vy * uy < 0:
            vx, vy = -vx, -vy
        px, py, ux, uy = px + cx, py + cy, vx, vy
        low, high = np.inf, -np.inf
        for k in range(size):
            i = group[k]
            low = min(low, (ends[i, 0, 0] - px) * ux + (ends[i, 0, 1] - py) * uy)
            high = max(high, (ends[i, 1, 0] - px) * ux + (ends[i, 1, 1] - py) * uy)
    return size, stamp, (px, py, ux, uy)


@njit(cache=True, nogil=True)
def _joins(e, px, py, ux, uy, low, high, limits):  # type: ignore[no-untyped-def]
    """Does segment e join the line? 2 yes, 1 no, 0 not yet: the gap is too wide so far. And its span along it."""
    distance, ratio, gap, cos_angle = limits
    dx, dy = e[1, 0] - e[0, 0], e[1, 1] - e[0, 1]
    length = np.hypot(dx, dy)
    s, t = (e[0, 0] - px) * ux + (e[0, 1] - py) * uy, (e[1, 0] - px) * ux + (e[1, 1] - py) * uy
    if dx * ux + dy * uy < cos_angle * length:
        return 1, s, t
    off1, off2 = abs((e[0, 1] - py) * ux - (e[0, 0] - px) * uy), abs((e[1, 1] - py) * ux - (e[1, 0] - px) * uy)
    if max(off1, off2) > 1.5 * distance:
        return 1, s, t
    if s > high + gap or t < low - gap:
        return 0, s, t
    d, _ = measure(e[0, 0], e[0, 1], e[1, 0], e[1, 1], px + low * ux, py + low * uy, px + high * ux, py + high * uy)
    if d > distance or d > ratio * length:
        return 1, s, t
    return 2, s, t
