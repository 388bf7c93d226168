"""Global localization: where a robot is that may be anywhere, from some scans and the way between them.

The scans are registered on each other to one view of the surroundings. That is compared with the lines at every place
and in every heading, coarse to fine as in Olson's multi-resolution search (ICRA 2009), by fields that know which way a
wall faces. (Neither regions nor the directions of the walls narrow the search: the first gain nothing over the hull of
the lines and would miss a robot outside of them, and furnished maps have walls in all directions.)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.geometry.compiled import kernel
from rgcore.geometry.grid import fill_polygons
from rgcore.robot.field import Field, climb, line_field, responses
from rgcore.robot.register import NORMALS_AGREE, View, view
from rgcore.slam.lrgc import Lrgc
from rgcore.slam.small import wrapped

COARSE, MIDDLE, FINE = (0.4, 0.5), (0.2, 0.25), (0.1, 0.1)
"""Resolution and deviation [m] of the fields of the three searches."""
STEP = 2
"""Cells of the coarse field from place to place."""
TURN = 0.1
"""rad from heading to heading."""
REACH = 12.0
"""m, echoes farther from the middle of the way are left out: they would need finer headings."""
SPACING = 0.25
"""m between the points of the view."""
POINTS = (80, 200)
"""How many of them are looked at in the first search, and later."""
CANDIDATES = (4000, 300, 5)
"""How many places are kept after each search."""
QUARTERS = np.array([(x, y, turn) for x in (-0.2, 0.2) for y in (-0.2, 0.2) for turn in (-0.025, 0.025)])
"""Where the second search looks around a place of the first [m, m, rad]."""
CLIMB = np.array([[0.2, 0.03], [0.1, 0.015]])
"""Steps [m, rad] of the third search."""
FREE_WAY = 0.8
"""Share of the way that must be where a robot may be."""
APART = (0.5, 0.2)
"""m, rad: nearer ones are the same answer."""


class Surroundings(NamedTuple):
    """What some scans show together, in the frame of the middle one.

    points   (n, 2) m
    normals  (n,)   rad, the directions of the surface's normals there
    poses    (k, 3) of the scans
    """

    points: np.ndarray
    normals: np.ndarray
    poses: np.ndarray


@dataclass(frozen=True)
class Ground:
    """The map, made ready for searching: three fields, and the cells (ix, iy) of the coarse one where a robot may be.

    ``free`` (H, W) is the mask of them, ``places`` (P, 2) some of them, evenly spread.
    """

    coarse: Field
    middle: Field
    fine: Field
    free: np.ndarray
    places: np.ndarray


def ground_of(ends: np.ndarray) -> Ground:
    """Lines ``ends`` (L, 2, 2), searched within their hull and a metre around."""
    coarse = line_field(ends, *COARSE, margin=REACH + 2.0)
    middle, fine = line_field(ends, *MIDDLE, margin=1.0), line_field(ends, *FINE, margin=1.0)
    around = ends.reshape(-1, 1, 2) + np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    around = around.reshape(-1, 2)
    hull = (around[ConvexHull(around).vertices] - coarse.corner) / coarse.resolution
    free = fill_polygons(np.zeros(coarse.layers.shape[1:], np.bool_), [hull], True)
    some = np.zeros_like(free)
    some[::STEP, ::STEP] = free[::STEP, ::STEP]
    return Ground(coarse, middle, fine, free, np.argwhere(some)[:, ::-1].copy())


def surroundings(
    ranges: np.ndarray, odometry: np.ndarray | None, bearings: np.ndarray, max_range: float
) -> Surroundings:
    """What successive scans (k, B) show; ``odometry`` (k, 3) odom_from_laser, or None."""
    mapper = Lrgc(bearings, Slam(), odometry is not None)
    for k in range(len(ranges)):
        mapper.add(ranges[k], odometry[k] if odometry is not None else np.zeros(3))
    poses = mapper.poses()
    poses = se2.relative(poses[len(poses) // 2], poses)
    views = [view(np.array(r, float), bearings, max_range, 0.5 * SPACING) for r in ranges]
    points = np.concatenate([se2.transform(pose, seen.points) for pose, seen in zip(poses, views, strict=True)])
    normals = np.concatenate([_normals(seen) + pose[2] for pose, seen in zip(poses, views, strict=True)])
    return _thinned(points, normals, poses)


def surroundings_of(seen: View) -> Surroundings:
    """What one scan shows."""
    return _thinned(seen.points, _normals(seen), np.zeros((1, 3)))


def _normals(seen: View) -> np.ndarray:
    """(n,) rad, nan where a normal is unknown."""
    return np.where(seen.agree == NORMALS_AGREE, np.arctan2(seen.directions[:, 1], seen.directions[:, 0]), np.nan)


def _thinned(points: np.ndarray, normals: np.ndarray, poses: np.ndarray) -> Surroundings:
    """One point a cell and direction, of those near enough and with a normal."""
    good = np.isfinite(normals) & (np.hypot(points[:, 0], points[:, 1]) < REACH)
    points, normals = points[good], normals[good]
    cells = np.column_stack([np.floor(points / SPACING), np.floor(normals % (2 * np.pi))]).astype(int)
    _, first = np.unique(cells, axis=0, return_index=True)
    return Surroundings(points[first], normals[first], poses)


def candidates(
    around: Surroundings, ground: Ground, within: tuple[np.ndarray, float] | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Poses (k, 3) of the middle scan and their responses (k,), the best first.

    They are sought everywhere, or ``within`` a disc: its centre (2,) and radius [m].
    """
    some = np.random.default_rng(0).permutation(len(around.points))[: POINTS[1]]
    points, normals = around.points[some], around.normals[some]
    coarse, places, turns = ground.coarse, ground.places, np.arange(-np.pi, np.pi, TURN)
    if within is not None:
        off = coarse.corner + (places + 0.5) * coarse.resolution - within[0]
        places = places[np.hypot(off[:, 0], off[:, 1]) <= within[1]]
    if len(points) == 0 or len(places) == 0:
        return np.zeros((0, 3)), np.zeros(0)
    way = around.poses[:: max(1, len(around.poses) // 5), :2].copy()
    few = slice(POINTS[0])
    found = responses(points[few], normals[few], way, turns, places, ground.free, FREE_WAY, coarse).reshape(-1)
    best = np.argpartition(-found, min(CANDIDATES[0], len(found) - 1))[: CANDIDATES[0]]
    t, p = np.unravel_index(best, (len(turns), len(places)))
    poses = np.column_stack([coarse.corner + (places[p] + 0.5) * coarse.resolution, turns[t]])
    poses = (poses[:, None] + QUARTERS).reshape(-1, 3)
    _, score = climb(points, normals, poses, CLIMB[:0], ground.middle)
    poses = poses[np.argsort(-score)]
    poses = poses[distinct(poses, 0.3, 0.06, CANDIDATES[1])]
    poses, score = climb(points, normals, poses, CLIMB, ground.fine)
    order = np.argsort(-score)
    keep = order[distinct(poses[order], *APART, CANDIDATES[2])]
    return poses[keep], score[keep]


@kernel
def distinct(poses, metres, radians, most):  # type: ignore[no-untyped-def]
    """Indices of at most ``most`` poses (K, 3), best first, without those near to a better one."""
    keep = np.empty(min(most, len(poses)), np.int64)
    n = 0
    for i in range(len(poses)):
        if n == len(keep):
            break
        alone = True
        for k in range(n):
            dx, dy = poses[i, 0] - poses[keep[k], 0], poses[i, 1] - poses[keep[k], 1]
            if dx * dx + dy * dy < metres * metres and abs(wrapped(poses[i, 2] - poses[keep[k], 2])) < radians:
                alone = False
                break
        if alone:
            keep[n] = i
            n += 1
    return keep[:n]
