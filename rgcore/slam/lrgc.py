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
from rgcore.slam.keyframes import Keyframes, links_of
from rgcore.slam.local import LocalMap, Match
from rgcore.slam.loops import Loops
from rgcore.slam.posegraph import Links, optimise, tension
from rgcore.slam.refine import refine
from rgcore.slam.small import between, chain
from rgcore.slam.surface import surface
from rgcore.slam.tracking import motion_deviation, track
from rgcore.slam.trajectory import Trajectory

SHOW_EVERY = 50
"""Scans between two pictures for the watcher."""


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
    return Trajectory(log.stamps, map_from_base, log.base_from_laser, np.array(mapper.breaks, np.int64))


class Lrgc:
    """The estimator, one scan at a time.

    ``add`` gives the pose of a scan in the map that is known so far, ``poses`` those of all scans so far, ``finish``
    the final ones. ``breaks`` are the scans that could not be connected to the one before.
    """

    def __init__(self, bearings: np.ndarray, settings: Slam, has_odometry: bool = True) -> None:
        self.bearings, self.settings, self.has_odometry = np.array(bearings, float), settings, has_odometry
        self.keyframes = Keyframes(self.bearings)
        self.loops = Loops(self.keyframes, settings)
        self.breaks: list[int] = []
        self._links = [Links.none()]
        self._odometry_links: list[Links] = []
        self._odometry = np.zeros(3)  # odom_from_laser of the last scan
        self._since = np.zeros(3)  # its motion since the last keyframe, by odometry
        self._moved = np.zeros(3)  # its motion since the scan before, as estimated
        self._anchor: list[int] = []  # keyframe that the pose of a scan is kept relative to
        self._offset: list[np.ndarray] = []  # keyframe_from_laser of a scan
        self._members = np.zeros(0, np.int64)
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
            self.loops.advance(False)
            self._renew_map()
            return odometry
        moved = between(self._odometry, odometry) if self.has_odometry else self._moved
        deviation = motion_deviation(moved, s.odometry_noise) + (0.0 if self.has_odometry else s.blind)
        last = chain(self.keyframes.poses[self._anchor[-1]], self._offset[-1])
        guess = chain(last, moved)
        match, sure = track(self.keyframes, self._map, scan, ranges, guess, deviation, s, self.has_odometry)
        self._odometry, self._since, self.match = odometry, chain(self._since, moved), match
        self._moved = between(last, match.pose)
        newest = len(self.keyframes) - 1
        offset = between(self.keyframes.poses[newest], match.pose)
        self._anchor.append(newest)
        self._offset.append(offset)
        if sure and np.hypot(offset[0], offset[1]) < s.keyframe_distance and abs(offset[2]) < s.keyframe_angle:
            return match.pose
        self._anchor[-1], self._offset[-1] = newest + 1, np.zeros(3)
        self.keyframes.add(match.pose, scan, ranges, len(self) - 1)
        self._link(match, sure)
        return np.array(self.keyframes.poses[-1])

    def _link(self, match: Match, sure: bool) -> None:
        """Ties the newest keyframe into the graph."""
        k = len(self.keyframes) - 1
        self._odometry_links.append(self._odometry_link(k, sure))
        self._since = np.zeros(3)
        self.loops.advance(not sure)
        if sure:
            self._links.append(links_of(match, self.keyframes.poses, self._members, k))
            self.loops.linked(k, self._members, match.pairs)
        else:
            self.breaks.append(len(self) - 1)
        closed = self.loops.seek()
        if closed is not None:
            self._close(closed)
        self._renew_map()

    def _odometry_link(self, k: int, sure: bool) -> Links:
        """What raw odometry says of the way from the keyframe before: next to nothing if the scans contradict it."""
        deviation = motion_deviation(self._since, self.settings.odometry_noise) + (
            0.0 if self.has_odometry else self.settings.blind
        )
        information = np.diag(deviation**-2.0) if sure else np.eye(3)
        return Links(
            np.array([k - 1]), np.array([k]), self._since[None], information[None], np.array([9.0 if sure else np.inf])
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
        self.loops.closed(believed)

    def finish(self) -> np.ndarray:
        """(N, 3) map_from_laser of all scans, after the final optimisation."""
        if len(self.keyframes) > 1:
            self.keyframes.poses[:] = optimise(self.keyframes.poses, self._graph())
            for closures in self.loops.seek_again():
                self._close(closures)
            refine(self.keyframes, self._odometry_links[0], self.settings)
        return self.poses()
