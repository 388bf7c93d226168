"""A box fitted to lines: the smallest rectangle over them, aligned with a wall."""

from __future__ import annotations

import math

import numpy as np

from rgcore.model.records import Point, rounded

THINNEST = 0.05
"""m: a box over a single line still has two sides"""
SNAP = math.radians(5)
"""rad: nearer than this to a main axis of the region, the box stands along it"""


def fit_box(ends: np.ndarray, axes: tuple[float, ...] = ()) -> tuple[Point, tuple[float, float], float]:
    """Smallest rectangle over lines ``ends`` (K, 2, 2) [m] among those along one of them: centre, size, yaw.

    ``axes`` [rad]: main axes of the region; a box within 5 degrees of one (or across it) stands along it. The size is
    along and across ``yaw``, the longer first; yaw in (-pi/2, pi/2]; rounded to micrometres.
    """
    ends = np.asarray(ends, float)
    d = ends[:, 1] - ends[:, 0]
    order = np.argsort(-np.hypot(d[:, 0], d[:, 1]), kind="stable")
    yaws = np.arctan2(d[order, 1], d[order, 0])
    spans = [_span(ends, yaw) for yaw in yaws]
    best = int(np.argmin([(high - low).prod() for low, high in spans]))
    yaw = _snapped(float(yaws[best]), axes)
    low, high = _span(ends, yaw)
    along, across = np.maximum(high - low, THINNEST)
    u, v = (low + high) / 2
    x, y = u * math.cos(yaw) - v * math.sin(yaw), u * math.sin(yaw) + v * math.cos(yaw)
    if across > along:
        along, across, yaw = across, along, yaw + math.pi / 2
    yaw = -((-yaw + math.pi / 2) % math.pi - math.pi / 2)
    return (rounded(x), rounded(y)), (rounded(along), rounded(across)), rounded(yaw)


def _span(ends: np.ndarray, yaw: float) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates (2,) along and across ``yaw``."""
    c, s = math.cos(yaw), math.sin(yaw)
    q = ends.reshape(-1, 2) @ np.array([[c, -s], [s, c]])
    return q.min(0), q.max(0)


def _snapped(yaw: float, axes: tuple[float, ...]) -> float:
    """``yaw``, or the direction along or across a main axis that lies within ``SNAP`` of it."""
    for axis in axes:
        off = math.remainder(yaw - axis, math.pi / 2)
        if abs(off) <= SNAP:
            return yaw - off
    return yaw
