"""Localization on a finished line map: the way of a robot, scan by scan, whether it is lost, and where it is then."""

from __future__ import annotations

from collections import deque
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rgcore.config import Localize
from rgcore.errors import RgError
from rgcore.geometry import se2
from rgcore.geometry.segments import lengths
from rgcore.model.records import RGMap
from rgcore.robot.linemap import expect, line_map
from rgcore.robot.register import Fit, View, fit, register, view
from rgcore.robot.search import APART, Ground, candidates, distinct, ground_of, surroundings, surroundings_of
from rgcore.slam.motion import motion_deviation
from rgcore.slam.small import between, chain

START_DEVIATION = (0.1, 0.1, 0.05)
"""How well a person knows a start [m, m, rad]."""
SEARCH_DEVIATION = (0.3, 0.3, 0.1)
"""How well a search knows a place [m, m, rad], along a corridor that is all alike above all."""
BLIND = 0.1
"""m, rad: deviation of a motion that is only guessed to go on as before."""
LEAP = 0.35
"""A pose farther off than odometry allows must fit better than all others around by so much."""
NOWHERE = Fit(0.0, 0.0, 0.0)
Match = tuple[np.ndarray, np.ndarray, Fit]
"""Pose (3,), covariance (3, 3) and fit of a registered scan."""


@dataclass(frozen=True)
class Estimate:
    """Where the robot is after a scan.

    pose        (3,)   map_from_laser
    covariance  (3, 3) of x, y [m] and theta [rad], map frame; long in a direction that the lines do not show
    explained   share of the scan's readings that the lines explain
    crossed     share that went through a line: a wall that is not where the map has it, or a wrong pose
    lost        True once some scans in a row did not fit, until the next start; the pose is then that of odometry
    """

    pose: np.ndarray
    covariance: np.ndarray
    explained: float
    crossed: float
    lost: bool


@dataclass(frozen=True)
class Found:
    """Where a robot may be that was anywhere: places in the order of how well its scans fit there.

    poses        (k, 3) map_from_laser at the last scan; none where the scans show nothing
    covariances  (k, 3, 3)
    quality      (k,)   mean share of explained less crossed readings, over all scans
    sure         the first place fits, and no other nearly as well; False: ambiguous or nowhere
    """

    poses: np.ndarray
    covariances: np.ndarray
    quality: np.ndarray
    sure: bool


def ends_of(lines: RGMap | np.ndarray) -> np.ndarray:
    """(L, 2, 2) of a map or of line ends. Raises RgError where there is no line to localize on."""
    if isinstance(lines, RGMap):
        ends = np.array([(line.start, line.end) for line in lines.lines.values()], float).reshape(-1, 2, 2)
    else:
        ends = np.array(lines, float).reshape(-1, 2, 2)
    if not np.isfinite(ends).all():
        raise RgError("the lines of the map have ends that are no numbers: nothing to localize on")
    ends = ends[lengths(ends) > 1e-6]
    if len(ends) == 0:
        raise RgError("the map has no lines: nothing to localize on; map a log first")
    return ends


def variances_of(lines: RGMap | np.ndarray, usual: float) -> np.ndarray:
    """(L,) m2: how far the lines of :func:`ends_of` may lie off their walls, over their length.

    By the deviations that the mapper gives them; those of ``usual`` [m] that have none: drawn or corrected by a person.
    """
    own = [v.deviation for v in lines.lines.values()] if isinstance(lines, RGMap) else [None] * len(lines)
    ends = np.array([(v.start, v.end) for v in lines.lines.values()] if isinstance(lines, RGMap) else lines, float)
    length = lengths(ends.reshape(-1, 2, 2))
    across, turn = np.array([(usual, 0.0) if d is None else d for d in own], float).reshape(-1, 2).T
    return np.asarray(across**2 + (turn * length) ** 2 / 12.0)[length > 1e-6]


class Localizer:
    """Follows a robot on the lines of a map: ``start`` (or ``find``) once, then ``add`` every scan."""

    def __init__(self, lines: RGMap | np.ndarray, bearings: ArrayLike, settings: Localize | None = None) -> None:
        """``lines``: a map, or ends (L, 2, 2) with free space on their left; ``bearings`` (B,) [rad] of the laser."""
        self.settings = settings or Localize()
        self.bearings = np.array(bearings, float)
        self.ends = ends_of(lines)
        self.lines = line_map(self.ends, self.settings.reach)
        self._line_variance = variances_of(lines, self.settings.line_noise)
        self._ground: Ground | None = None
        self._leaps = True
        self._pose, self._covariance = np.zeros(3), np.eye(3)
        self._odometry: np.ndarray | None = None
        self._moved = np.zeros(3)
        self._unbelieved = self.settings.patience  # nothing is known before the start
        self._doubtful: deque[tuple[np.ndarray, np.ndarray | None]] = deque(maxlen=self.settings.window)

    @property
    def lost(self) -> bool:
        """Whether it was never started, or lost its way since."""
        return self._unbelieved >= self.settings.patience

    def start(self, pose: ArrayLike, deviation: ArrayLike = START_DEVIATION) -> None:
        """The next scan is taken at ``pose`` (3,), map_from_laser, give or take ``deviation`` (3,) [m, m, rad]."""
        self._pose, self._covariance = np.array(pose, float), np.diag(np.asarray(deviation, float) ** 2)
        self._odometry, self._moved, self._unbelieved = None, np.zeros(3), 0
        self._doubtful.clear()

    def add(self, ranges: ArrayLike, odometry: ArrayLike | None) -> Estimate:
        """The pose at the next scan: ``ranges`` (B,) [m], nan or inf for no echo; ``odometry`` (3,) odom_from_laser.

        Without odometry (None) the robot is taken to go on as before.
        """
        scan = self._checked(np.array(ranges, float))
        where = None if odometry is None else np.array(odometry, float)
        before = self._pose
        self._predict(where)
        seen = view(scan, self.bearings, self.settings.max_range, self.settings.spacing)
        shares = self._correct(seen) if len(seen.points) > 0 else NOWHERE
        if self._unbelieved > 0:
            self._moved = np.zeros(3)
            self._doubtful.append((scan, where))
        else:
            self._moved = between(before, self._pose)
            self._doubtful.clear()
        return Estimate(self._pose.copy(), self._covariance.copy(), shares.explained, shares.crossed, self.lost)

    def recover(self) -> Found | None:
        """Where a lost robot is, by ``find`` on the scans since it lost its way; None until these are a window full."""
        if not self.lost or len(self._doubtful) < self.settings.window:
            return None
        scans, odometry = zip(*self._doubtful, strict=True)
        return self.find(np.array(scans), None if odometry[0] is None else np.array(odometry))

    def find(self, ranges: ArrayLike, odometry: ArrayLike | None) -> Found:
        """Where a robot is that may be anywhere: ``ranges`` (k, B) of scans one after the other, ``odometry`` (k, 3).

        If that is sure, the robot is started there, and ``add`` goes on with the next scan.
        """
        s = self.settings
        scans = self._checked(np.asarray(ranges, float))
        odom = None if odometry is None else np.asarray(odometry, float)
        around = surroundings(scans, odom, self.bearings, s.max_range)
        guesses, _ = candidates(around, self._searchable())
        robots = [self._follow(se2.compose(guess, around.poses[0]), scans, around.poses) for guess in guesses]
        robots.sort(key=lambda r: -r[1])
        if not robots:
            return Found(np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros(0), False)
        poses = np.array([r._pose for r, _ in robots])
        keep = distinct(poses, *APART, len(poses))
        quality = np.array([robots[k][1] for k in keep])
        sure = quality[0] >= s.least_found and (len(keep) < 2 or quality[1] < quality[0] - s.rival)
        if sure:
            best = robots[0][0]
            self._pose, self._covariance, self._unbelieved = best._pose, best._covariance, 0
            self._odometry, self._moved = None if odom is None else odom[-1].copy(), best._moved
            self._doubtful.clear()
        return Found(poses[keep], np.array([robots[k][0]._covariance for k in keep]), quality, bool(sure))

    def _follow(self, first: np.ndarray, scans: np.ndarray, way: np.ndarray) -> tuple[Localizer, float]:
        """A robot that was started at ``first`` and saw the scans along the way (k, 3), and how well they fit."""
        robot = copy(self)
        robot._doubtful, robot._leaps = deque(maxlen=1), False
        robot.start(first, SEARCH_DEVIATION)
        found = [robot.add(scan, pose) for scan, pose in zip(scans, way, strict=True)]
        return robot, float(np.mean([e.explained - e.crossed for e in found]))

    def _predict(self, odometry: np.ndarray | None) -> None:
        """Moves the pose, and widens its covariance, by what odometry says."""
        if odometry is not None and self._odometry is None:
            self._odometry = odometry
            return
        moved = self._moved if odometry is None or self._odometry is None else between(self._odometry, odometry)
        deviation = motion_deviation(moved, self.settings.odometry_noise) + (BLIND if odometry is None else 0.0)
        c, s = np.cos(self._pose[2]), np.sin(self._pose[2])
        lever = np.eye(3)
        lever[0, 2], lever[1, 2] = -s * moved[0] - c * moved[1], c * moved[0] - s * moved[1]
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        self._covariance = lever @ self._covariance @ lever.T + turn @ np.diag(deviation**2) @ turn.T
        self._pose = chain(self._pose, moved)
        self._odometry = odometry

    def _correct(self, seen: View) -> Fit:
        """Registers a scan on the lines; where it does not fit, the pose stays that of odometry.

        A leap to a place farther off is taken, but the scan counts as doubtful until the next one fits there.
        """
        near = self._match(seen, self._pose, self._covariance)
        match: Match | None = near
        shares = near[2]
        if self.lost:
            return shares
        if shares.quality >= self.settings.least_fit:
            self._unbelieved = 0
        else:
            self._unbelieved += 1
            match = self._match_widely(seen) if self._leaps else None
        if match is not None:
            self._pose, self._covariance, shares = match
        return shares

    def _match_widely(self, seen: View) -> Match | None:
        """The same, sought farther off and whichever way the robot turned; None if in vain."""
        radius = self.settings.reach + 3.0 * float(np.sqrt(np.diag(self._covariance)[:2].max()))
        guesses, _ = candidates(surroundings_of(seen), self._searchable(), (self._pose[:2], radius))
        loose = np.diag(np.square(SEARCH_DEVIATION))
        found = sorted((self._match(seen, guess, loose) for guess in guesses), key=lambda match: -match[2].quality)
        keep = distinct(np.array([match[0] for match in found]).reshape(-1, 3), *APART, 2)
        rival = max(found[keep[1]][2].quality, 0.0) if len(keep) > 1 else 0.0
        return found[0] if found and found[0][2].quality - rival >= LEAP else None

    def _checked(self, ranges: np.ndarray) -> np.ndarray:
        if ranges.shape[-1] != len(self.bearings):
            raise RgError(
                f"a scan of {ranges.shape[-1]} readings, but {len(self.bearings)} bearings: give those of this laser"
            )
        return ranges

    def _searchable(self) -> Ground:
        if self._ground is None:
            self._ground = ground_of(self.ends)
        return self._ground

    def _match(self, seen: View, guess: np.ndarray, covariance: np.ndarray) -> Match:
        """Pose, covariance and fit of a scan that is registered from a guess (3,) of a covariance (3, 3) on."""
        s = self.settings
        bearings = np.arctan2(seen.points[:, 1], seen.points[:, 0])
        _, visible = expect(self.lines, guess, bearings, s.max_range)
        prior = np.linalg.inv(covariance)
        pose, information = register(
            seen, self.lines, visible, guess, prior, s.point_noise, self._line_variance, s.reach
        )
        return pose, np.linalg.inv(information), fit(seen, self.lines, pose, s.tolerance)
