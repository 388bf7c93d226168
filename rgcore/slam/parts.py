"""Parts of a drive: a break begins a new one, which is sought on the others until it is found there.

After a break nobody knows where the robot is, so the part is sought everywhere and whichever way it is turned: what its
newest keyframes saw is correlated, as one, with all that another part saw (global correlation over submaps: Olson,
"Real-time correlative scan matching", 2009; Hess et al., ICRA 2016). A place counts when it has no rival, and when
most keyframes, registered there one by one, agree about it and see through no walls.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.slam.correlation import correlate, likelihood_field
from rgcore.slam.keyframes import Keyframes
from rgcore.slam.local import register
from rgcore.slam.loops import Closure, consistent
from rgcore.slam.small import between, chain

SUBMAP = 50
"""Newest keyframes that are sought together."""
SPREAD = 7.0
"""Extent [m] of the way that must be confirmed: rooms, which may have twins, must be left and others found behind."""
AGAIN = (2.0, 1.4)
"""A part is sought again after so much more way: [m], and the factor that it grows by."""
GRID, POINTS = 0.2, 200
"""Points of a submap are thinned to one a cell of this side [m], and to so many."""
RESOLUTION = 0.2
"""Finest cell [m] of the search over a whole part."""
WORK = 2e8
"""Lookups that bound a search: of larger parts the cells are larger."""
RESPONSE = 0.8
"""Mean likelihood that the submap must reach."""
RIVAL = 0.85
"""No other place may reach this part of it."""
LEAST_KEYFRAMES, LEAST_SHARE = 8, 0.95
"""So many must be confirmed, and this share of those that can see anything of the other part."""
CONTRADICTED = (0.12, 0.05)
"""Share of what a keyframe and the other part see of each other that may differ; and of what all of them see."""


@dataclass(frozen=True)
class Found:
    """Part ``moved`` has its place on another one, ``stays``: it must move by ``correction`` (3,)."""

    moved: int
    stays: int
    correction: np.ndarray
    closures: list[Closure]


class Parts:
    """Which part each keyframe belongs to, ``of`` (K,), named by the first keyframe of the part."""

    def __init__(self, keyframes: Keyframes, settings: Slam) -> None:
        self.keyframes, self.settings = keyframes, settings
        self.of = np.zeros(0, np.int64)
        self._way, self._next = 0.0, SPREAD

    def advance(self, broken: bool) -> None:
        """The newest keyframe has come; after a break it begins a part."""
        k = len(self.of)
        self.of = np.append(self.of, k if broken or not k else self.of[-1])
        if broken:
            self._way, self._next = 0.0, SPREAD
            self.keyframes.since = k
        elif k:
            poses = self.keyframes.poses
            self._way += float(np.hypot(*(poses[k] - poses[k - 1])[:2]))

    def many(self) -> bool:
        """Whether there is more than one."""
        return bool((self.of != self.of[0]).any())

    def seek(self) -> Found | None:
        """Where the newest keyframes are on another part, when it is time to ask."""
        if self._way < self._next or not self.many():
            return None
        self._next = max(self._way + AGAIN[0], self._way * AGAIN[1])
        return self.seek_at(len(self.of) - 1)

    def seek_all(self) -> Found | None:
        """Where any part is on another, sought from places all along it."""
        for part in np.unique(self.of)[::-1]:
            own = np.flatnonzero(self.of == part)
            for k in own[::-1][:: max(SUBMAP // 4, len(own) // 8)]:
                found = self.seek_at(int(k))
                if found is not None:
                    return found
        return None

    def seek_at(self, k: int) -> Found | None:
        """Where keyframe k and those before it are on a larger part; None if nowhere, or at two places.

        In a smaller part there is too little for rivals to show.
        """
        part = int(self.of[k])
        sizes = np.bincount(self.of)
        own = np.flatnonzero(self.of[: k + 1] == part)[-SUBMAP:]
        if len(own) < LEAST_KEYFRAMES:
            return None
        found = []
        for other in np.flatnonzero(sizes >= sizes[part]).tolist():
            if other == part:
                continue
            closures = self._closures(own, np.flatnonzero(self.of == other))
            if closures:
                found.append((other, closures))
        if len(found) != 1:
            return None
        other, closures = found[0]
        correction = closures[-1].correction
        if part < other:
            return Found(other, part, se2.invert(correction), closures)
        return Found(part, other, correction, closures)

    def join(self, found: Found) -> None:
        """The two are one from now on."""
        self.of[self.of == found.moved] = found.stays

    def meet(self, a: int, b: int) -> None:
        """Two keyframes have been linked: their parts are one, if they were two."""
        first, second = sorted((self.of[a], self.of[b]))
        self.of[self.of == second] = first

    def _closures(self, own: np.ndarray, old: np.ndarray) -> list[Closure]:
        """Where keyframes ``own`` are on the map of ``old``, if most of them fit at one place and nowhere else."""
        frames, k = self.keyframes, own[-1]
        scan = thinned(frames.points_of(own, frames.poses[k]), GRID)
        on = thinned(frames.points_of(old, np.zeros(3)), RESOLUTION)
        scan = scan[:: len(scan) // POINTS + 1]
        if len(scan) < self.settings.least_points or len(on) < self.settings.least_points:
            return []
        low, high = on.min(0), on.max(0)
        middle, half = (low + high) / 2, (high - low) / 2
        cell = RESOLUTION
        while np.prod(half / (8 * cell) + 1) * len(scan) * 100 / cell > WORK:
            cell *= 1.5
        field = likelihood_field(on, cell, 1.2 * cell)
        window = np.append(half, np.pi)
        peak = correlate(scan, field, np.append(middle, 0.0), window, RESPONSE, RIVAL)
        if peak is None:
            return []
        part = np.flatnonzero(self.of == self.of[k])
        part = np.union1d(own, part[:: len(part) // SUBMAP + 1]).tolist()
        seen = [self._fit(j, chain(peak.pose, between(frames.poses[k], frames.poses[j])), old, cell) for j in part]
        tested = [c for c, counts in seen if counts.any()]
        confirmed, contradicted = np.sum([counts for _, counts in seen], 0)
        fitting = [c for c in tested if c is not None]
        if not fitting or contradicted > CONTRADICTED[1] * (confirmed + contradicted):
            return []
        same = consistent(fitting, frames.poses[k])
        enough = len(same) >= LEAST_KEYFRAMES and len(fitting) >= LEAST_SHARE * len(tested)
        at = frames.poses[[c.keyframe for c in same], :2]
        return same if enough and float(np.hypot(*np.ptp(at, axis=0))) > SPREAD else []

    def _fit(self, j: int, guess: np.ndarray, old: np.ndarray, cell: float) -> tuple[Closure | None, np.ndarray]:
        """Keyframe j on the map of those around it, if it fits; and how much they confirm and contradict, which is
        nothing where they see nothing of each other.
        """
        s, frames = self.settings, self.keyframes
        d = np.hypot(*(frames.poses[old] - guess)[:, :2].T)
        members = np.sort(old[np.argsort(d, kind="stable")[: s.local_keyframes]])
        scan, on = frames.surface(j), frames.map_of(members)
        if d.min() > s.neighbourhood or min(len(scan.points), len(on.points)) < s.least_points:
            return None, np.zeros(2)
        prior = np.diag([cell**-2.0, cell**-2.0, 400.0])
        match = register(scan, on, guess, prior, s.point_noise, s.reach)
        counts = frames.agree(scan, frames.ranges[j], match.pose, members)[:2]
        if match.share < 0.6 or counts[1] > CONTRADICTED[0] * counts.sum():
            return None, counts
        return Closure(j, members, match, se2.compose(match.pose, se2.invert(frames.poses[j]))), counts


def thinned(points: np.ndarray, side: float) -> np.ndarray:
    """One of the points (n, 2) a cell of ``side`` [m]."""
    _, first = np.unique(np.floor(points / side).astype(np.int64), axis=0, return_index=True)
    out: np.ndarray = points[np.sort(first)]
    return out
