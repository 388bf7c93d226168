"""Refinement: every keyframe on all its neighbours, all at once, until the map is as sharp as the scans.

One pass pairs the points of each keyframe with those of its neighbours at the poses so far; each pair of keyframes thereby
gives a link, and the graph of all links is solved; so the rounds are Gauss-Newton steps of the point-to-line alignment of
all scans together (Lu & Milios 1997; Borrmann et al. 2008).
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.slam.keyframes import Keyframes, links_of
from rgcore.slam.local import register
from rgcore.slam.posegraph import Links, optimise


def refine(keyframes: Keyframes, links: Links, settings: Slam, rounds: int = 4) -> None:
    """Improves the poses of the keyframes in place; ``links`` hold what their scans do not constrain."""
    odometry = links[(links.b == links.a + 1) & np.isfinite(links.scale)]
    for k in range(rounds):
        reach = 0.3 if k == 0 else 0.15
        found = [
            _links(keyframes, i, near, reach, settings) for i, near in enumerate(neighbours(keyframes.poses, settings))
        ]
        keyframes.poses[:] = optimise(keyframes.poses, odometry.plus(*found), rounds=3)


def neighbours(poses: np.ndarray, settings: Slam) -> list[np.ndarray]:
    """For each keyframe the numbers of those near it: half of them its successors in time, half from other passes."""
    half = settings.local_keyframes // 2
    metric = np.column_stack([poses[:, :2], np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    near = cKDTree(metric).query_ball_point(metric, settings.neighbourhood)
    out = []
    for i, candidates in enumerate(near):
        c = np.array(candidates)
        gap = np.abs(c - i)
        d = ((metric[c] - metric[i]) ** 2).sum(1)
        others, mates = c[gap > half], c[(gap > 0) & (gap <= half)]
        others = others[np.argsort(d[gap > half], kind="stable")[: 2 * half]]
        out.append(np.sort(np.concatenate([others, mates])))
    return out


def _links(keyframes: Keyframes, i: int, near: np.ndarray, reach: float, settings: Slam) -> Links:
    if not len(near):
        return Links.none()
    pose = keyframes.poses[i]
    match = register(
        keyframes.surfaces[i], keyframes.map_of(near), pose, np.eye(3), settings.point_noise, reach, rounds=0
    )
    return links_of(match, keyframes.poses, near, i, 30.0)
