"""Closing corners: neighbouring walls meet where their lines cross, not where the outermost echoes happened to fall."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from rgcore.geometry import segments as geometry

_LEAST_TURN = np.deg2rad(20.0)  # flatter than that, the crossing of two lines is not a place


def close_corners(lines: np.ndarray, reach: float) -> np.ndarray:
    """Lines (L, 2, 2) with the end of one and the start of the next moved to where the two lines cross.

    Free space is to the left of both, so a boundary runs on from an end to a start. A pair is closed if each is the
    other's nearest and neither moves farther than ``reach`` [m], nor farther than a quarter of its line.
    """
    if len(lines) < 2:
        return lines
    starts, ends = lines[:, 0], lines[:, 1]
    gap, after = cKDTree(starts).query(ends, distance_upper_bound=2 * reach)
    _, before = cKDTree(ends).query(starts, distance_upper_bound=2 * reach)
    a = np.flatnonzero(np.isfinite(gap))
    a = a[before[after[a]] == a]
    b = after[a]
    a, b = a[a != b], b[a != b]

    d, e = lines[a, 1] - lines[a, 0], lines[b, 1] - lines[b, 0]
    cross = d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]
    length_a, length_b = geometry.lengths(lines[a]), geometry.lengths(lines[b])
    turned = np.abs(cross) > np.sin(_LEAST_TURN) * length_a * length_b
    off = starts[b] - starts[a]
    along = (off[:, 0] * e[:, 1] - off[:, 1] * e[:, 0]) / np.where(turned, cross, 1.0)
    corner = starts[a] + along[:, None] * d
    move_a, move_b = np.hypot(*(corner - ends[a]).T), np.hypot(*(corner - starts[b]).T)
    close = turned & (move_a < np.minimum(reach, length_a / 4)) & (move_b < np.minimum(reach, length_b / 4))
    out = lines.copy()
    out[a[close], 1] = corner[close]
    out[b[close], 0] = corner[close]
    return out
