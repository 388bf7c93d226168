"""LRGC: local registration and global correlation (Gutmann & Konolige 2000)."""

from __future__ import annotations

import numpy as np

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.progress import Progress, Watcher, silent
from rgcore.scans.log import ScanLog
from rgcore.slam.keyframes import Keyframes, links_of
from rgcore.slam.local import LocalMap, Match, register
from rgcore.slam.loops import Loops
from rgcore.slam.posegraph import Links, optimise
from rgcore.slam.refine import refine
from rgcore.slam.surface import Surface, surface
from rgcore.slam.trajectory import Trajectory

SHOW_EVERY = 25


def lrgc(log: ScanLog, settings: Slam, watch: Watcher = silent) -> Trajectory:
    """Consistent poses of all scans of a log."""
    mapper = Lrgc(log.bearings, settings, log.has_odometry)
    odom_from_laser = log.odom_from_laser
    for k in range(len(log)):
        mapper.add(log.ranges[k], odom_from_laser[k])
        if k % SHOW_EVERY == 0:
            watch(Progress("slam", k, len(log), mapper.poses()))
    map_from_laser = mapper.finish()
    map_from_base = se2.compose(map_from_laser, se2.invert(log.base_from_laser))
    return Trajectory(log.stamps, map_from_base, log.base_from_laser)


class Lrgc:
    """The estimator, one scan at a time.

    ``add`` gives the pose in the map that is known so far; ``finish`` the final poses of all scans.
    """

    def __init__(self, bearings: np.ndarray, settings: Slam, has_odometry: bool = True) -> None:
        self.bearings, self.settings, self.has_odometry = np.asarray(bearings, float), settings, has_odometry
        self.keyframes = Keyframes(settings, self.bearings)
        self.loops = Loops(self.keyframes, settings)
        self.links = Links.none()
        self._new_links: list[Links] = []
        self._surfaces: list[Surface] = []
        self._odometry: list[np.ndarray] = []
        self._anchor: list[int] = []  # keyframe that the pose of a scan is kept relative to
        self._offset: list[np.ndarray] = []  # keyframe_from_scan
        self._members = np.zeros(0, int)
        self._map: LocalMap | None = None

    def __len__(self) -> int:
        return len(self._anchor)

    def poses(self) -> np.ndarray:
        """(N, 3) map_from_laser of the scans so far."""
        if not self._anchor:
            return np.zeros((0, 3))
        return se2.compose(self.keyframes.poses[np.array(self._anchor)], np.array(self._offset))

    def add(self, ranges: np.ndarray, odom_from_laser: np.ndarray) -> np.ndarray:
        """map_from_laser (3,) of the next scan; ``odom_from_laser`` (3,) is the raw odometry there."""
        s = self.settings
        scan = surface(ranges, self.bearings, s.max_range, s.spacing)
        odometry = np.asarray(odom_from_laser, float)
        if self._map is None:
            self._remember(scan, odometry, 0, np.zeros(3))
            self._new_keyframe(ranges, odometry, None)
            return odometry
        moved = se2.relative(self._odometry[-1], odometry)
        last = se2.compose(self.keyframes.poses[self._anchor[-1]], self._offset[-1])
        match = self._track(scan, self._map, last, moved)
        newest = len(self.keyframes) - 1
        offset = se2.relative(self.keyframes.poses[newest], match.pose)
        self._remember(scan, odometry, newest, offset)
        if np.hypot(*offset[:2]) > s.keyframe_distance or abs(offset[2]) > s.keyframe_angle:
            self._anchor[-1], self._offset[-1] = newest + 1, np.zeros(3)
            self._new_keyframe(ranges, match.pose, match)
            return np.array(self.keyframes.poses[-1])
        return match.pose

    def _remember(self, scan: Surface, odometry: np.ndarray, anchor: int, offset: np.ndarray) -> None:
        self._surfaces.append(scan)
        self._odometry.append(odometry)
        self._anchor.append(anchor)
        self._offset.append(offset)

    def _track(self, scan: Surface, on: LocalMap, last: np.ndarray, moved: np.ndarray) -> Match:
        s = self.settings
        prior = np.diag(1.0 / motion_deviation(moved, s.odometry_noise) ** 2)
        return register(scan, on, se2.compose(last, moved), prior, s.point_noise, s.reach)

    def _new_keyframe(self, ranges: np.ndarray, pose: np.ndarray, match: Match | None) -> None:
        frames, k = self.keyframes, len(self.keyframes)
        frames.add(pose, self._surfaces[-1], ranges, len(self) - 1)
        self.loops.advance()
        if match is not None:
            self._new_links += [self._odometry_link(k), links_of(match, frames.poses, self._members, k)]
            self.loops.linked(self._members, match)
            closed = self.loops.seek()
            if closed is not None:
                self._new_links.append(closed)
                self._optimise()
                self.loops.closed()
        self._members = self.loops.local_members()
        self._map = frames.map_of(self._members)

    def _odometry_link(self, k: int) -> Links:
        """What raw odometry says of the way from the keyframe before."""
        scans = self.keyframes.scans
        moved = se2.relative(self._odometry[scans[k - 1]], self._odometry[scans[k]])
        information = np.diag(1.0 / motion_deviation(moved, self.settings.odometry_noise) ** 2)
        return Links(np.array([k - 1]), np.array([k]), moved[None], information[None], np.array([9.0]))

    def _optimise(self) -> None:
        self.links = self.links.plus(*self._new_links)
        self._new_links = []
        self.keyframes.poses[:] = optimise(self.keyframes.poses, self.links)

    def finish(self) -> np.ndarray:
        """(N, 3) map_from_laser of all scans, after the final optimisation."""
        self._optimise()
        refine(self.keyframes, self.links, self.settings)
        return self.poses()


def motion_deviation(moved: np.ndarray, noise: float) -> np.ndarray:
    """(3,) standard deviations of odometry that tells of a motion ``moved`` (3,)."""
    way, turn = np.hypot(moved[0], moved[1]), abs(moved[2])
    return np.array([0.02 + noise * way, 0.02 + noise * way, 0.01 + noise * (turn + 0.2 * way)])
