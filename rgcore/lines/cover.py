"""How far a line reaches: along it, where segments cover it and beams stop; across it, where nothing hides it."""

from __future__ import annotations

import numpy as np
from numba import njit

from rgcore.config import Lines as Settings
from rgcore.geometry import segments as geometry
from rgcore.lines.passes import count_passes

_BIN = 0.025  # m, of the coverage along a line
_WINDOW = 60  # bins (1.5 m) on each side that a bin's coverage is compared with
_GAP_SHARE = 0.08  # of the coverage left and right: less is a gap that a few far segments bridged
_END_SHARE = 0.03  # the same at the ends, where the wall may just be seen less
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
    passes = count_passes(lines, first, _BIN, segments, eyes, points, 2.0 * settings.distance)
    return _runs(
        first, low, line_of[own], spans, points[own].astype(np.float64), passes, settings.gap, settings.min_support
    )


def spans_of(frames: np.ndarray, segments: np.ndarray) -> np.ndarray:
    """(N, 2) [m]: where the ends of segments (N, 2, 2) lie along their lines (N, 4)."""
    return np.einsum("nek,nk->ne", segments - frames[:, None, :2], frames[:, 2:])


@njit(cache=True, nogil=True)
def _runs(first, low, line_of, spans, points, passes, gap, min_support):  # type: ignore[no-untyped-def]
    hits, number = np.zeros(first[-1]), np.zeros(first[-1])
    for k in range(len(spans)):
        g = line_of[k]
        i = first[g] + int((spans[k, 0] - low[g]) / _BIN + 0.5)
        j = max(i + 1, first[g] + int((spans[k, 1] - low[g]) / _BIN + 0.5))
        hits[i] += points[k] / (j - i)
        number[i] += 1
        if j < first[g + 1]:
            hits[j] -= points[k] / (j - i)
            number[j] -= 1
    runs, of = np.zeros((first[-1], 2)), np.zeros(first[-1], np.int64)
    n = 0
    limit = int(gap / _BIN) + 1
    for g in range(len(low)):
        h = np.cumsum(hits[first[g] : first[g + 1]])
        c = np.cumsum(number[first[g] : first[g + 1]])
        p = passes[first[g] : first[g + 1]]
        last = -limit - 1
        for b in range(len(h)):
            left, right = h[max(0, b - _WINDOW) : b + 1].max(), h[b : b + _WINDOW + 1].max()
            if c[b] < min_support or h[b] < max(_GAP_SHARE * min(left, right), _END_SHARE * max(left, right)):
                continue
            near = slice(max(0, b - _SMOOTH), b + _SMOOTH + 1)
            if p[near].sum() > h[near].sum():
                continue
            if b - last > limit:
                runs[n, 0], of[n] = low[g] + b * _BIN, g
                n += 1
            runs[n - 1, 1] = low[g] + (b + 1) * _BIN
            last = b
    return runs[:n].copy(), of[:n].copy()


def unhidden(lines: np.ndarray, region: np.ndarray, support: np.ndarray, settings: Settings) -> np.ndarray:
    """(L,) mask of the lines that stay: not those that a stronger line of the same side and region hides.

    Two faces close behind one another cannot both be seen from the same side; the weaker one is noise (a bad pose, a
    door leaf, a grazing beam).
    """
    strength = geometry.lengths(lines) * support
    order = np.lexsort((np.arange(len(lines)), -strength))
    return _unhidden(lines, region, strength, order, 2.0 * settings.distance)


@njit(cache=True, nogil=True)
def _unhidden(lines, region, strength, order, near):  # type: ignore[no-untyped-def]
    keep = np.ones(len(lines), np.bool_)
    for a in range(len(order)):
        weak = order[a]
        wx, wy = lines[weak, 1, 0] - lines[weak, 0, 0], lines[weak, 1, 1] - lines[weak, 0, 1]
        length = np.hypot(wx, wy)
        hidden = 0.0
        for b in range(a):
            strong = order[b]
            if not keep[strong] or region[strong] != region[weak] or strength[strong] < 2.0 * strength[weak]:
                continue
            px, py = lines[strong, 0, 0], lines[strong, 0, 1]
            ux, uy = lines[strong, 1, 0] - px, lines[strong, 1, 1] - py
            reach = np.hypot(ux, uy)
            ux, uy = ux / reach, uy / reach
            if wx * ux + wy * uy < 0.9 * length:
                continue
            x1, y1 = lines[weak, 0, 0] - px, lines[weak, 0, 1] - py
            x2, y2 = lines[weak, 1, 0] - px, lines[weak, 1, 1] - py
            if max(abs(y1 * ux - x1 * uy), abs(y2 * ux - x2 * uy)) > near:
                continue
            hidden += max(0.0, min(reach, x2 * ux + y2 * uy) - max(0.0, x1 * ux + y1 * uy))
        keep[weak] = hidden < 0.5 * length
    return keep
