"""Planar poses: arrays (..., 3) of x [m], y [m], theta [rad], theta in (-pi, pi].

A pose ``a_from_b`` maps coordinates in frame b to frame a; names chain: ``a_from_c = compose(a_from_b, b_from_c)``.
"""

from __future__ import annotations

import numpy as np


def wrap(angle: np.ndarray | float) -> np.ndarray:
    """Angle(s) [rad] wrapped to (-pi, pi]."""
    return -((-np.asarray(angle, float) + np.pi) % (2 * np.pi) - np.pi)


def compose(a_from_b: np.ndarray, b_from_c: np.ndarray) -> np.ndarray:
    """``a_from_c`` (..., 3); the two broadcast against each other."""
    p, q = np.asarray(a_from_b, float), np.asarray(b_from_c, float)
    c, s = np.cos(p[..., 2]), np.sin(p[..., 2])
    return np.stack(
        [
            p[..., 0] + c * q[..., 0] - s * q[..., 1],
            p[..., 1] + s * q[..., 0] + c * q[..., 1],
            wrap(p[..., 2] + q[..., 2]),
        ],
        -1,
    )


def invert(a_from_b: np.ndarray) -> np.ndarray:
    """``b_from_a`` (..., 3)."""
    p = np.asarray(a_from_b, float)
    c, s = np.cos(p[..., 2]), np.sin(p[..., 2])
    return np.stack([-c * p[..., 0] - s * p[..., 1], s * p[..., 0] - c * p[..., 1], wrap(-p[..., 2])], -1)


def relative(a_from_b: np.ndarray, a_from_c: np.ndarray) -> np.ndarray:
    """``b_from_c`` (..., 3): where c is, seen from b."""
    return compose(invert(a_from_b), a_from_c)


def transform(a_from_b: np.ndarray, points_b: np.ndarray) -> np.ndarray:
    """Points (..., 2) of frame b in frame a; the pose broadcasts over the leading axes of the points."""
    p, q = np.asarray(a_from_b, float), np.asarray(points_b, float)
    c, s = np.cos(p[..., 2]), np.sin(p[..., 2])
    return np.stack([p[..., 0] + c * q[..., 0] - s * q[..., 1], p[..., 1] + s * q[..., 0] + c * q[..., 1]], -1)
