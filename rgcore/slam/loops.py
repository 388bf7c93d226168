"""Loop closures: found by global correlation, believed only when several agree.

How far an old keyframe may be off is the way through the graph to it times a drift (the Dijkstra projection of Olson,
"Recognizing places using spectrally clustered local matches", 2009). Where that is little the old keyframes simply join
the local map; where it is much the scan is correlated with the map of the old keyframes. A closure counts when its
response is high and without a rival, when the scans do not see through each other's walls, and when closures from
different places along the way ask for the same correction (pairwise consistency: Mangelson et al., ICRA 2018); and the
graph may still refuse it (``Lrgc``), if the other links would have to stretch. At the end all keyframes are tried once
more, from the poses that the closures have made better.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.slam.correlation import correlate, likelihood_field
from rgcore.slam.keyframes import LEAST_PAIRS, Keyframes, links_of
from rgcore.slam.local import Match, register
from rgcore.slam.posegraph import Links
from rgcore.slam.small import between
from rgcore.slam.ways import Ways

SAME = (0.25, 0.07)
"""[m, rad] closures that differ by less ask for the same correction."""
LITTLE = (0.1, 0.03)
"""[m, rad] closures that ask for less are closed already."""
RECENT = 15
"""Keyframes within which closures must agree."""
PAIR = 2
"""Closures that must agree in the search at the end, when the poses are known better."""
ROUNDS = 3
"""Searches at the end: each closure may show others."""
GAP = 100.0
"""Way [m] that a break counts for where odometry may still tell."""
UNCERTAIN = 0.2
"""Deviation [m] of a peak beyond which it says too little, as along a corridor."""
CLOSURE_SCALE = 30.0
"""Chi squared at which a closure's link begins to lose its weight."""


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
        self._vain: dict[tuple[int, int], np.ndarray] = {}  # searches that found nothing: relative pose, and window
        self._met: dict[int, int] = {}  # the nearest old keyframe that a keyframe is linked to
        self._broken = 0  # first keyframe since the last break
        self.tried = self.found = self.accepted = 0

    def advance(self, broken: bool, gap: bool) -> None:
        """The newest keyframe has come; ``broken`` if nobody knows how, ``gap`` if odometry may know."""
        poses = self.keyframes.poses
        step = float(np.hypot(*(poses[-1] - poses[-2])[:2])) if len(poses) > 1 else 0.0
        if broken:
            self._broken, step = len(poses) - 1, GAP if gap else np.inf
        self.ways.advance(step)

    def linked(self, k: int, members: np.ndarray, pairs: np.ndarray) -> None:
        """A keyframe has ``pairs`` (m,) of points with ``members`` (m,), some of them old."""
        poses = self.keyframes.poses
        old = members[(pairs > 2 * LEAST_PAIRS) & (np.abs(k - members) > self.settings.local_keyframes)]
        if len(old):
            d = np.hypot(*(poses[old] - poses[k])[:, :2].T)
            self._met[k] = int(old[d.argmin()])
            self.ways.shortcut(k, self._met[k], float(d.min()))

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
        return self._seek(len(self.keyframes) - 1, self.settings.least_closures)

    def seek_again(self) -> Iterator[Links]:
        """Closures that were missed while the poses were worse than now; ``closed`` must be told of each before the
        next.
        """
        s = self.settings
        for _ in range(ROUNDS):
            self._pending, accepted = [], self.accepted
            for k in range(s.local_keyframes + 1, len(self.keyframes)):
                if self._meets(k):
                    continue
                self.ways.turn_to(k, s.certain / s.drift)
                if self._among_friends(k):
                    continue
                self.ways.turn_to(k)
                found = self._seek(k, min(PAIR, s.least_closures))
                if found is None:
                    continue
                if self._closed_already():
                    self._join()
                else:
                    yield found
            if self.accepted == accepted:
                break
        self.ways.turn_to(len(self.keyframes) - 1)

    def _seek(self, k: int, least: int) -> Links | None:
        found = None if self._among_friends(k) else self._candidate(k)
        if found is None or self._in_vain(k, *found):
            return None
        self.tried += 1
        closure = self._close(k, *found)
        if closure is None:
            return None
        self.found += 1
        self._vain.pop((k, int(closure.members[len(closure.members) // 2])), None)
        self._pending = [c for c in self._pending if c.keyframe > k - RECENT] + [closure]
        same = consistent(self._pending, self.keyframes.poses[k])
        if len(same) < least:
            return None
        self._pending = same
        return self.links(same)

    def links(self, closures: list[Closure]) -> Links:
        """What closures say of their keyframes."""
        poses = self.keyframes.poses
        return Links.none().plus(*(links_of(c.match, poses, c.members, c.keyframe, CLOSURE_SCALE) for c in closures))

    def join(self, closures: list[Closure]) -> None:
        """These hold from now on."""
        for c in closures:
            self.linked(c.keyframe, c.members, c.match.pairs)
        self.ways.turn_to(len(self.keyframes) - 1)

    def closed(self, believed: bool) -> None:
        """The graph has been closed by what ``seek`` gave, or has refused it."""
        if believed:
            self.accepted += 1
            self._join()
        self._pending = []

    def _closed_already(self) -> bool:
        """Whether the last closure asks for so little that the refinement will do it."""
        last = self._pending[-1]
        off = np.abs(between(self.keyframes.poses[last.keyframe], last.match.pose))
        return bool(np.hypot(off[0], off[1]) < LITTLE[0] and off[2] < LITTLE[1])

    def _join(self) -> None:
        """The keyframe of the last closure is from now on linked to its members; nothing is pending."""
        last = self._pending[-1]
        self._pending = []
        self.linked(last.keyframe, last.members, last.match.pairs)

    def _among_friends(self, k: int) -> bool:
        """Whether an old keyframe whose place is certain stands next to this one."""
        s, poses = self.settings, self.keyframes.poses
        first = max(0, k - s.local_keyframes)
        sure = np.flatnonzero(self.ways.length[:first] * s.drift < s.certain)
        return bool((np.hypot(*(poses[sure] - poses[k])[:, :2].T) < 1.0).any())

    def _meets(self, k: int) -> bool:
        """Whether it is linked to an old keyframe next to it: then it is among friends, and no way need be sought."""
        poses, old = self.keyframes.poses, self._met.get(k)
        return old is not None and bool(np.hypot(*(poses[old] - poses[k])[:2]) < 1.0)

    def _in_vain(self, k: int, members: np.ndarray, window: np.ndarray) -> bool:
        """Whether the search has been made, from nearly the same pose in a window hardly wider, and found nothing."""
        j = int(members[len(members) // 2])
        seen = between(self.keyframes.poses[j], self.keyframes.poses[k])
        last = self._vain.get((k, j))
        self._vain[k, j] = np.append(seen, window[0])
        return last is not None and bool(np.hypot(*(seen - last[:3])[:2]) < SAME[0] and window[0] > 0.5 * last[3])

    def _candidate(self, k: int) -> tuple[np.ndarray, np.ndarray] | None:
        """Old keyframes that this one may see, and the window (3,) of where it may be; None if there are none."""
        s, poses = self.settings, self.keyframes.poses
        first = max(0, k - s.local_keyframes)
        d = np.hypot(*(poses[:first] - poses[k])[:, :2].T)
        unsure = self.ways.length[:first] * s.drift
        window = np.minimum(0.3 + unsure, s.window)
        open_ = np.flatnonzero((unsure >= s.certain) & np.isfinite(unsure) & (d < window + 2.0))
        if not len(open_):
            return None
        j = open_[(d[open_] - window[open_]).argmin()]
        members = np.arange(max(0, j - 5), min(first, j + 6))
        return members, np.array([window[j], window[j], min(0.6, 0.1 + 0.3 * unsure[j])])

    def _close(self, k: int, members: np.ndarray, window: np.ndarray) -> Closure | None:
        """A keyframe on the map of old ones, if it fits there, only there, and nothing speaks against it."""
        s, frames = self.settings, self.keyframes
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
