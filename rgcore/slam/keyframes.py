"""Keyframes: the scans that the map is made of."""

from __future__ import annotations

import numpy as np

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.slam.agreement import agreement
from rgcore.slam.local import LocalMap, Match, discount, local_map
from rgcore.slam.posegraph import Links
from rgcore.slam.surface import Surface

SEEN_THROUGH = 0.25
"""A surface [m] nearer than the reading through it contradicts it."""
LEAST_PAIRS = 10.0
"""Fewer paired points than this make no link."""


class Keyframes:
    """A growing list: ``poses`` (K, 3) map_from_laser, their surfaces, and the numbers of their scans."""

    def __init__(self, settings: Slam, bearings: np.ndarray) -> None:
        self.settings, self.bearings = settings, bearings
        self.ranges: list[np.ndarray] = []
        self.surfaces: list[Surface] = []
        self.scans: list[int] = []
        self._poses = np.zeros((64, 3))

    def __len__(self) -> int:
        return len(self.surfaces)

    @property
    def poses(self) -> np.ndarray:
        """(K, 3); a view, so that it can be written."""
        return self._poses[: len(self)]

    def add(self, pose: np.ndarray, surface: Surface, ranges: np.ndarray, scan: int) -> None:
        """Append one."""
        if len(self) == len(self._poses):
            self._poses = np.concatenate([self._poses, np.zeros_like(self._poses)])
        self._poses[len(self)] = pose
        self.surfaces.append(surface)
        self.ranges.append(np.asarray(ranges, float))
        self.scans.append(scan)

    def map_of(self, members: np.ndarray) -> LocalMap:
        """The local map that these keyframes make."""
        return local_map([self.surfaces[k] for k in members], self.poses[members])

    def agree(self, keyframe: int, members: np.ndarray, pose: np.ndarray) -> np.ndarray:
        """(3,) how many points of a keyframe at ``pose`` the members confirm, contradict and cannot see, and the other way."""
        counts = np.zeros(3)
        for k in members:
            at = se2.relative(self.poses[k], pose)
            counts += agreement(self.surfaces[keyframe].points, self.ranges[k], self.bearings, at, SEEN_THROUGH)
            counts += agreement(
                self.surfaces[k].points, self.ranges[keyframe], self.bearings, se2.invert(at), SEEN_THROUGH
            )
        return counts


def links_of(match: Match, poses: np.ndarray, members: np.ndarray, keyframe: int, scale: float = np.inf) -> Links:
    """What a keyframe, registered on the map of ``members``, says about its pose relative to each of them."""
    out = []
    for o, k in enumerate(members):
        if match.pairs[o] < LEAST_PAIRS:
            continue
        a, b = match.information[o].copy(), match.gradient[o].copy()
        discount(a, b)
        step = np.linalg.solve(a + 1e-3 * np.eye(3), b)
        out.append((k, a, step))
    if not out:
        return Links.none()
    a_index = np.array([k for k, _, _ in out])
    turn = np.zeros((len(out), 3, 3))
    c, s = np.cos(poses[a_index, 2]), np.sin(poses[a_index, 2])
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1], turn[:, 2, 2] = c, s, -s, c, 1
    information = turn @ np.array([a for _, a, _ in out]) @ turn.transpose(0, 2, 1)
    step = np.einsum("lij,lj->li", turn, np.array([d for _, _, d in out]))
    measured = se2.relative(poses[a_index], np.broadcast_to(match.pose, (len(out), 3))) + step
    return Links(a_index, np.full(len(out), keyframe), measured, information, np.full(len(out), scale))
