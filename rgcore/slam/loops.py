"""Loop closures: found by global correlation, believed only when several agree.

How far an old keyframe may be off is the way through the graph to it times a drift (the Dijkstra projection of Olson,
"Recognizing places using spectrally clustered local matches", 2009). Where that is little the old keyframes simply join
the local map; where it is much the scan is correlated with the map of the old keyframes. A closure counts when its
response is high and without a rival, when the scans do not see through each other's walls, and when closures from
different places along the way ask for the same correction (pairwise consistency: Mangelson et al., ICRA 2018); and the
graph may still refuse it (``Lrgc``), if the other links would have to stretch.
"""

from __future__ import annotations

from array import array
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.slam.correlation import correlate, likelihood_field
from rgcore.slam.keyframes import LEAST_PAIRS, Keyframes, links_of
from rgcore.slam.local import Match, register
from rgcore.slam.posegraph import Links

SAME = (0.25, 0.07)
"""[m, rad] closures that differ by less ask for the same correction."""
RECENT = 15
"""Keyframes within which closures must agree."""
BROKEN = 100.0
"""Way [m] that a break in the log counts for."""
UNCERTAIN = 0.2
"""Deviation [m] of a peak beyond which it says too little, as along a corridor."""
CLOSURE_SCALE = 30.0
"""Chi squared at which a closure's link begins to lose its weight."""


class Ways:
    """Shortest way [m] through the graph from the newest keyframe to every other, kept up to date as it grows."""

    SLACK = 2.0
    """A shorter way is only worth a new search when it saves this much [m]."""

    def __init__(self) -> None:
        self.length = np.zeros(0)
        self._ends, self._lengths = array("q"), array("d")  # of the edges: two keyframes each, and a length [m]

    def advance(self, step: float) -> None:
        """A new keyframe, ``step`` [m] from the one before."""
        k = len(self.length)
        if k:
            self._add(k - 1, k, step)
        self.length = np.append(self.length + step, 0.0)

    def shortcut(self, keyframe: int, distance: float) -> None:
        """The newest keyframe is linked to an old one ``distance`` [m] away."""
        n = len(self.length)
        self._add(n - 1, keyframe, distance)
        if self.length[keyframe] > distance + self.SLACK:
            ends = np.array(self._ends).reshape(-1, 2)
            graph = csr_matrix((np.array(self._lengths), (ends[:, 0], ends[:, 1])), shape=(n, n))
            self.length = dijkstra(graph, directed=False, indices=n - 1)

    def _add(self, a: int, b: int, length: float) -> None:
        self._ends.extend((a, b))
        self._lengths.append(max(length, 1e-3))  # a sparse graph takes zero for no edge


@dataclass(frozen=True)
class Closure:
    """A keyframe found on the map of old ``members``; ``correction`` (3,) is the motion of the map that it asks for."""

    keyframe: int
    members: np.ndarray
    match: Match
    correction: np.ndarray


def consistent(closures: list[Closure], at: np.ndarray) -> list[Closure]:
    """Those that ask for the same correction of the pose ``at`` (3,) as the last one does."""
    wanted = np.array([se2.compose(c.correction, at) for c in closures])
    off = se2.relative(wanted[-1], wanted)
    near = (np.hypot(off[:, 0], off[:, 1]) < SAME[0]) & (np.abs(off[:, 2]) < SAME[1])
    return [c for c, ok in zip(closures, near, strict=True) if ok]


class Loops:
    """Which old keyframes the newest one meets: those of the local map, and closures."""

    def __init__(self, keyframes: Keyframes, settings: Slam) -> None:
        self.keyframes, self.settings = keyframes, settings
        self.ways = Ways()
        self._pending: list[Closure] = []
        self._broken = 0  # first keyframe since the last break
        self.tried = self.found = self.accepted = 0

    def advance(self, broken: bool) -> None:
        """The newest keyframe has come; ``broken`` if nobody knows how."""
        poses = self.keyframes.poses
        step = float(np.hypot(*(poses[-1] - poses[-2])[:2])) if len(poses) > 1 else 0.0
        if broken:
            self._broken, step = len(poses) - 1, BROKEN
        self.ways.advance(step)

    def linked(self, members: np.ndarray, pairs: np.ndarray) -> None:
        """The newest keyframe has ``pairs`` (m,) of points with ``members`` (m,), some of them old."""
        poses = self.keyframes.poses
        old = members[(pairs > 2 * LEAST_PAIRS) & (members < len(poses) - 1 - self.settings.local_keyframes)]
        if len(old):
            d = np.hypot(*(poses[old] - poses[-1])[:, :2].T)
            self.ways.shortcut(int(old[d.argmin()]), float(d.min()))

    def local_members(self) -> np.ndarray:
        """The keyframes of the local map: the newest, and old ones nearby whose place is certain."""
        s, n, poses = self.settings, len(self.keyframes), self.keyframes.poses
        first = max(self._broken, n - s.local_keyframes)
        d = np.hypot(*(poses[:first] - poses[-1])[:, :2].T)
        old = np.flatnonzero((self.ways.length[:first] * s.drift < s.certain) & (d < s.neighbourhood))
        old = np.sort(old[np.argsort(d[old], kind="stable")[: s.local_keyframes]])
        return np.concatenate([old, np.arange(first, n)])

    def seek(self) -> Links | None:
        """Closures of the newest keyframe with old ones far away by the graph; None until enough of them agree."""
        s, k = self.settings, len(self.keyframes) - 1
        found = self._candidate()
        if found is None:
            return None
        self.tried += 1
        closure = self._close(*found)
        if closure is None:
            return None
        self.found += 1
        self._pending = [c for c in self._pending if c.keyframe > k - RECENT] + [closure]
        same = consistent(self._pending, self.keyframes.poses[-1])
        if len(same) < s.least_closures:
            return None
        self._pending = same
        poses = self.keyframes.poses
        return Links.none().plus(*(links_of(c.match, poses, c.members, c.keyframe, CLOSURE_SCALE) for c in same))

    def closed(self, believed: bool) -> None:
        """The graph has been closed by what ``seek`` gave, or has refused it."""
        last = self._pending[-1]
        self._pending = []
        if believed:
            self.accepted += 1
            self.linked(last.members, last.match.pairs)

    def _candidate(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Old keyframes that the newest may see, and the window (3,) of where it may be; None if it is among
        friends.
        """
        s, poses = self.settings, self.keyframes.poses
        first = max(0, len(poses) - 1 - s.local_keyframes)
        d = np.hypot(*(poses[:first] - poses[-1])[:, :2].T)
        unsure = self.ways.length[:first] * s.drift
        if ((unsure < s.certain) & (d < 1.0)).any():
            return None
        window = np.minimum(0.3 + unsure, s.window)
        open_ = np.flatnonzero((unsure >= s.certain) & (d < window + 2.0))
        if not len(open_):
            return None
        j = open_[(d[open_] - window[open_]).argmin()]
        members = np.arange(max(0, j - 5), min(first, j + 6))
        return members, np.array([window[j], window[j], min(0.6, 0.1 + 0.3 * unsure[j])])

    def _close(self, members: np.ndarray, window: np.ndarray) -> Closure | None:
        """The newest keyframe on the map of old ones, if it fits there, only there, and nothing speaks against it."""
        s, frames, k = self.settings, self.keyframes, len(self.keyframes) - 1
        surface, on = frames.surface(k), frames.map_of(members)
        if len(on.points) < s.least_points or len(surface.points) < s.least_points:
            return None
        some = surface.points[:: max(1, len(surface.points) // 80)]
        peak = correlate(some, likelihood_field(on.points), frames.poses[k], window, s.least_response, s.rival)
        if peak is None or np.linalg.eigvalsh(peak.covariance[:2, :2])[1] > UNCERTAIN**2:
            return None
        match = register(surface, on, peak.pose, np.linalg.inv(peak.covariance), s.point_noise, 0.3)
        confirmed, contradicted, _ = frames.agree(surface, frames.ranges[k], match.pose, members)
        if match.share < 0.6 or contradicted > 0.15 * (confirmed + contradicted):
            return None
        return Closure(k, members, match, se2.compose(match.pose, se2.invert(frames.poses[k])))
