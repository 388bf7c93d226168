"""Tables: four legs at the corners of a rectangle that beams went under (paper, section III)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from rgcore.config import Objects as Settings
from rgcore.evidence import Evidence
from rgcore.geometry.grid import components
from rgcore.places.freespace import FreeSpace

LEG = 0.26
"""m: legs are no wider, blurred by the errors of the poses."""
SLACK = 0.16
"""m: how far the diagonals of four legs may differ in length, and half of it in their middles: legs are seen from one
side, and blobs are a raster's."""


@dataclass(frozen=True, eq=False)
class Legs(Evidence):
    """Small things that stand free (N): middle (N, 2) [m], extent (N,) [m], hits (N,)."""

    middle: np.ndarray
    extent: np.ndarray
    hits: np.ndarray


@dataclass(frozen=True, eq=False)
class Tables(Evidence):
    """Hypotheses (K): the four legs (K, 4) in their order around the table, corners (K, 4, 2) [m]; features (K, 10)."""

    legs: np.ndarray
    corners: np.ndarray
    features: np.ndarray


def find_legs(free: FreeSpace, mask: np.ndarray) -> Legs:
    """The small pieces of the raster that beams ended in, with free cells all around; ``mask``: the free cells."""
    labels, stats = components(~mask, diagonal=True)
    extent = stats[:, 2:4].max(1) * free.resolution
    small = extent <= LEG
    small[0] = False
    iy, ix = np.nonzero(small[labels])
    label, weight = labels[iy, ix], free.hits[iy, ix].astype(float)
    n = len(stats)
    hits = np.bincount(label, weight, n)
    keep = np.nonzero(small & (hits >= 2))[0]
    total = np.maximum(hits, 1)
    at = np.stack([np.bincount(label, weight * v, n) / total for v in (ix, iy)], 1)
    return Legs(free.origin + (at[keep] + 0.5) * free.resolution, extent[keep], hits[keep])


def tables_on(legs: Legs, free: FreeSpace, mask: np.ndarray, settings: Settings) -> Tables:
    """All rectangles of four legs: two pairs with one middle and one length are the diagonals of a rectangle."""
    most = float(np.hypot(settings.max_width, settings.max_depth))
    none = Tables(np.zeros((0, 4), int), np.zeros((0, 4, 2)), np.zeros((0, 10)))
    if len(legs) < 4:
        return none
    pairs = cKDTree(legs.middle).query_pairs(min(most, 3.0), output_type="ndarray")
    a, b = legs.middle[pairs[:, 0]], legs.middle[pairs[:, 1]]
    length = np.hypot(*(b - a).T)
    long = length > 0.6
    pairs, key = pairs[long], np.c_[(a + b) / 2, length / 2][long]
    if len(pairs) < 2:
        return none
    both = cKDTree(key).query_pairs(SLACK / 2, output_type="ndarray")
    first, second = pairs[both[:, 0]], pairs[both[:, 1]]
    quad = np.stack([first[:, 0], second[:, 0], first[:, 1], second[:, 1]], 1)
    p = legs.middle[quad]
    d = p[:, 2] - p[:, 0]
    e = p[:, 3] - p[:, 1]
    turn = d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]
    quad = np.where((turn < 0)[:, None], quad[:, [0, 3, 2, 1]], quad)
    p = legs.middle[quad]
    side = np.stack([np.hypot(*(p[:, 1] - p[:, 0]).T), np.hypot(*(p[:, 2] - p[:, 1]).T)], 1)
    ok = (side.min(1) > MIN_SIDE) & (side.max(1) < MAX_SIDE)
    quad, p = quad[ok], p[ok]
    return Tables(quad, p, _features(quad, p, legs, free, mask)) if len(quad) else none


MIN_SIDE, MAX_SIDE = 0.4, 2.4
"""m: the legs of chairs are nearer to each other, those of conference tables are farther apart and more than four."""

_INNER = (np.stack(np.meshgrid(np.arange(7), np.arange(7)), -1).reshape(-1, 2) + 1) / 8


def _features(quad: np.ndarray, p: np.ndarray, legs: Legs, free: FreeSpace, mask: np.ndarray) -> np.ndarray:
    sides = np.roll(p, -1, axis=1) - p
    size = np.hypot(sides[..., 0], sides[..., 1])
    width, depth = (size[:, 0] + size[:, 2]) / 2, (size[:, 1] + size[:, 3]) / 2
    diagonal = np.hypot(*(p[:, 2] - p[:, 0]).T) - np.hypot(*(p[:, 3] - p[:, 1]).T)
    middle = np.hypot(*(p[:, 0] + p[:, 2] - p[:, 1] - p[:, 3]).T) / 2
    s, t = _INNER.T
    inner = p[:, :1] + s[:, None] * sides[:, :1] + t[:, None] * sides[:, 1:2]
    passed = np.asarray(free.grid(mask).at(inner, outside=False), bool).mean(1)
    tree = cKDTree(legs.middle)
    radius = np.hypot(width, depth) / 2
    around = np.array([len(k) for k in tree.query_ball_point(p.mean(1), radius + 0.5)]) - 4
    nearest = tree.query(legs.middle, 2)[0][:, 1] if len(legs) > 1 else np.full(len(legs), 9.0)
    return np.stack(
        [
            np.abs(diagonal),
            middle,
            np.minimum(width, depth),
            np.maximum(width, depth),
            passed,
            np.log1p(around),
            nearest[quad].min(1).clip(0, 1),
            legs.extent[quad].mean(1),
            np.ptp(legs.extent[quad], 1),
            np.ptp(np.log(legs.hits[quad]), 1),
        ],
        1,
    )
