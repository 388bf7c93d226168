"""Refinement: every keyframe on all its neighbours, all at once, until the map is as sharp as the scans.

One pass pairs the points of each keyframe with those of its neighbours at the poses so far; each pair of keyframes
thereby gives a link, and the graph of all links is solved; so the rounds are Gauss-Newton steps of the point-to-line
alignment of all scans together (Lu & Milios 1997; Borrmann et al. 2008).
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from rgcore.config import Slam
from rgcore.geometry.compiled import kernel
from rgcore.slam.agreement import agreement
from rgcore.slam.keyframes import LEAST_PAIRS, Keyframes, write_links
from rgcore.slam.local import linearise, local_map
from rgcore.slam.posegraph import Links, optimise

REACHES = (0.3, 0.15, 0.15, 0.15)
"""How far apart [m] the points of a pair may be, a round."""
CONTRADICTED = 0.2
"""Keyframes that contradict each other by more than this share do not stand where the graph says: no pair of them
counts.
"""


def refine(keyframes: Keyframes, odometry: Links, settings: Slam) -> None:
    """Improves the poses of the keyframes in place; ``odometry`` holds what their scans do not constrain."""
    if len(keyframes) < 2:
        return
    a, b = neighbours(keyframes, settings)
    for reach in REACHES:
        found = _pair(keyframes, a, b, reach, settings.point_noise)
        keyframes.poses[:] = optimise(keyframes.poses, odometry.plus(found), rounds=3)


def neighbours(keyframes: Keyframes, settings: Slam) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (a, b) (P,) of keyframes that see the same things, sorted by b: its mates in time, and the nearest of
    other passes.
    """
    poses, half = keyframes.poses, settings.local_keyframes // 2
    metric = np.column_stack([poses[:, :2], np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    near = cKDTree(metric).query(metric, range(1, 4 * half + 2), distance_upper_bound=settings.neighbourhood)[1]
    own = np.repeat(np.arange(len(poses))[:, None], near.shape[1], 1)
    others = (near < len(poses)) & (np.abs(near - own) > half)
    others &= np.cumsum(others, 1) <= 2 * half  # so many of them are among the nearest, itself and its mates apart
    ahead = [np.stack([np.arange(len(poses) - k), np.arange(k, len(poses))]) for k in range(1, half + 1)]
    mates = np.concatenate([np.zeros((2, 0), int), *ahead, *(pair[::-1] for pair in ahead)], 1)
    mates = mates[:, ((metric[mates[0]] - metric[mates[1]]) ** 2).sum(1) < settings.neighbourhood**2]
    a, b = np.concatenate([mates, np.stack([near[others], own[others]])], 1)
    order = np.lexsort((a, b))
    a, b = a[order], b[order]
    seen = _agreements(keyframes.surfaces, keyframes.ranges, keyframes.bearings, poses, a, b)
    keep = seen[:, 1] <= CONTRADICTED * seen[:, :2].sum(1)
    return a[keep], b[keep]


def _pair(keyframes: Keyframes, a: np.ndarray, b: np.ndarray, reach: float, noise: float) -> Links:
    start = np.searchsorted(b, np.arange(len(keyframes) + 1))
    measured, information, pairs = np.zeros((len(a), 3)), np.zeros((len(a), 3, 3)), np.zeros(len(a))
    _link_all(
        keyframes.surfaces, keyframes.walls, keyframes.poses, a, start, reach, noise, measured, information, pairs
    )
    ok = pairs >= LEAST_PAIRS
    return Links(a[ok], b[ok], measured[ok], information[ok], np.full(int(ok.sum()), 30.0))


@kernel
def _link_all(surfaces, walls, poses, near, start, reach, noise, measured, information, pairs):  # type: ignore[no-untyped-def]
    for i in range(len(poses)):
        own = slice(start[i], start[i + 1])
        members = near[own]
        if len(members) == 0:
            continue
        on = local_map(walls, members, poses)
        part = slice(surfaces.start[i], surfaces.start[i + 1])
        a, b = np.zeros((len(members), 3, 3)), np.zeros((len(members), 3))
        linearise(surfaces.points[part], surfaces.normals[part], on, poses[i], reach, noise, a, b, pairs[own])
        write_links(a, b, poses, members, poses[i], measured[own], information[own])


@kernel
def _agreements(surfaces, ranges, bearings, poses, a, b):  # type: ignore[no-untyped-def]
    counts = np.zeros((len(a), 3))
    for p in range(len(a)):
        points = surfaces.points[surfaces.start[b[p]] : surfaces.start[b[p] + 1]]
        seen = agreement(surfaces, ranges, bearings, poses, a[p : p + 1], points, ranges[b[p]], poses[b[p]])
        for i in range(3):
            counts[p, i] = seen[i]
    return counts
