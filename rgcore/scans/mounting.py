"""Odometry as logs carry it: where the laser sits on the robot, and poses at the times of the scans."""

from __future__ import annotations

import numpy as np

from rgcore.geometry import se2

_SAME_PLACE = 0.02  # m and rad: poses written with few decimals still agree within this
_ON_ROBOT = 2.0  # m, farther from the robot's centre no laser is mounted


def mounting(odom_from_base: np.ndarray, odom_from_laser: np.ndarray) -> np.ndarray | None:
    """``base_from_laser (3,)`` of poses (N, 3) of robot and laser; None where the two do not move as one body."""
    offsets = se2.relative(odom_from_base, odom_from_laser)
    middle = np.median(offsets[:, :2], axis=0)
    angle = np.arctan2(np.median(np.sin(offsets[:, 2])), np.median(np.cos(offsets[:, 2])))
    pose = np.array([*middle, angle])
    off = np.abs(np.stack([*(offsets[:, :2] - middle).T, se2.wrap(offsets[:, 2] - angle)]))
    if np.hypot(*middle) > _ON_ROBOT or np.quantile(off.max(0), 0.95) > _SAME_PLACE:
        return None
    return np.where(np.abs(pose) < 1e-3, 0.0, np.round(pose, 4))


def moves(poses: np.ndarray) -> bool:
    """Whether poses (N, 3) ever change."""
    return bool(len(poses) and np.ptp(poses, axis=0).max() > 0)


def interpolate(times: np.ndarray, known_times: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Poses (N, 3) at ``times`` between the nearest of ``known (K, 3)``; held before the first and after the last."""
    order = np.argsort(known_times, kind="stable")
    t, p = known_times[order], known[order]
    columns = [np.interp(times, t, c) for c in (p[:, 0], p[:, 1], np.unwrap(p[:, 2]))]
    columns[2] = se2.wrap(columns[2])
    return np.stack(columns, 1)
