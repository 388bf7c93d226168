"""What a laser would measure: ranges from poses to line segments."""

from __future__ import annotations

import numpy as np

from rgcore.geometry.compiled import inner, kernel


def cast(
    segments: np.ndarray, poses: np.ndarray, bearings: np.ndarray, max_range: float
) -> tuple[np.ndarray, np.ndarray]:
    """Exact ranges of beams to the nearest segment.

    ``segments`` (S, 2, 2) and ``poses`` (N, 3) in one frame, ``bearings`` (B,) ascending within one turn [rad].
    Returns ranges (N, B) [m], ``inf`` where nothing lies within ``max_range``, and the segment hit (N, B), -1 for none.
    """
    shape = (len(poses), len(bearings))
    ranges, hit = np.full(shape, np.inf), np.full(shape, -1, np.int64)
    if len(bearings) == 0:
        return ranges, hit
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
        for k in range(len(segments)):
            first, last, ex, ey, area = facing(
                segments[k, 0], segments[k, 1], segments[k, 2], segments[k, 3], poses[n], max_range
            )
            if area <= 0.0:
                continue
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


@inner
def facing(x1, y1, x2, y2, pose, max_range):  # type: ignore[no-untyped-def]
    """A segment as a laser at ``pose`` sees it: the bearings of its ends, its direction from the first to the last, and
    twice the area of the triangle that it spans, 0 where it is too far or seen edge on.

    A beam of bearing b between the two meets it at the range area / (cos(b) ey - sin(b) ex).
    """
    c, s = np.cos(pose[2]), np.sin(pose[2])
    dx, dy = x1 - pose[0], y1 - pose[1]
    ax, ay = c * dx + s * dy, c * dy - s * dx
    dx, dy = x2 - pose[0], y2 - pose[1]
    bx, by = c * dx + s * dy, c * dy - s * dx
    area = ax * by - ay * bx
    if area < 0.0:
        ax, ay, bx, by, area = bx, by, ax, ay, -area
    ex, ey = bx - ax, by - ay
    length = np.sqrt(ex * ex + ey * ey)
    if area > max_range * length or area <= 1e-9 * length:
        return 0.0, 0.0, ex, ey, 0.0
    first, last = np.arctan2(ay, ax), np.arctan2(by, bx)
    return first, last + 2 * np.pi if last < first else last, ex, ey, area
