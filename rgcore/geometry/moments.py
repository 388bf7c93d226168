"""Length-weighted moments of segments and the line through them (paper, section IV-B, "Updating Lines").

``moments (..., 6)`` are ``sum_W sum_X sum_Y sum_XX sum_YY sum_XY``: each end of a segment counts with the segment's
length. They are sums, so the moments of two lines together are the sum of theirs. Products of large coordinates lose
digits: keep moments about a point near the lines (``about``, :func:`moved`), not about a far origin.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rgcore.geometry.compiled import kernel

W, X, Y, XX, YY, XY = range(6)


class Regression(NamedTuple):
    """``y = slope x + offset``, or where ``steep`` (slope > 45 degrees): ``x = slope y + offset``."""

    slope: float
    offset: float
    steep: bool


def moments(ends: np.ndarray, about: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """(N, 6) moments of segments (N, 2, 2) about a point [m]; add them up for the moments of a set."""
    p = np.asarray(ends, float) - np.asarray(about)
    length = np.hypot(*np.moveaxis(p[:, 1] - p[:, 0], -1, 0))
    x, y = p[..., 0], p[..., 1]
    terms = (np.full(len(p), 2.0), x.sum(1), y.sum(1), (x * x).sum(1), (y * y).sum(1), (x * y).sum(1))
    return np.stack(terms, 1) * length[:, None]


def moved(m: np.ndarray, by: tuple[float, float]) -> np.ndarray:
    """Moments (..., 6) of the same segments shifted by ``by`` [m]."""
    (dx, dy), out = by, np.array(m, float)
    out[..., X] += dx * m[..., W]
    out[..., Y] += dy * m[..., W]
    out[..., XX] += 2 * dx * m[..., X] + dx * dx * m[..., W]
    out[..., YY] += 2 * dy * m[..., Y] + dy * dy * m[..., W]
    out[..., XY] += dy * m[..., X] + dx * m[..., Y] + dx * dy * m[..., W]
    return out


def regression(m: np.ndarray) -> Regression:
    """The paper's online linear regression from moments (6,): of y on x up to 45 degrees, of x on y beyond."""
    slope, offset, steep = _regression(np.asarray(m, float))
    return Regression(float(slope), float(offset), bool(steep))


@kernel
def _regression(m):  # type: ignore[no-untyped-def]
    spread_x = m[0] * m[3] - m[1] * m[1]
    spread_y = m[0] * m[4] - m[2] * m[2]
    if spread_x >= spread_y:
        if spread_x <= 0.0:
            return 0.0, m[2] / m[0], False
        return (m[5] * m[0] - m[1] * m[2]) / spread_x, (m[3] * m[2] - m[1] * m[5]) / spread_x, False
    return (m[5] * m[0] - m[1] * m[2]) / spread_y, (m[4] * m[1] - m[2] * m[5]) / spread_y, True


@kernel
def line_through(m):  # type: ignore[no-untyped-def]
    """From moments (6,): a point of the line (their centre, put on it), its unit direction and the rms distance.

    The direction is that of growing x (growing y where steep); the line is the paper's regression.
    """
    slope, _, steep = _regression(m)
    cx, cy = m[1] / m[0], m[2] / m[0]
    norm = np.sqrt(1.0 + slope * slope)
    ux, uy = (slope / norm, 1.0 / norm) if steep else (1.0 / norm, slope / norm)
    xx, yy, xy = m[3] / m[0] - cx * cx, m[4] / m[0] - cy * cy, m[5] / m[0] - cx * cy
    return cx, cy, ux, uy, np.sqrt(max(0.0, xx * uy * uy + yy * ux * ux - 2 * xy * ux * uy))


def projected(m: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (L, K, 2) put on the lines through moments (L, 6); all about the same points."""
    through = np.array([line_through(row) for row in m]).reshape(-1, 5)
    center, u = through[:, None, :2], through[:, None, 2:4]
    return center + ((points - center) * u).sum(-1, keepdims=True) * u
