"""Straight pieces of the plane: arrays ``ends (..., 2, 2)`` of start and end [m]."""

from __future__ import annotations

import numpy as np

from rgcore.geometry import se2


def lengths(ends: np.ndarray) -> np.ndarray:
    """(...) [m]."""
    d = ends[..., 1, :] - ends[..., 0, :]
    return np.hypot(d[..., 0], d[..., 1])


def angles(ends: np.ndarray) -> np.ndarray:
    """(...) [rad] in (-pi, pi], direction start -> end."""
    d = ends[..., 1, :] - ends[..., 0, :]
    return np.arctan2(d[..., 1], d[..., 0])


def transformed(a_from_b: np.ndarray, ends_b: np.ndarray) -> np.ndarray:
    """``ends`` (M, 2, 2) of frame b in frame a; one pose (3,) or one a segment (M, 3)."""
    return se2.transform(np.asarray(a_from_b, float)[..., None, :], ends_b)


def distances(points: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """(...) [m] from points (..., 2) to the nearest point of segments (..., 2, 2); the two broadcast."""
    p, a = np.asarray(points, float), ends[..., 0, :]
    d = ends[..., 1, :] - a
    squared = (d**2).sum(-1)
    t = np.clip(((p - a) * d).sum(-1) / np.where(squared > 0, squared, 1.0), 0.0, 1.0)
    off = p - (a + t[..., None] * d)
    return np.hypot(off[..., 0], off[..., 1])
