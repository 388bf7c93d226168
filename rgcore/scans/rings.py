"""Rings of a floor plan: closed polylines (K, 2) of points, the first not repeated."""

from __future__ import annotations

import numpy as np


def box_corners(center: tuple[float, float], size: tuple[float, float], yaw: float) -> np.ndarray:
    """(4, 2) corners of a rectangle, counter-clockwise."""
    c, s = np.cos(yaw), np.sin(yaw)
    half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.asarray(size) / 2
    return np.asarray(center) + half @ np.array([[c, s], [-s, c]])


def inside(rings: tuple[np.ndarray, ...], points: np.ndarray) -> np.ndarray:
    """(N,) whether points (N, 2) lie inside a polygon with holes (even-odd rule)."""
    odd = np.zeros(len(points), bool)
    x, y = points[:, 0], points[:, 1]
    for ring in rings:
        for (ax, ay), (bx, by) in edges(ring):
            between = (ay <= y) != (by <= y)
            with np.errstate(divide="ignore", invalid="ignore"):
                odd ^= between & (x < ax + (y - ay) / (by - ay) * (bx - ax))
    return odd


def edges(ring: np.ndarray) -> np.ndarray:
    return np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)


def area(ring: np.ndarray) -> float:
    """Signed: positive for a counter-clockwise ring."""
    x, y = ring.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def oriented(points: tuple[tuple[float, float], ...], ccw: bool) -> np.ndarray:
    ring = np.array(points, float)
    return ring if (area(ring) > 0) == ccw else ring[::-1]


def _directions(ring: np.ndarray) -> np.ndarray:
    step = np.roll(ring, -1, axis=0) - ring
    return step / np.linalg.norm(step, axis=1, keepdims=True)


def inset(ring: np.ndarray, distance: float) -> np.ndarray:
    """The ring moved to its left, with mitred corners: vertex k stays the start of edge k."""
    d = _directions(ring)
    n = np.stack([-d[:, 1], d[:, 0]], 1)
    before = np.roll(n, 1, axis=0)
    return ring + distance * (n + before) / (1 + (n * before).sum(1, keepdims=True))


def tangled(ring: np.ndarray) -> bool:
    """Whether a ring has an empty edge, a spike, or edges that cross."""
    if (np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1) < 1e-6).any():
        return True
    d = _directions(ring)
    if ((d * np.roll(d, 1, axis=0)).sum(1) < -0.999).any():
        return True
    e = edges(ring)
    a, b, c, dd = e[:, None, 0], e[:, None, 1], e[None, :, 0], e[None, :, 1]

    def side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])

    cross = (side(a, b, c) * side(a, b, dd) < -1e-12) & (side(c, dd, a) * side(c, dd, b) < -1e-12)
    return bool(cross.any())
