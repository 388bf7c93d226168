"""Following the robot: scan by scan what place it is in, while the map grows and bends.

Each scan goes into the growing raster and is asked for a gateway at the robot's sides; every few metres, and when the
robot came through an unknown gateway, a survey divides the free space anew. It runs beside, on copies, and is taken up
a fixed number of scans later: so a scan seldom waits, and the same log gives the same answers however fast it comes.
"""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np

from rgcore.config import Config
from rgcore.geometry import se2
from rgcore.places import doorway
from rgcore.places.automaton import Automaton, Event, MapBent, Passage, Pose, Sight
from rgcore.places.growing import GrowingSpace
from rgcore.places.guesses import Guesses
from rgcore.places.looks import look
from rgcore.places.places import FoundRegion
from rgcore.places.regions import describe
from rgcore.places.sofar import KnownGateway, PlacesSoFar, Seen, survey
from rgcore.scans.extract import Segments, extract_scan
from rgcore.slam.trajectory import Trajectory

EVERY, AREA = 2.0, 200.0
"""m, m2: a survey after each such way; in maps larger than the area, of a way as much longer, for it costs as much."""

BESIDE, MEANWHILE = (3, 10), 0.5
"""Scans after which a survey is taken up, at least and at most; m: and the way after which it is in between."""

BEHIND = 0.6
"""m behind an unknown gateway at which a survey is worth while."""

SLICE = 25
"""Scans that are cast anew with each new one, after a loop has moved them."""

STRAY = (0.005, 0.001)
"""m, rad: scans that stand off by more than this from where they were cast are cast anew; doors are lost to less."""

FAR = 10.0
"""m: witnesses stand no farther off."""

Outlines = dict[int, tuple[int, FoundRegion]]
"""By number of the region: what tells its cells from others, and its outline."""


class Follower:
    """``add`` takes a scan and its pose, ``bend`` new poses of all so far; ``automaton`` says where the robot is."""

    def __init__(self, bearings: np.ndarray, base_from_laser: np.ndarray, max_range: float, config: Config) -> None:
        self.bearings, self.base_from_laser, self.config = np.asarray(bearings, float), base_from_laser, config
        self.space = GrowingSpace(bearings, max_range, config.places)
        self.places = PlacesSoFar()
        self.automaton = Automaton("r1")
        self.poses = np.zeros((256, 3))  # map_from_base; those beyond the last scan are not used
        self._cast = np.zeros((256, 3))  # map_from_laser, from where scans were cast
        self._told = np.full(256, -1, np.int64)
        self._ranges: list[np.ndarray] = []
        self._witness: list[np.ndarray] = []
        self._witness_of: list[np.ndarray] = []
        self._segments: list[Segments] = []  # of keyframes
        self._stale: deque[int] = deque()
        self._bent = 0  # scans there were when the map last bent
        self._way, self._surveyed = 0.0, -EVERY
        self._guesses = Guesses(config.places)
        self._posts = np.zeros((0, 2, 2))  # of the gateways of ``places``, where they are now
        self._gateways = 0  # numbers given
        self._looks: dict[int, np.ndarray] = {}  # chances of the classes of regions
        self._pending: tuple[int, float, Future[Any]] | None = None  # scan and way when it began
        self._beside = ThreadPoolExecutor(1, "survey")

    def __len__(self) -> int:
        return len(self._ranges)

    def add(self, ranges: np.ndarray, pose: np.ndarray, stamp: float, keyframe: bool) -> list[Event]:
        """The events of the next scan, of ``ranges`` (B,), taken at ``pose`` (3,), map_from_base."""
        k = len(self)
        moved = pose[:2] - self.poses[k - 1, :2] if k else np.zeros(2)
        self._keep(ranges, pose)
        self._way += float(np.hypot(*moved))
        self._recast()
        at: Pose = (float(pose[0]), float(pose[1]), float(pose[2]))
        told = self._take_up(k, stamp, at)
        if keyframe:
            self._bear_witness(k, ranges, extract_scan(ranges, self.bearings, self.config.extract))
        passage = self._passage(k, ranges, moved)
        sight = Sight(k, stamp, at, self._here(pose), self.places.scans, passage, self._chance())
        told += self.automaton.step(sight)
        region = self.automaton.region
        self._told[k] = -1 if region is None else int(region[1:])
        self._maybe_survey(k)
        return told

    def bend(self, poses: np.ndarray, stamp: float) -> list[Event]:
        """A loop was closed: the scans so far stand at ``poses`` (N, 3), map_from_base, now."""
        n = len(self)
        far = np.hypot(*(poses - self.poses[:n])[:, :2].T)
        self.poses[:n] = poses
        lasers = se2.compose(poses, self.base_from_laser)
        off = lasers - self._cast[:n]
        half = 0.5 * self.config.places.resolution
        stale = np.flatnonzero((np.hypot(*off[:, :2].T) > STRAY[0]) | (np.abs(se2.wrap(off[:, 2])) > STRAY[1]))
        self._stale = deque(stale.tolist())
        self._stand()
        if far.max(initial=0.0) < half:
            return []
        self._bent = n
        x, y, t = poses[-1] if n else np.zeros(3)
        moved, most = int((far > half).sum()), round(float(far.max()), 3)
        return [MapBent(scan=n, stamp=stamp, pose=(float(x), float(y), float(t)), scans=moved, distance=most)]

    def settle(self) -> None:
        """Survey all there is anew, here and now, with all scans where they stand."""
        while self._stale:
            self._recast()
        self._pending = None
        self.places = replace(self.places, found=PlacesSoFar().found, open_=np.zeros_like(self.places.open_))
        self._adopt(survey(self._seen(), self.places, self.config.places))

    def witnesses(self, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(W, 2) m the witnesses, with scans at ``poses`` (N, 3), and the number of the region of each, -1 = none."""
        number = np.full(sum(map(len, self._witness)), -1, np.int64)
        number[: len(self.places.witness)] = self.places.witness
        if not self._witness:
            return np.zeros((0, 2)), number
        return se2.transform(poses[np.concatenate(self._witness_of)], np.concatenate(self._witness)), number

    def outlines(self, before: Outlines) -> Outlines:
        """The regions by number; those of ``before`` whose cells are the same are not drawn anew."""
        labels, out = self.places.labels, {}
        corner = np.round(np.asarray(labels.origin) / labels.resolution).astype(int)
        for i in self.places.regions:
            cells = np.flatnonzero(labels.values == i)
            y, x = np.divmod(cells, labels.shape[1])
            same = hash((np.concatenate([x + corner[0], y + corner[1]])).tobytes())
            last = before.get(i)
            out[i] = last if last and last[0] == same else (same, describe(labels, i, -1, self.config.places))
        return out

    def _keep(self, ranges: np.ndarray, pose: np.ndarray) -> None:
        k = len(self)
        if k == len(self.poses):
            self.poses, self._cast = np.concatenate([self.poses] * 2), np.concatenate([self._cast] * 2)
            self._told = np.concatenate([self._told, np.full(k, -1, np.int64)])
        self.poses[k], self._cast[k] = pose, se2.compose(pose, self.base_from_laser)
        self._ranges.append(ranges)
        self.space.add(ranges[None], self._cast[k : k + 1])

    def _recast(self) -> None:
        """Move some of the scans that stand elsewhere since the map bent."""
        if not self._stale:
            return
        some = np.array([self._stale.popleft() for _ in range(min(SLICE, len(self._stale)))])
        to = se2.compose(self.poses[some], self.base_from_laser)
        self.space.move(np.array([self._ranges[i] for i in some]), self._cast[some], to)
        self._cast[some] = to

    def _bear_witness(self, k: int, ranges: np.ndarray, segments: Segments) -> None:
        """Keep some points that a keyframe sees to be free, and its segments."""
        some = slice(None, None, max(1, len(ranges) // 10))
        r, angle = ranges[some], self.bearings[some]
        ok = np.isfinite(r) & (r > 0)
        r, angle = np.minimum(r[ok], FAR), angle[ok]
        there = np.concatenate([f * r[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1) for f in (0.35, 0.75)])
        self._witness.append(se2.transform(self.base_from_laser, there))
        self._witness_of.append(np.full(len(there), k))
        self._segments.append(replace(segments, scan=np.full(len(segments), k)))

    def _here(self, pose: np.ndarray) -> str | None:
        """The region that the map so far places the robot in."""
        if not self.places.scans or self.places.scans < self._bent:
            return None
        number = int(self.places.labels.at(pose[:2], outside=-1))
        return f"r{self.places.now(number)}" if number >= 0 else None

    def _passage(self, k: int, ranges: np.ndarray, moved: np.ndarray) -> Passage | None:
        """The gateway that the robot goes through with this scan."""
        if k == 0 or not moved.any():
            return None
        start, end = self.poses[k - 1, :2], self.poses[k, :2]
        known = [*self.places.gateways, *self._guesses.standing]
        hit = np.flatnonzero(doorway.crossed(start, end, self._posts))
        if len(hit):
            gateway = known[int(hit[0])]
            x, y = self._posts[hit[0]].mean(0)
            return Passage(f"g{gateway.number}", (float(x), float(y)), gateway.found is not None)
        return self._guess(k, ranges, moved)

    def _guess(self, k: int, ranges: np.ndarray, moved: np.ndarray) -> Passage | None:
        """A gateway that this scan alone tells of."""
        ok = np.isfinite(ranges) & (ranges > 0)
        points = ranges[ok, None] * np.stack([np.cos(self.bearings[ok]), np.sin(self.bearings[ok])], 1)
        points, pose = se2.transform(self.base_from_laser, points), self.poses[k]
        there = self._guesses.beside(points, pose, moved, self._way, self.space, self._posts)
        if there is None or self._guesses.refused(there.mean(0), self.poses):
            return None
        self._gateways += 1
        local = se2.transform(se2.invert(pose), there)
        self._guesses.standing.append(KnownGateway(self._gateways, k, local, None))
        self._stand()
        x, y = there.mean(0)
        return Passage(f"g{self._gateways}", (float(x), float(y)), False)

    def _chance(self) -> np.ndarray | None:
        """(4,) what class the region looks like."""
        region = self.automaton.region
        return self._looks.get(int(region[1:])) if region is not None else None

    def _maybe_survey(self, k: int) -> None:
        """Start a survey where one is due."""
        if self._pending is not None or self._stale:
            return
        larger = max(1.0, float(self.places.open_.sum()) * self.config.places.resolution**2 / AREA)
        since = self.automaton.waiting
        unknown = since is not None and self.places.scans <= since
        if unknown:
            unknown = bool(np.hypot(*(self.poses[k] - self.poses[since])[:2]) > BEHIND)
        bent = self.places.scans < self._bent
        if not (self._way - self._surveyed >= EVERY * larger or unknown or bent):
            return
        self._surveyed = self._way
        region = self.automaton.region
        here = int(region[1:]) if region is not None else -1
        trajectory = Trajectory(np.zeros(k + 1), self.poses[: k + 1].copy(), self.base_from_laser)
        task = self._beside.submit(_survey, self._seen(), self.places, self._segments[:], trajectory, here, self.config)
        self._pending = (k, self._way, task)

    def _seen(self) -> Seen:
        n = len(self)
        poses = self.poses[:n].copy()
        guessed = tuple(self._guesses.standing)
        return Seen(self.space.free_space(), poses, self._told[:n].copy(), self.witnesses(poses)[0], guessed)

    def _take_up(self, k: int, stamp: float, pose: Pose) -> list[Event]:
        """Take up a survey that is due: events of regions that have become one."""
        if self._pending is None:
            return []
        since, way, task = self._pending
        if k < since + (BESIDE[0] if self._way >= way + MEANWHILE else BESIDE[1]):
            return []
        places, looks = task.result()
        self._pending = None
        before = self.places
        self._adopt(places)
        self._looks |= looks
        told: list[Event] = []
        for region in set(before.joined) - set(places.joined):
            self.automaton.part(f"r{region}")
        for region in sorted(set(places.joined) - set(before.joined)):
            told += self.automaton.join(k, stamp, pose, f"r{region}", f"r{places.now(region)}")
        return told

    def _adopt(self, places: PlacesSoFar) -> None:
        """Give new gateways their numbers; forget guesses that the survey knew of."""
        numbered = []
        for g in places.gateways:
            if g.number < 0:
                self._gateways += 1
                g = replace(g, number=self._gateways)
            numbered.append(g)
        self.places = replace(places, gateways=tuple(numbered))
        self._guesses.judged(places.scans, {g.number for g in numbered})
        self._stand()

    def _stand(self) -> None:
        """Where the gateways are now."""
        known = [*self.places.gateways, *self._guesses.standing]
        self._posts = np.array([g.posts(self.poses) for g in known]).reshape(-1, 2, 2)


def _survey(
    seen: Seen, before: PlacesSoFar, segments: list[Segments], trajectory: Trajectory, here: int, config: Config
) -> tuple[PlacesSoFar, dict[int, np.ndarray]]:
    """A survey, and what the region where the robot is looks like, by its number."""
    places = survey(seen, before, config.places)
    for number in (int(places.labels.at(seen.poses[-1, :2], outside=-1)), here):
        if number >= 0 and (places.labels.values == number).any():
            chance = look(places, number, segments, trajectory, config)
            return places, {} if chance is None else {number: chance}
    return places, {}
