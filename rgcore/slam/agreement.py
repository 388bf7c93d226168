"""Do two scans tell of the same place? What one saw as a surface the other must not have seen through."""

from __future__ import annotations

import numpy as np
from numba import njit


def agreement(
    points: np.ndarray, ranges: np.ndarray, bearings: np.ndarray, pose: np.ndarray, tolerance: float
) -> np.ndarray:
    """(3,) how many of a scan's surface points another scan confirms, contradicts (it saw through them) and sees before (they
    are hidden); points out of its view count as none.

    ``points`` (n, 2) in the first scan's frame; ``ranges`` (B,) and ``bearings`` (B,) of the other; ``pose`` (3,) of the
    first in the frame of the other; ``tolerance`` [m].
    """
    return _agreement(points, np.ascontiguousarray(ranges, float), bearings, pose, tolerance)


@njit(cache=True, nogil=True)
def _agreement(points, ranges, bearings, pose, tolerance):  # type: ignore[no-untyped-def]
    counts = np.zeros(3)
    c, s = np.cos(pose[2]), np.sin(pose[2])
    step = (bearings[-1] - bearings[0]) / max(1, len(bearings) - 1)
    for i in range(len(points)):
        x, y = c * points[i, 0] - s * points[i, 1] + pose[0], s * points[i, 0] + c * points[i, 1] + pose[1]
        turn = (np.arctan2(y, x) - bearings[0] + np.pi) % (2.0 * np.pi) - np.pi
        beam = int(np.round((turn + (2.0 * np.pi if turn < -0.5 * abs(step) else 0.0)) / step))
        if beam < 0 or beam >= len(ranges):
            continue
        low, high = np.inf, -np.inf
        for k in range(max(0, beam - 1), min(len(ranges), beam + 2)):
            if not np.isnan(ranges[k]):
                low, high = min(low, ranges[k]), max(high, ranges[k])
        if high < 0.0:
            continue
        r, off = np.hypot(x, y), tolerance + 0.02 * np.hypot(x, y)
        if r < low - off:
            counts[1] += 1
        elif r <= high + off:
            counts[0] += 1
        else:
            counts[2] += 1
    return counts
