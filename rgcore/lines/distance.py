"""The distance measure between two segments (paper, section IV-B, figures 4 and 5)."""

from __future__ import annotations

import numpy as np

from rgcore.geometry.compiled import inner, kernel


def line_distance(a: np.ndarray, b: np.ndarray) -> tuple[float, int]:
    """(d, o^l) of segments a = (P1, P2), b = (P3, P4), each (2, 2): distance [m]; 0 no, 1 simple, 2 complete overlap.

    As printed: d_1, d_2 are the perpendicular distances of a's ends from the line of b, d_3, d_4 those of b's ends
    from the line of a; ``res_1 = (d_1 + d_2) / 2`` and ``res_2 = (d_3 + d_4) / 2``; an end overlaps (o = 1) if its x
    lies *strictly* between the x of the other's ends. The measure is res_1 if a lies wholly over b, res_2 if b lies
    wholly over a, and else the smaller of the two.

    Printed with x alone, the overlap is empty for vertical lines. We read it as printed in the frame whose x axis is
    the axis, x or y, along which the two segments together extend farther (a rotation by 90 degrees where that is y).
    Where the segments share an end, so that just one of four ends overlaps (a case the paper rules out), its
    segment lies wholly over the other: complete overlap. Segments of the same extent overlap strictly
    nowhere: (d, 0), as printed; their gap is zero.
    """
    d, overlap = measure(a[0][0], a[0][1], a[1][0], a[1][1], b[0][0], b[0][1], b[1][0], b[1][1])
    return float(d), int(overlap)


def line_distances(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """:func:`line_distance` of pairs (N, 2, 2), (N, 2, 2): d (N,) [m] and overlap (N,)."""
    return _measure_pairs(np.ascontiguousarray(a, np.float64), np.ascontiguousarray(b, np.float64))


@kernel
def measure(x1, y1, x2, y2, x3, y3, x4, y4):  # type: ignore[no-untyped-def]
    """The measure on eight numbers; the one kernel behind everything above and the merging."""
    if max(y1, y2, y3, y4) - min(y1, y2, y3, y4) > max(x1, x2, x3, x4) - min(x1, x2, x3, x4):
        x1, y1, x2, y2, x3, y3, x4, y4 = y1, x1, y2, x2, y3, x3, y4, x4
    d1, d2 = _perpendicular(x1, y1, x3, y3, x4, y4), _perpendicular(x2, y2, x3, y3, x4, y4)
    d3, d4 = _perpendicular(x3, y3, x1, y1, x2, y2), _perpendicular(x4, y4, x1, y1, x2, y2)
    res1, res2 = (d1 + d2) / 2, (d3 + d4) / 2
    o1, o2, o3, o4 = _between(x1, x3, x4), _between(x2, x3, x4), _between(x3, x1, x2), _between(x4, x1, x2)
    total = o1 + o2 + o3 + o4
    if o1 + o2 == 2 or (total == 1 and o1 + o2 == 1):
        return res1, 2
    if o3 + o4 == 2 or (total == 1 and o3 + o4 == 1):
        return res2, 2
    return min(res1, res2), 1 if total == 2 else 0


@inner
def _perpendicular(x, y, xs, ys, xe, ye):  # type: ignore[no-untyped-def]
    dx, dy = xe - xs, ye - ys
    length = np.sqrt(dx * dx + dy * dy)
    if length == 0.0:
        return np.sqrt((x - xs) ** 2 + (y - ys) ** 2)
    return abs((x - xs) * dy - (y - ys) * dx) / length


@inner
def _between(x, xs, xe):  # type: ignore[no-untyped-def]
    return 1 if (x > xs and x < xe) or (x < xs and x > xe) else 0


@kernel
def _measure_pairs(a, b):  # type: ignore[no-untyped-def]
    d, overlap = np.zeros(len(a)), np.zeros(len(a), np.int64)
    for i in range(len(a)):
        d[i], overlap[i] = measure(
            a[i, 0, 0], a[i, 0, 1], a[i, 1, 0], a[i, 1, 1], b[i, 0, 0], b[i, 0, 1], b[i, 1, 0], b[i, 1, 1]
        )
    return d, overlap
