"""How far a line reaches: along it, where segments cover it and beams stop; across it, where nothing hides it."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from rgcore.config import Lines as Settings
from rgcore.geometry import segments as geometry
from rgcore.geometry.compiled import inner, kernel
from rgcore.lines.passes import count_passes

_BIN = 0.025  # m, of the coverage along a line
_WINDOW = 60  # bins (1.5 m) on each side that a bin's coverage is compared with
_GAP_SHARE = 0.08  # of the coverage left and right: less is a gap that a few far segments bridged
_END_SHARE = 0.03  # the same at the ends, where the wall may just be seen less
_ALIKE = np.cos(np.deg2rad(30.0))  # directions that may belong to one wall
_FAR_STRONGER = 10.0  # such a wall also hides what a few bad poses saw well behind it
_PIECE = 1.0  # m: so finely lines are cut to find those near them
_LEAST = 1e-3  # echoes a bin: more than what rounding leaves
_SMOOTH = 2  # bins on each side over which hits and passes are compared


def covered_runs(
    frames: np.ndarray,
    line_of: np.ndarray,
    segments: np.ndarray,
    points: np.ndarray,
    eyes: np.ndarray,
    settings: Settings,
) -> tuple[np.ndarray, np.ndarray]:
    """Stretches (K, 2) [m] of the lines ``frames`` (G, 4) that are there, and the line of each (K,).

    A stretch is there where its segments cover it and where no more beams pass than end. Coverage counts echoes a
    metre: a far segment may bridge a door between two of its echoes, near ones do not, so a bin with far fewer echoes
    than its surroundings is not covered. Stretches with no more than gamma between them are one.
    """
    own = np.flatnonzero(line_of >= 0)
    spans = spans_of(frames[line_of[own]], segments[own])
    low = np.full(len(frames), np.inf)
    high = np.full(len(frames), -np.inf)
    np.minimum.at(low, line_of[own], spans[:, 0])
    np.maximum.at(high, line_of[own], spans[:, 1])
    bins = np.ceil((high - low) / _BIN).astype(np.int64) + 1
    first = np.concatenate([[0], np.cumsum(bins)])
    lines = frames[:, None, :2] + np.stack([low, low + bins * _BIN], 1)[..., None] * frames[:, None, 2:]
    passes = count_passes(lines, first, _BIN, segments, eyes, points, 1.5 * settings.distance)
    return _runs(first, low, line_of[own], spans, points[own].astype(np.float64), passes, settings.gap)


def spans_of(frames: np.ndarray, segments: np.ndarray) -> np.ndarray:
    """(N, 2) [m]: where the ends of segments (N, 2, 2) lie along their lines (N, 4)."""
    return np.einsum("nek,nk->ne", segments - frames[:, None, :2], frames[:, 2:])


@kernel
def _runs(first, low, line_of, spans, points, passes, gap):  # type: ignore[no-untyped-def]
    hits = np.zeros(first[-1] + 1)
    for k in range(len(spans)):  # steps up and down, then their running sum
        g = line_of[k]
        i = first[g] + int((spans[k, 0] - low[g]) / _BIN + 0.5)
        j = max(i + 1, first[g] + int((spans[k, 1] - low[g]) / _BIN + 0.5))
        hits[i] += points[k] / (j - i)
        hits[j] -= points[k] / (j - i)
    for b in range(1, len(hits)):
        hits[b] += hits[b - 1]
    runs, of = np.zeros((first[-1], 2)), np.zeros(first[-1], np.int64)
    n = 0
    for g in range(len(low)):
        start, stop = first[g], first[g + 1]
        last = start - int(gap / _BIN) - 2
        for b in range(start, stop):
            left, right = _most(hits, max(start, b - _WINDOW), b + 1), _most(hits, b, min(stop, b + _WINDOW + 1))
            if hits[b] < max(_LEAST, _GAP_SHARE * min(left, right), _END_SHARE * max(left, right)):
                continue
            through = 0.0
            for q in range(max(start, b - _SMOOTH), min(stop, b + _SMOOTH + 1)):
                through += passes[q] - hits[q]
            if through > 0:
                continue
            if b - last > int(gap / _BIN) + 1:
                runs[n, 0], of[n] = low[g] + (b - start) * _BIN, g
                n += 1
            runs[n - 1, 1] = low[g] + (b + 1 - start) * _BIN
            last = b
    return runs[:n], of[:n]


@inner
def _most(values, start, stop):  # type: ignore[no-untyped-def]
    most = 0.0
    for k in range(start, stop):
        most = max(most, values[k])
    return most


def unhidden(lines: np.ndarray, support: np.ndarray, settings: Settings) -> np.ndarray:
    """Lines (L, 2, 2) cut back to where no stronger line of the same side hides them; some to length 0.

    Two faces close behind one another cannot both be seen from the same side: the weaker one is noise (a bad pose, a
    door leaf, a grazing beam), or the next chord of a curved wall, which then begins where the other ends. That holds
    across regions too: a wall that runs on from one to the next is in each only once.
    """
    strength = geometry.lengths(lines) * support
    order = np.lexsort((np.arange(len(lines)), -strength))
    near = 2.0 * settings.distance
    first, members = _pairs(lines, order, 2.0 * near)
    return _unhidden(lines, strength, order, near, first, members)


def _pairs(lines: np.ndarray, order: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Which stronger lines come near each: those of the k-th of ``order`` are ``members[first[k]:first[k + 1]]``.

    Both are places in ``order``. Pieces of lines, each in a circle, are looked up in a tree: near linear.
    """
    length = geometry.lengths(lines)[order]
    count = np.maximum(1, np.ceil(length / _PIECE)).astype(np.int64)
    of = np.repeat(np.arange(len(lines)), count)
    share = (np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[of]
    middle = lines[order[of], 0] + share[:, None] * (lines[order[of], 1] - lines[order[of], 0])
    pairs = of[cKDTree(middle).query_pairs(_PIECE + reach, output_type="ndarray")]
    weak, strong = np.divmod(np.unique(pairs.max(1) * len(lines) + pairs.min(1)), max(len(lines), 1))
    weak, strong = weak[weak != strong], strong[weak != strong]
    return np.searchsorted(weak, np.arange(len(lines) + 1)), strong


@kernel
def _unhidden(lines, strength, order, near, first, members):  # type: ignore[no-untyped-def]
    out = lines.copy()
    for a in range(len(order)):
        weak = order[a]
        wx, wy = lines[weak, 1, 0] - lines[weak, 0, 0], lines[weak, 1, 1] - lines[weak, 0, 1]
        length = np.hypot(wx, wy)
        wx, wy = wx / length, wy / length
        start, end = 0.0, length
        for p in range(first[a], first[a + 1]):
            strong = order[members[p]]
            px, py = out[strong, 0, 0], out[strong, 0, 1]
            ux, uy = out[strong, 1, 0] - px, out[strong, 1, 1] - py
            reach = np.hypot(ux, uy)
            if reach == 0.0 or wx * ux + wy * uy < _ALIKE * reach:
                continue
            ux, uy = ux / reach, uy / reach
            behind = 2.0 * near if strength[strong] > _FAR_STRONGER * strength[weak] else near
            x, y = lines[weak, 0, 0] - px, lines[weak, 0, 1] - py
            low, high = _between(x * ux + y * uy, wx * ux + wy * uy, 0.0, reach)
            near_low, near_high = _between(y * ux - x * uy, wy * ux - wx * uy, -behind, near)
            low, high = max(start, low, near_low), min(end, high, near_high)
            if low >= high:
                continue
            if low - start >= end - high:  # the longer rest stays
                end = low
            else:
                start = high
        for k in range(2):
            t = end if k else start
            out[weak, k, 0], out[weak, k, 1] = lines[weak, 0, 0] + t * wx, lines[weak, 0, 1] + t * wy
    return out


@inner
def _between(value, slope, low, high):  # type: ignore[no-untyped-def]
    """The t for which value + slope t lies between low and high."""
    if abs(slope) < 1e-12:
        return (-np.inf, np.inf) if low <= value <= high else (np.inf, -np.inf)
    one, other = (low - value) / slope, (high - value) / slope
    return min(one, other), max(one, other)
