"""How far a line reaches: along it, where segments cover it; across it, where nothing hides it."""

from __future__ import annotations

import numpy as np
from numba import njit

from rgcore.config import Lines as Settings
from rgcore.geometry import segments as geometry

_BIN = 0.025  # m, of the coverage along a line
_WINDOW = 60  # bins (1.5 m) on each side that a bin's coverage is compared with
_GAP_SHARE = 0.08  # of the coverage left and right: less is a gap that a few far segments bridged
_END_SHARE = 0.03  # the same at the ends, where the wall may just be seen less


@njit(cache=True, nogil=True)
def covered_runs(spans, points, gap, min_support):  # type: ignore[no-untyped-def]
    """Stretches (K, 2) of a line that its segments cover.

    ``spans`` (N, 2) are the segments' extents along it and ``points`` (N,) their echoes. A far segment has few echoes
    a metre and may bridge a door between two of them; near ones do not. So coverage counts echoes a metre, and a bin
    that has far fewer than its surroundings is not covered. Stretches with no more than ``gap`` between them are one.
    """
    low = spans.min()
    bins = int((spans.max() - low) / _BIN) + 2
    density, number = np.zeros(bins), np.zeros(bins)
    for k in range(len(spans)):
        i, j = int((spans[k, 0] - low) / _BIN + 0.5), int((spans[k, 1] - low) / _BIN + 0.5)
        j = max(j, i + 1)
        density[i] += points[k] / (j - i)
        density[j] -= points[k] / (j - i)
        number[i] += 1
        number[j] -= 1
    density, number = np.cumsum(density), np.cumsum(number)
    needed = min(min_support, len(spans))
    runs = np.zeros((bins, 2))
    n, last = 0, -1
    limit = int(gap / _BIN)
    for b in range(bins):
        left = density[max(0, b - _WINDOW) : b + 1].max()
        right = density[b : b + _WINDOW + 1].max()
        if number[b] < needed or density[b] < max(_GAP_SHARE * min(left, right), _END_SHARE * max(left, right)):
            continue
        if last < 0 or b - last > limit + 1:
            runs[n, 0] = low + b * _BIN
            n += 1
        runs[n - 1, 1] = low + (b + 1) * _BIN
        last = b
    return runs[:n]


def drop_hidden(lines: np.ndarray, region: np.ndarray, support: np.ndarray, settings: Settings) -> np.ndarray:
    """(L,) mask of the lines that stay: not those that a stronger line of the same side and region hides.

    Two faces close behind one another cannot both be seen from the same side; the weaker one is noise (a bad pose, a
    door leaf, a grazing beam).
    """
    length = geometry.lengths(lines)
    order = np.lexsort((np.arange(len(lines)), -length * support))
    return _unhidden(lines, region, length * support, order, 2.0 * settings.distance)


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
            x1, y1, x2, y2 = (
                lines[weak, 0, 0] - px,
                lines[weak, 0, 1] - py,
                lines[weak, 1, 0] - px,
                lines[weak, 1, 1] - py,
            )
            if max(abs(y1 * ux - x1 * uy), abs(y2 * ux - x2 * uy)) > near:
                continue
            hidden += max(0.0, min(reach, x2 * ux + y2 * uy) - max(0.0, x1 * ux + y1 * uy))
        keep[weak] = hidden < 0.5 * length
    return keep
