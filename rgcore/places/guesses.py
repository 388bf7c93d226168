"""Gateways that a single scan tells of, before a survey has judged them (paper, section IV-D)."""

from __future__ import annotations

from collections import deque

import numpy as np

from rgcore.config import Places as Settings
from rgcore.geometry import se2
from rgcore.places import doorway
from rgcore.places.growing import GrowingSpace
from rgcore.places.sofar import SAME_GATEWAY, KnownGateway

FAR = 10.0
"""m: echoes farther off are no posts of a door beside the robot."""

CERTAIN = 0.9
"""What the network must give a gateway that only one scan tells of: a cabinet beside a wall looks like one too."""

NARROWER = 0.75
"""A doorway is so much narrower than what the robot came from ..."""

BACK = 1.5
"""m: ... over the last of its way."""

APART = 1.0
"""m: a guess nearer to a gateway that is known is that one."""


class Guesses:
    """``standing``: guesses that no survey has judged yet."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.standing: list[KnownGateway] = []
        self._refused: list[KnownGateway] = []
        self._widths: deque[tuple[float, float]] = deque()  # way, width beside the robot

    def beside(
        self,
        points: np.ndarray,
        pose: np.ndarray,
        moved: np.ndarray,
        way: float,
        space: GrowingSpace,
        known: np.ndarray,
    ) -> np.ndarray | None:
        """Posts (2, 2) m of a gateway that nobody knows yet and that the robot stands in, if the scan shows one.

        ``points`` (K, 2): echoes in the robot's frame at ``pose`` (3,), after it has ``moved`` (2,) and come a ``way``
        of so many metres in all; ``known`` (G, 2, 2): posts of the gateways there are.
        """
        turn = np.array([0.0, 0.0, np.arctan2(moved[1], moved[0]) - pose[2]])
        in_way = se2.transform(se2.invert(turn), points[np.hypot(*points.T) < FAR])
        posts = doorway.beside(in_way, self.settings)
        width = 2.0 * self.settings.widest_door if posts is None else float(np.hypot(*(posts[1] - posts[0])))
        self._widths.append((way, width))
        while way - self._widths[0][0] > BACK:
            self._widths.popleft()
        if posts is None or width > NARROWER * max(w for _, w in self._widths):
            return None
        there = se2.transform(pose, se2.transform(turn, posts))
        if len(known) and np.hypot(*(known.mean(1) - there.mean(0)).T).min() < APART:
            return None
        sure, there = doorway.looks_like_one(space.window(pose[:2], doorway.WINDOW), there, self.settings)
        return there if sure >= CERTAIN else None

    def refused(self, middle: np.ndarray, poses: np.ndarray) -> bool:
        """Whether a survey did not find a guess here."""
        return any(np.hypot(*(g.posts(poses).mean(0) - middle)) < SAME_GATEWAY for g in self._refused)

    def judged(self, scans: int, found: set[int]) -> None:
        """A survey that knew so many scans has found gateways of those numbers: forget the guesses it knew of."""
        of = [g for g in self.standing if g.anchor < scans]
        self._refused += [g for g in of if g.number not in found]
        self.standing = [g for g in self.standing if g.anchor >= scans]
