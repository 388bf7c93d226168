"""Loop closures: found by global correlation, believed only when several agree.

How far an old keyframe may be off is the way through the graph to it times a drift (the Dijkstra projection of Olson,
"Recognizing places using spectrally clustered local matches", 2009). Where that is little the old keyframes simply join
the local map; where it is much the scan is correlated with the map of the old keyframes. A closure counts when its
response is high and without a rival, when the scans do not see through each other's walls, and when closures from
different places along the way ask for the same correction (pairwise consistency: Mangelson et al., ICRA 2018).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.slam.correlation import correlate, likelihood_field
from rgcore.slam.keyframes import Keyframes, links_of
from rgcore.slam.local import Match, register
from rgcore.slam.posegraph import Links


class Ways:
    """Shortest way [m] through the graph from the newest keyframe to every other, kept up to date as it grows."""

    SLACK = 2.0
    """A shorter way is only worth a new search when it saves this much [m]."""

    def __init__(self) -> None:
        self.length = np.zeros(0)
        self._edges: list[tuple[int, int, float]] = []

    def advance(self, step: float) -> None:
        """A new keyframe, ``step`` [m] from the one before."""
        k = len(self.length)
        if k:
            self._edges.append((k - 1, k, step))
        self.length = np.append(self.length + step, 0.0)

    def shortcut(self, keyframe: int, distance: float) -> None:
        """The newest keyframe is linked to an old one ``distance`` [m] away."""
        self._edges.append((len(self.length) - 1, keyframe, distance))
        if self.length[keyframe] > distance + self.SLACK:
            a, b, d = np.array(self._edges).T
            n = len(self.length)
            graph = csr_matrix((np.maximum(d, 1e-3), (a.astype(int), b.astype(int))), shape=(n, n))
            self.length = dijkstra(graph, directed=False, indices=n - 1)


@dataclass(frozen=True)
class Closure:
    """The newest keyframe seen from old ones: ``correction`` is the rigid motion of the map frame that it asks for."""

    keyframe: int
    members: np.ndarray
    pose: np.ndarray
    correction: np.ndarray
    way: float


def consistent(closures: list[Closure], at: np.ndarray, tolerance: float) -> list[Closure]:
    """Those that ask for the same correction of the pose ``at`` (3,) as the last one does."""
    wanted = np.array([se2.compose(c.correction, at) for c in closures])
    off = se2.relative(wanted[-1], wanted)
    near = (np.hypot(off[:, 0], off[:, 1]) < tolerance) & (np.abs(off[:, 2]) < 0.2 * tolerance + 0.02)
    return [c for c, ok in zip(closures, near, strict=True) if ok]


class Loops:
    """Which old keyframes the newest one meets: those of the local map, and closures."""

    def __init__(self, keyframes: Keyframes, settings: Slam) -> None:
        self.keyframes, self.settings = keyframes, settings
        self.ways = Ways()
        self.pending: list[tuple[Closure, Match]] = []
        self.tried = self.found = self.accepted = 0

    def advance(self) -> None:
        """The newest keyframe has come."""
        poses = self.keyframes.poses
        self.ways.advance(float(np.hypot(*(poses[-1] - poses[-2])[:2])) if len(poses) > 1 else 0.0)

    def linked(self, members: np.ndarray, match: Match) -> None:
        """The newest keyframe was registered on the map of ``members``."""
        poses = self.keyframes.poses
        old = members[(match.pairs > 20) & (members < len(poses) - 1 - self.settings.local_keyframes)]
        if len(old):
            d = np.hypot(*(poses[old] - poses[-1])[:, :2].T)
            self.ways.shortcut(int(old[d.argmin()]), float(d.min()))

    def local_members(self) -> np.ndarray:
        """The keyframes of the local map: the newest, and old ones nearby whose place is certain."""
        s, n, poses = self.settings, len(self.keyframes), self.keyframes.poses
        first = max(0, n - s.local_keyframes)
        d = np.hypot(*(poses[:first] - poses[-1])[:, :2].T)
        sure = (self.ways.length[:first] * s.drift < s.certain) & (d < s.neighbourhood)
        old = np.flatnonzero(sure)
        old = np.sort(old[np.argsort(d[old], kind="stable")[: s.local_keyframes]])
        return np.concatenate([old, np.arange(first, n)])

    def seek(self) -> Links | None:
        """Closures of the newest keyframe with old ones far away by the graph; None until enough of them agree."""
        s, frames, k = self.settings, self.keyframes, len(self.keyframes) - 1
        pose = frames.poses[-1]
        first = max(0, k - s.local_keyframes)
        d = np.hypot(*(frames.poses[:first] - pose)[:, :2].T)
        unsure = self.ways.length[:first] * s.drift
        if ((unsure < s.certain) & (d < 1.0)).any():
            return None
        window = np.minimum(0.3 + unsure, s.window)
        open_ = np.flatnonzero((unsure >= s.certain) & (d < window + 2.0))
        if not len(open_):
            return None
        j = open_[(d[open_] - window[open_]).argmin()]
        lo, hi = max(0, j - 5), min(first, j + 6)
        members = np.arange(lo, hi)
        self.tried += 1
        closure = self._close(k, members, float(window[j]), float(self.ways.length[j]))
        if closure is None:
            return None
        self.found += 1
        self.pending = [p for p in self.pending if p[0].keyframe > k - 15] + [closure]
        same = consistent([p[0] for p in self.pending], pose, 0.25)
        if len(same) < 3:
            return None
        self.accepted += 1
        chosen = [p for p in self.pending if any(p[0] is c for c in same)]
        return Links.none().plus(*(links_of(m, frames.poses, c.members, c.keyframe, 30.0) for c, m in chosen))

    def closed(self) -> None:
        """The graph has been closed by what seek gave."""
        for c, m in self.pending[-1:]:
            self.linked(c.members, m)
        self.pending = []

    def _close(self, k: int, members: np.ndarray, window: float, way: float) -> tuple[Closure, Match] | None:
        s, frames = self.settings, self.keyframes
        surface = frames.surfaces[k]
        old = frames.map_of(members)
        if len(old.points) < 50 or len(surface.points) < 30:
            return None
        every = max(1, len(surface.points) // 80)
        peak = correlate(
            surface.points[::every],
            likelihood_field(old.points),
            frames.poses[k],
            np.array([window, window, min(0.5, 0.1 + 0.01 * way)]),
        )
        if peak is None or peak.response < s.least_response or peak.second > 0.8 * peak.response:
            return None
        if np.linalg.eigvalsh(peak.covariance[:2, :2])[1] > 0.2**2:
            return None
        match = register(surface, old, peak.pose, np.linalg.inv(peak.covariance), s.point_noise, 0.3)
        seen = frames.agree(k, members, match.pose)
        if match.share < 0.6 or seen[1] > 0.15 * seen[:2].sum():
            return None
        correction = se2.compose(match.pose, se2.invert(frames.poses[k]))
        return Closure(k, members, match.pose, correction, way), match
