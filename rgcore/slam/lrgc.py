"""LRGC: local registration and global correlation (Gutmann & Konolige, "Incremental mapping of large cyclic
environments", CIRA 1999; the paper, section IV-A).

Every scan is registered on the local map, which the keyframes around it make; keyframes are linked in a pose graph;
loops are closed by global correlation, and sought once more at the end, when all keyframes are aligned together.
"""

from __future__ import annotations

import numpy as np

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.progress import Progress, Watcher, silent
from rgcore.scans.log import ScanLog
from rgcore.slam.doubt import Doubt
from rgcore.slam.keyframes import Keyframes, links_of
from rgcore.slam.local import LocalMap, Match, covariance, unmatched
from rgcore.slam.loops import Loops
from rgcore.slam.motion import Motion
from rgcore.slam.parts import Found, Parts
from rgcore.slam.posegraph import Links, optimise, tension
from rgcore.slam.refine import refine
from rgcore.slam.small import between, chain
from rgcore.slam.surface import Surface, surface
from rgcore.slam.tracking import Step, track
from rgcore.slam.trajectory import Trajectory

SHOW_EVERY = 50
"""Scans between two pictures for the watcher."""
STARTLING = 5.0
"""[m] odometry that changes its mind by more from one scan to the next is compared with a steady motion."""
IMPOSSIBLE = 10.0
"""[m] odometry of a longer step is not believed where there is any other answer."""
WIDEST = np.array([1.5, 1.5, 1.0])
"""[m, m, rad] deviation of odometry beyond which nothing is sought."""
GAP = (0.6, 0.6)
"""[m, rad] a break in a longer step may be one for want of overlap alone: odometry still says about where to look."""
PATIENT, PATIENCE = 2, (0.5, 0.5)
"""Scans in a row that wait to be placed, over so much way and turn [m, rad], before a break is told."""
BREAK_SCALE = 1.0
"""Chi squared at which what odometry says of a break begins to lose its weight: at once."""


def lrgc(log: ScanLog, settings: Slam, watch: Watcher = silent) -> Trajectory:
    """Consistent poses of all scans of a log; the first is where its odometry says.

    ``watch`` is told Progress("slam", k, N, map_from_laser (k, 3) of the scans so far).
    """
    mapper = Lrgc(log.bearings, settings, log.has_odometry)
    odom_from_laser = log.odom_from_laser
    for k in range(len(log)):
        mapper.add(log.ranges[k], odom_from_laser[k])
        if (k + 1) % SHOW_EVERY == 0:
            watch(Progress("slam", k + 1, len(log), mapper.poses()))
    map_from_base = se2.compose(mapper.finish(), se2.invert(log.base_from_laser))
    told = (np.array(scans, np.int64) for scans in (mapper.breaks, mapper.healed, mapper.jumps))
    return Trajectory(log.stamps, map_from_base, log.base_from_laser, *told)


class Lrgc:
    """The estimator, one scan at a time.

    ``add`` gives the pose of a scan in the map that is known so far, ``poses`` those of all scans so far, ``finish``
    the final ones. ``breaks`` are the scans that could not be connected to the one before.
    """

    def __init__(self, bearings: np.ndarray, settings: Slam, has_odometry: bool = True) -> None:
        self.bearings, self.settings, self.has_odometry = np.array(bearings, float), settings, has_odometry
        self.keyframes = Keyframes(self.bearings)
        self.loops = Loops(self.keyframes, settings)
        self.parts = Parts(self.keyframes, settings)
        self.doubt = Doubt(self.keyframes)
        self.motion = Motion(settings.odometry_noise)
        self.breaks: list[int] = []
        self.healed: list[int] = []
        self.jumps: list[int] = []
        self._links = [Links.none()]
        self._odometry_links: list[Links] = []
        self._odometry = np.zeros(3)  # odom_from_laser of the last scan
        self._since = np.zeros(3)  # its motion since the last keyframe, by odometry
        self._step = np.zeros(3)  # the same since the scan before
        self._moved = np.zeros(3)  # its motion since the scan before, as estimated
        self._anchor: list[int] = []  # keyframe that the pose of a scan is kept relative to
        self._offset: list[np.ndarray] = []  # keyframe_from_laser of a scan
        self._members = np.zeros(0, np.int64)
        self._lost: list[tuple[Surface, np.ndarray, np.ndarray]] = []  # scans that wait: surface, ranges, odometry
        self._map: LocalMap | None = None
        self.match: Match | None = None
        """the last scan on the local map"""

    def __len__(self) -> int:
        return len(self._anchor)

    def poses(self) -> np.ndarray:
        """(N, 3) map_from_laser of the scans so far."""
        if not self._anchor:
            return np.zeros((0, 3))
        return se2.compose(self.keyframes.poses[np.array(self._anchor)], np.array(self._offset))

    def add(self, ranges: np.ndarray, odom_from_laser: np.ndarray) -> np.ndarray:
        """map_from_laser (3,) of the next scan, of ``ranges`` (B,), where odometry says ``odom_from_laser`` (3,)."""
        s = self.settings
        ranges = np.array(ranges, float)  # kernels are compiled for writable arrays only
        scan = surface(ranges, self.bearings, s.max_range, s.spacing)
        odometry = np.array(odom_from_laser, float)
        if self._map is None:
            self._odometry = odometry
            self._anchor.append(0)
            self._offset.append(np.zeros(3))
            self.keyframes.add(odometry, scan, ranges, 0)
            self.loops.advance(False, False)
            self.parts.advance(False)
            self._renew_map()
            return odometry
        return self._place(scan, ranges, odometry, True)

    def _place(self, scan: Surface, ranges: np.ndarray, odometry: np.ndarray, patient: bool) -> np.ndarray:
        """The pose (3,) of the next scan; if it cannot be told, and ``patient``, it waits for those that follow."""
        assert self._map is not None
        s, waiting, since = self.settings, len(self._lost), self._since
        last = chain(self.keyframes.poses[self._anchor[-1 - waiting]], self._offset[-1 - waiting])
        self._step = step = between(self._odometry, odometry)
        match, sure = self._track(scan, ranges, last, step)
        moved, newest = between(last, match.pose), len(self.keyframes) - 1
        offset = between(self.keyframes.poses[newest], match.pose)
        near = np.hypot(offset[0], offset[1]) < s.keyframe_distance and abs(offset[2]) < s.keyframe_angle
        if self.doubt.worth_a_look(match.share) or not near or waiting:
            off = between(step, moved) / self.motion.deviation(step)
            sure = sure and not (self.has_odometry and self.doubt.startling(scan, ranges, match.pose, off))
            sure = sure and not (waiting and self.doubt.unclear(scan, ranges, match.pose, off))
        if not sure and patient and self._may_wait(step):
            guess = chain(last, step)
            self._since, self.match = since, unmatched(self._map, guess)
            self._lost.append((scan, ranges, odometry))
            self._keep(newest, between(self.keyframes.poses[newest], guess))
            return guess
        if not sure and waiting:
            self._since = since
            return self._give_up((scan, ranges, odometry))
        if sure and self.has_odometry:
            self.motion.learn(moved, step, self._moved, self._seen(match, last[2]))
        self._odometry, self._moved, self.match, self._lost = odometry, moved / (1 + waiting), match, []
        if sure and near:
            self._keep(newest, offset)
            return match.pose
        if sure:
            self.doubt.learn(scan, ranges, match.pose)
        self._keep(newest + 1, np.zeros(3))
        self.keyframes.add(match.pose, scan, ranges, len(self) - 1)
        self._link(match, sure)
        return np.array(self.keyframes.poses[-1])

    def _keep(self, anchor: int, offset: np.ndarray) -> None:
        """The pose of the next scan is ``offset`` (3,) from keyframe ``anchor``."""
        self._anchor.append(anchor)
        self._offset.append(offset)

    def _may_wait(self, step: np.ndarray) -> bool:
        """Whether a scan that cannot be placed may wait for the next: somebody may have passed right before the laser,
        and the robot has hardly moved ``step`` (3,) since.
        """
        small = bool(np.hypot(step[0], step[1]) < PATIENCE[0] and abs(step[2]) < PATIENCE[1])
        return small and self.has_odometry and len(self._lost) < PATIENT

    def _give_up(self, *more: tuple[Surface, np.ndarray, np.ndarray]) -> np.ndarray:
        """The scans that waited, and ``more``, begin a new part; the pose of the last."""
        lost, self._lost = [*self._lost, *more], []
        del self._anchor[len(self) - len(lost) + len(more) :], self._offset[len(self._anchor) :]
        return [self._place(*scan, patient=k > 0) for k, scan in enumerate(lost)][-1]

    def _track(self, scan: Surface, ranges: np.ndarray, last: np.ndarray, moved: np.ndarray) -> tuple[Match, bool]:
        """Registers a scan, ``moved`` (3,) from ``last`` (3,) by odometry; and whether that can be believed.

        Odometry that jumps is asked last: wheels do not, but counters overflow and drivers start anew.
        """
        s = self.settings
        if not self.has_odometry:
            moved = self._moved
        if self.has_odometry and np.hypot(*(moved - self._moved)[:2]) > STARTLING:
            steady = self._registered(scan, ranges, last, self._moved, s.blind)
            impossible = float(np.hypot(moved[0], moved[1])) > IMPOSSIBLE
            asked = None if impossible else self._registered(scan, ranges, last, moved, 0.0)
            if self._fits(steady) and not (asked and self._fits(asked)):
                self.jumps.append(len(self))
                self._since = chain(self._since, between(last, steady[0].pose))
                return steady
            match, sure = asked or self._registered(scan, ranges, last, moved, 0.0)
            self._since = chain(self._since, moved)
            return match, sure and not impossible
        self._since = chain(self._since, moved)
        return self._registered(scan, ranges, last, moved, 0.0 if self.has_odometry else s.blind)

    def _registered(
        self, scan: Surface, ranges: np.ndarray, last: np.ndarray, moved: np.ndarray, blind: float
    ) -> tuple[Match, bool]:
        """A scan on the local map, ``moved`` (3,) from ``last`` (3,); and whether that can be believed."""
        assert self._map is not None
        deviation = np.minimum(self.motion.deviation(moved) + blind, WIDEST)
        step = Step(last, moved, deviation, self._moved, blind == 0.0)
        return track(self.keyframes, self._map, scan, ranges, step, self.motion, self.settings)

    def _seen(self, match: Match, heading: float) -> np.ndarray:
        """(3,) variances of what a scan shows of its pose, along and across a ``heading`` and of the turn."""
        c, h = covariance(match), np.array([np.cos(heading), np.sin(heading)])
        along = float(h @ c[:2, :2] @ h)
        return np.array([along, c[0, 0] + c[1, 1] - along, c[2, 2]])

    def _fits(self, registered: tuple[Match, bool]) -> bool:
        """Whether much of a scan has been recognised."""
        return registered[1] and registered[0].share > 0.6

    def _link(self, match: Match, sure: bool) -> None:
        """Ties the newest keyframe into the graph."""
        k = len(self.keyframes) - 1
        self._odometry_links.append(self._odometry_link(k, sure))
        self._since = np.zeros(3)
        self.loops.advance(not sure, bool(np.hypot(*self._step[:2]) > GAP[0] or abs(self._step[2]) > GAP[1]))
        self.parts.advance(not sure)
        if sure:
            self._links.append(links_of(match, self.keyframes.poses, self._members, k))
            self.loops.linked(k, self._members, match.pairs)
        else:
            self.breaks.append(len(self) - 1)
        closed = self.loops.seek()
        if closed is not None:
            self._close(closed)
        found = self.parts.seek()
        if found is not None:
            self._rejoin(found)
        self._renew_map()

    def _odometry_link(self, k: int, sure: bool) -> Links:
        """What raw odometry says of the way from the keyframe before: next to nothing if the scans contradict it."""
        deviation = self.motion.deviation(self._since) + (0.0 if self.has_odometry else self.settings.blind)
        information = np.diag(deviation**-2.0) if sure else np.eye(3)
        return Links(
            np.array([k - 1]),
            np.array([k]),
            self._since[None],
            information[None],
            np.array([9.0 if sure else BREAK_SCALE]),
        )

    def _renew_map(self) -> None:
        self._members = self.loops.local_members()
        self._map = self.keyframes.map_of(self._members)

    def _graph(self) -> Links:
        """All links so far, in one."""
        self._links = [self._links[0].plus(*self._links[1:])]
        self._odometry_links = [Links.none().plus(*self._odometry_links)]
        return self._links[0].plus(*self._odometry_links)

    def _close(self, closures: Links) -> None:
        """Closes a loop, unless the links along it would have to stretch beyond what their scans allow."""
        graph = self._graph()
        before = optimise(self.keyframes.poses, graph)
        after = optimise(before, graph.plus(closures))
        strain = tension(after, graph) - tension(before, graph)
        believed = strain < self.settings.strain
        self.keyframes.poses[:] = after if believed else before
        if believed:
            self._links.append(closures)
            self.parts.meet(int(closures.a[-1]), int(closures.b[-1]))
            self._heal()
        self.loops.closed(believed)

    def _rejoin(self, found: Found) -> bool:
        """Puts a part to its place on another one, unless that strains the graph; whether it did."""
        frames, moved = self.keyframes, self.parts.of == found.moved
        kept = frames.poses.copy()
        frames.poses[moved] = se2.compose(found.correction, kept[moved])
        links = self.loops.links(found.closures)
        graph = self._graph()
        before = optimise(kept, graph)
        after = optimise(frames.poses, graph.plus(links))  # the graph alone would take the part back
        believed = tension(after, graph) - tension(before, graph) < self.settings.strain
        frames.poses[:] = after if believed else kept
        if believed:
            self._links.append(links)
            self.parts.join(found)
            self.loops.join(found.closures)
            self._heal()
        return believed

    def _heal(self) -> None:
        """Breaks whose two sides are one part by now are healed."""
        first = np.searchsorted(self.keyframes.scans, self.breaks)
        whole = self.parts.of[first] == self.parts.of[first - 1]
        self.healed = sorted(self.healed + [b for b, ok in zip(self.breaks, whole, strict=True) if ok])
        self.breaks = [b for b, ok in zip(self.breaks, whole, strict=True) if not ok]

    def finish(self) -> np.ndarray:
        """(N, 3) map_from_laser of all scans, after the final optimisation."""
        while self._lost:
            self._give_up()
        if len(self.keyframes) > 1:
            self.keyframes.poses[:] = optimise(self.keyframes.poses, self._graph())
            while self.parts.many() and (found := self.parts.seek_all()) is not None and self._rejoin(found):
                pass
            for closures in self.loops.seek_again():
                self._close(closures)
            refine(self.keyframes, self._odometry_links[0], self.settings)
        return self.poses()
