"""How accurate localization on the lines is: the paper's table II."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.config import Localize
from rgcore.geometry import se2
from rgcore.model.records import RGMap
from rgcore.robot.localize import Localizer
from rgcore.scans.log import ScanLog


@dataclass(frozen=True)
class LocalizationAccuracy:
    """A row of table II: estimated poses less those of the mapping run, over all scans.

    dx, dy, dalpha  mean and standard deviation, ahead and to the left of the aligned scan [m] and turned [rad]
    d_min, d_max    m, the smallest and the largest distance between the two
    lost            scans at which the robot was lost
    scans           number of scans
    """

    dx: tuple[float, float]
    dy: tuple[float, float]
    dalpha: tuple[float, float]
    d_min: float
    d_max: float
    lost: int
    scans: int


def localization_table(
    log: ScanLog, map_from_laser: np.ndarray, lines: RGMap | np.ndarray, settings: Localize | None = None
) -> LocalizationAccuracy:
    """Drive a simulated robot along a log and localize it on the lines made of that log (paper, section V, table II).

    The start is known, the rest is odometry and matching; ``map_from_laser`` (N, 3) are the aligned poses of the
    mapping run, which stand for the truth. The paper does not say in which frame its dx and dy are: here in that of the
    aligned scan, x ahead and y to the left, since what is hard to see ahead in a corridor is easy across it.
    """
    poses, lost = follow(log, map_from_laser[0], lines, settings)
    off = se2.relative(np.asarray(map_from_laser, float), poses)
    far = np.hypot(off[:, 0], off[:, 1])
    dx, dy, dalpha = ((float(v.mean()), float(v.std())) for v in off.T)
    return LocalizationAccuracy(dx, dy, dalpha, float(far.min()), float(far.max()), int(lost.sum()), len(log))


def follow(
    log: ScanLog, start: np.ndarray, lines: RGMap | np.ndarray, settings: Localize | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Poses (N, 3), map_from_laser, of a robot tracked along a log from ``start`` (3,) on; where it is lost (N,)."""
    robot = Localizer(lines, log.bearings, settings)
    robot.start(start)
    odometry = log.odom_from_laser if log.has_odometry else [None] * len(log)
    found = [robot.add(ranges, where) for ranges, where in zip(log.ranges, odometry, strict=True)]
    return np.array([e.pose for e in found]), np.array([e.lost for e in found])
