"""What a laser would measure: ranges from poses to line segments."""

from __future__ import annotations

import numpy as np

from rgcore.geometry.compiled import kernel


def cast(
    segments: np.ndarray, poses: np.ndarray, bearings: np.ndarray, max_range: float
) -> tuple[np.ndarray, np.ndarray]:
    """Exact ranges of beams to the nearest segment.

    ``segments`` (S, 2, 2) and ``poses`` (N, 3) in one frame, ``bearings`` (B,) ascending within one turn [rad].
    Returns ranges (N, B) [m], ``inf`` where nothing lies within ``max_range``, and the segment hit (N, B), -1 for none.
    """
    shape = (len(poses), len(bearings))
    ranges, hit = np.full(shape, np.inf), np.full(shape, -1, np.int64)
    _cast(
        np.ascontiguousarray(segments, float).reshape(-1, 4),
        np.ascontiguousarray(poses, float),
        np.ascontiguousarray(bearings, float),
        float(max_range),
        ranges,
        hit,
    )
    return ranges, hit


@kernel
def _cast(
    segments: np.ndarray, poses: np.ndarray, bearings: np.ndarray, max_range: float, ranges: np.ndarray, hit: np.ndarray
) -> None:
    """A segment concerns only the beams between its ends: those are found by bisection, the others never looked at."""
    cos, sin, turn = np.cos(bearings), np.sin(bearings), 2 * np.pi
    for n in range(len(poses)):
        x, y = poses[n, 0], poses[n, 1]
        c, s = np.cos(poses[n, 2]), np.sin(poses[n, 2])
        for k in range(len(segments)):
            dx, dy = segments[k, 0] - x, segments[k, 1] - y
            ax, ay = c * dx + s * dy, c * dy - s * dx
            dx, dy = segments[k, 2] - x, segments[k, 3] - y
            bx, by = c * dx + s * dy, c * dy - s * dx
            area = ax * by - ay * bx
            if area < 0.0:
                ax, ay, bx, by, area = bx, by, ax, ay, -area
            ex, ey = bx - ax, by - ay
            length = np.sqrt(ex * ex + ey * ey)
            if area > max_range * length or area <= 1e-9 * length:  # too far, or seen edge on
                continue
            first = np.arctan2(ay, ax)
            last = np.arctan2(by, bx)
            if last < first:
                last += turn
            for shift in (-turn, 0.0, turn):
                i = np.searchsorted(bearings, first + shift - 1e-12)
                while i < len(bearings) and bearings[i] <= last + shift + 1e-12:
                    down = cos[i] * ey - sin[i] * ex
                    if down > 0.0:
                        r = area / down
                        if r <= max_range and r < ranges[n, i]:
                            ranges[n, i] = r
                            hit[n, i] = k
                    i += 1
