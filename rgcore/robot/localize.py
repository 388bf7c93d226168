"""Localization on a finished line map, scan by scan: the way of a robot from a known start, and whether it is lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rgcore.config import Localize
from rgcore.errors import RgError
from rgcore.geometry.segments import lengths
from rgcore.model.records import RGMap
from rgcore.robot.linemap import expect, line_map
from rgcore.robot.register import Fit, View, fit, register, view
from rgcore.slam.small import between, chain
from rgcore.slam.tracking import motion_deviation

START_DEVIATION = np.array([0.1, 0.1, 0.05])
"""How well a person knows a start [m, m, rad]."""


@dataclass(frozen=True)
class Estimate:
    """Where the robot is after a scan.

    pose        (3,)   map_from_laser
    covariance  (3, 3) of x, y [m] and theta [rad], map frame; long in a direction that the lines do not show
    explained   share of the scan's readings that the lines explain; 1 where it has none
    crossed     share that went through a line: a wall that is not where the map has it, or a wrong pose
    lost        True when some scans in a row did not fit: the pose is then that of odometry alone
    """

    pose: np.ndarray
    covariance: np.ndarray
    explained: float
    crossed: float
    lost: bool


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


class Localizer:
    """Follows a robot on the lines of a map: ``start`` once, then ``add`` every scan."""

    def __init__(self, lines: RGMap | np.ndarray, bearings: np.ndarray, settings: Localize | None = None) -> None:
        """``lines``: a map, or ends (L, 2, 2) with free space on their left; ``bearings`` (B,) [rad] of the laser."""
        self.settings = settings or Localize()
        self.bearings = np.array(bearings, float)
        self.lines = line_map(ends_of(lines), self.settings.reach)
        self._pose, self._covariance = np.zeros(3), np.eye(3)
        self._odometry: np.ndarray | None = None
        self._unbelieved = self.settings.patience  # nothing is known before the start

    def start(self, pose: ArrayLike, deviation: ArrayLike = START_DEVIATION) -> None:
        """The next scan is taken at ``pose`` (3,), map_from_laser, give or take ``deviation`` (3,) [m, m, rad]."""
        self._pose, self._covariance = np.array(pose, float), np.diag(np.asarray(deviation, float) ** 2)
        self._odometry, self._unbelieved = None, 0

    def add(self, ranges: ArrayLike, odometry: ArrayLike) -> Estimate:
        """The pose at the next scan: ``ranges`` (B,) [m], nan or inf for no echo; ``odometry`` (3,) odom_from_laser."""
        s = self.settings
        self._predict(np.array(odometry, float))
        seen = view(np.array(ranges, float), self.bearings, s.max_range, s.spacing)
        if len(seen.points) > 0:
            pose, covariance, shares = self._match(seen)
            self._judge(shares.explained >= s.least_explained)
            if self._unbelieved == 0:
                self._pose, self._covariance = pose, covariance
        else:
            shares = Fit(1.0, 0.0, 0.0)
        return Estimate(self._pose.copy(), self._covariance.copy(), shares.explained, shares.crossed, self.lost)

    @property
    def lost(self) -> bool:
        """Whether it was never started, or lost its way since; only ``start`` ends that."""
        return self._unbelieved >= self.settings.patience

    def _judge(self, believed: bool) -> None:
        if not self.lost:
            self._unbelieved = 0 if believed else self._unbelieved + 1

    def _predict(self, odometry: np.ndarray) -> None:
        if self._odometry is not None:
            moved = between(self._odometry, odometry)
            c, s = np.cos(self._pose[2]), np.sin(self._pose[2])
            lever = np.eye(3)
            lever[0, 2], lever[1, 2] = -s * moved[0] - c * moved[1], c * moved[0] - s * moved[1]
            turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            noise = np.diag(motion_deviation(moved, self.settings.odometry_noise) ** 2)
            self._covariance = lever @ self._covariance @ lever.T + turn @ noise @ turn.T
            self._pose = chain(self._pose, moved)
        self._odometry = odometry

    def _match(self, seen: View) -> tuple[np.ndarray, np.ndarray, Fit]:
        s = self.settings
        bearings = np.arctan2(seen.points[:, 1], seen.points[:, 0])
        _, visible = expect(self.lines, self._pose, bearings, s.max_range)
        prior = np.linalg.inv(self._covariance)
        pose, information = register(seen, self.lines, visible, self._pose, prior, s.point_noise, s.line_noise, s.reach)
        return pose, np.linalg.inv(information), fit(seen, self.lines, pose, s.tolerance)
