"""Do scans tell of the same place? What one saw as a surface the other must not have seen through."""

from __future__ import annotations

import numpy as np

from rgcore.geometry.compiled import inner, kernel

SEEN_THROUGH = 0.25
"""A surface this much [m] nearer than the reading through it contradicts it; and 2 % of the range, for the beam's
width.
"""


@kernel
def agreement(surfaces, ranges, bearings, poses, members, points, readings, pose):  # type: ignore[no-untyped-def]
    """(3,) how many surface points the other side confirms, contradicts (saw through) and cannot see (hidden).

    One side is a scan with surface ``points`` (n, 2) and ``readings`` (B,) at ``pose`` (3,), the other are the
    keyframes ``members`` (m,) of ``surfaces`` and ``ranges`` (K, B) at ``poses`` (K, 3). Points out of view do not
    count.
    """
    counts = np.zeros(3)
    for k in members:
        seen = surfaces.points[surfaces.start[k] : surfaces.start[k + 1]]
        _count(points, pose, ranges[k], poses[k], bearings, counts)
        _count(seen, poses[k], readings, pose, bearings, counts)
    return counts


@inner
def _count(points, pose, readings, other, bearings, counts):  # type: ignore[no-untyped-def]
    """Looks from ``other`` at the points of a scan at ``pose``."""
    co, so, turn = np.cos(other[2]), np.sin(other[2]), pose[2] - other[2]
    c, s = np.cos(turn), np.sin(turn)
    dx, dy = pose[0] - other[0], pose[1] - other[1]
    tx, ty = co * dx + so * dy, -so * dx + co * dy
    step = (bearings[-1] - bearings[0]) / max(1, len(bearings) - 1)
    if step == 0.0:
        return
    for i in range(len(points)):
        x, y = c * points[i, 0] - s * points[i, 1] + tx, s * points[i, 0] + c * points[i, 1] + ty
        bearing = (np.arctan2(y, x) - bearings[0]) / step
        around = 2.0 * np.pi / abs(step)
        beam = int(np.floor((bearing + 0.5) % around))
        if beam >= len(readings):
            continue
        low, high = np.inf, -np.inf
        for k in range(max(0, beam - 1), min(len(readings), beam + 2)):
            if readings[k] > 0.0:  # neither nan
                low, high = min(low, readings[k]), max(high, readings[k])
        r = np.hypot(x, y)
        off = SEEN_THROUGH + 0.02 * r
        if high < 0.0:
            continue
        if r < low - off:
            counts[1] += 1.0
        elif r <= high + off:
            counts[0] += 1.0
        else:
            counts[2] += 1.0
