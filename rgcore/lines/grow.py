"""Growing lines from their strongest segment until nothing changes; the inner loop of the merging."""

from __future__ import annotations

import numpy as np

from rgcore.config import Lines as Settings
from rgcore.geometry import segments as geometry
from rgcore.geometry.compiled import inner, kernel
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


@inner
def _key(region, turn, ix, iy):  # type: ignore[no-untyped-def]
    return ((region + 1) * _TURNS + turn % _TURNS) * (1 << 40) + (ix + (1 << 19)) * (1 << 20) + (iy + (1 << 19))


@inner
def _turn(ux, uy):  # type: ignore[no-untyped-def]
    return int((np.arctan2(uy, ux) / (2 * np.pi) + 0.5) * _TURNS)


@kernel
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


@kernel
def _grow_all(ends, region, order, cells, first, members, limits, min_support):  # type: ignore[no-untyped-def]
    n = len(ends)
    line_of, used = np.full(n, -1, np.int64), np.zeros(n, np.bool_)
    seen, group = np.zeros(n, np.int64), np.zeros(n, np.int64)
    frames, m = np.zeros((n + 1, 4)), np.zeros(6)
    count, stamp = 0, 0
    for seed in order:
        if used[seed]:
            continue
        size, stamp = _grow(
            seed, ends, region, used, cells, first, members, limits, seen, group, stamp, frames, count, m
        )
        for k in range(size):
            used[group[k]] = True
        if size >= min_support:
            for k in range(size):
                line_of[group[k]] = count
            count += 1
    return frames[:count], line_of


@inner
def _add_moments(m, ends, i, px, py):  # type: ignore[no-untyped-def]
    """Add the length-weighted moments of one segment about p (paper, "Updating Lines")."""
    x1, y1, x2, y2 = ends[i, 0, 0] - px, ends[i, 0, 1] - py, ends[i, 1, 0] - px, ends[i, 1, 1] - py
    length = np.sqrt((x2 - x1) ** 2 + (y2 - y1) ** 2)
    m[0] += 2 * length
    m[1] += length * (x1 + x2)
    m[2] += length * (y1 + y2)
    m[3] += length * (x1 * x1 + x2 * x2)
    m[4] += length * (y1 * y1 + y2 * y2)
    m[5] += length * (x1 * y1 + x2 * y2)


@inner
def _grow(seed, ends, region, used, cells, first, members, limits, seen, group, stamp, frames, g, m):  # type: ignore[no-untyped-def]
    """Collect in ``group`` all unused segments that are one line with the seed (in ``frames[g]``); their number."""
    frames[g, 0], frames[g, 1] = ends[seed, 0, 0], ends[seed, 0, 1]
    ux, uy = ends[seed, 1, 0] - ends[seed, 0, 0], ends[seed, 1, 1] - ends[seed, 0, 1]
    high = np.sqrt(ux * ux + uy * uy)
    frames[g, 2], frames[g, 3] = ux / high, uy / high
    low, before, size = 0.0, -1, 0
    for _ in range(_MOST_ROUNDS):
        stamp += 1
        size = _collect(
            region[seed], ends, used, cells, first, members, limits, seen, group, stamp, frames, g, low, high, m
        )
        if size == 0:  # the fit has left its own seed: that stays alone
            group[0] = seed
            return 1, stamp
        check = 0
        for k in range(size):
            check += group[k]
        if check == before:
            break
        before = check
        low, high = _refit(ends, group, size, frames, g, m)
    return size, stamp


@inner
def _refit(ends, group, size, frames, g, m):  # type: ignore[no-untyped-def]
    """The line through the moments ``m`` of the group (about the old point), and how far the group reaches along it."""
    cx, cy, ux, uy, _ = line_through(m)
    if ux * frames[g, 2] + uy * frames[g, 3] < 0:
        ux, uy = -ux, -uy
    px, py = frames[g, 0] + cx, frames[g, 1] + cy
    frames[g, 0], frames[g, 1], frames[g, 2], frames[g, 3] = px, py, ux, uy
    low, high = np.inf, -np.inf
    for k in range(size):
        i = group[k]
        low = min(low, (ends[i, 0, 0] - px) * ux + (ends[i, 0, 1] - py) * uy)
        high = max(high, (ends[i, 1, 0] - px) * ux + (ends[i, 1, 1] - py) * uy)
    return low, high


@inner
def _collect(region, ends, used, cells, first, members, limits, seen, group, stamp, frames, g, low, high, m):  # type: ignore[no-untyped-def]
    """Walk the cells along the line outward from its middle, as far as the segments that join carry it."""
    px, py, ux, uy = frames[g, 0], frames[g, 1], frames[g, 2], frames[g, 3]
    for c in range(6):
        m[c] = 0.0
    size, turn = 0, _turn(ux, uy)
    up = down = 0.5 * (low + high)  # the cells between have been looked at
    while True:
        if up < high + limits[2]:
            t = up
            up += 0.5 * _CELL
        elif down > low - limits[2]:
            down -= 0.5 * _CELL
            t = down
        else:
            return size
        for look in range(6):  # three bins of direction on each side of the line
            aside = limits[0] if look < 3 else -limits[0]
            x, y = px + t * ux - aside * uy, py + t * uy + aside * ux
            key = _key(region, turn + look % 3 - 1 + _TURNS, int(np.floor(x / _CELL)), int(np.floor(y / _CELL)))
            c = _find(cells, key)
            if c < 0:
                continue
            for k in range(first[c], first[c + 1]):
                i = members[k]
                if used[i] or seen[i] == stamp:
                    continue
                verdict, s, e = _joins(ends, i, px, py, ux, uy, low, high, limits)
                if verdict == 0:
                    continue
                seen[i] = stamp
                if verdict == 2:
                    group[size] = i
                    size += 1
                    low, high = min(low, s), max(high, e)
                    _add_moments(m, ends, i, px, py)


@inner
def _find(cells, key):  # type: ignore[no-untyped-def]
    """Index of a key in the sorted cells, or -1."""
    low, high = 0, len(cells)
    while low < high:
        middle = (low + high) // 2
        if cells[middle] < key:
            low = middle + 1
        else:
            high = middle
    return low if low < len(cells) and cells[low] == key else -1


@inner
def _joins(ends, i, px, py, ux, uy, low, high, limits):  # type: ignore[no-untyped-def]
    """Does segment i join the line? 2 yes, 1 no, 0 not yet: the gap is too wide so far. And its span along it."""
    x1, y1, x2, y2 = ends[i, 0, 0], ends[i, 0, 1], ends[i, 1, 0], ends[i, 1, 1]
    dx, dy = x2 - x1, y2 - y1
    length = np.sqrt(dx * dx + dy * dy)
    s, t = (x1 - px) * ux + (y1 - py) * uy, (x2 - px) * ux + (y2 - py) * uy
    if dx * ux + dy * uy < limits[3] * length:
        return 1, s, t
    off1, off2 = abs((y1 - py) * ux - (x1 - px) * uy), abs((y2 - py) * ux - (x2 - px) * uy)
    if max(off1, off2) > 1.5 * limits[0]:  # so that no line drifts, however far its segments carry it
        return 1, s, t
    if s > high + limits[2] or t < low - limits[2]:
        return 0, s, t
    d, _ = measure(x1, y1, x2, y2, px + low * ux, py + low * uy, px + high * ux, py + high * uy)
    if d > limits[0] or d > limits[1] * length:
        return 1, s, t
    return 2, s, t
