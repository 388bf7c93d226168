"""Small buildings and drives through them, with the truth, for the tests of the matcher."""

from __future__ import annotations

import numpy as np

from rgcore.geometry import se2
from rgcore.geometry.raycast import cast
from rgcore.scans.log import ScanLog

BEARINGS = np.deg2rad(np.arange(-90.0, 91.0))
LASER = np.array([0.15, 0.0, 0.0])


def chain(*corners: tuple[float, float]) -> np.ndarray:
    """Walls (S, 2, 2) from corner to corner."""
    p = np.array(corners, float)
    return np.stack([p[:-1], p[1:]], 1)


def ring() -> np.ndarray:
    """A corridor of 2 m around a block, with niches, so that no two of its sides look alike."""
    outer = chain(
        (0, 0), (5, 0), (5, -1), (7, -1), (7, 0), (16, 0), (16, 4), (17, 4), (17, 6), (16, 6), (16, 12), (0, 12), (0, 0)
    )
    inner = chain(
        (2, 2),
        (2, 10),
        (9, 10),
        (9, 9.4),
        (10.5, 9.4),
        (10.5, 10),
        (14, 10),
        (14, 5),
        (13.2, 5),
        (13.2, 3),
        (14, 3),
        (14, 2),
        (2, 2),
    )
    return np.concatenate([outer, inner, chain((3, 11.7), (4, 11.7), (4, 12)), chain((0.3, 7), (0.3, 8))])


def around(rounds: float, step: float = 0.2) -> np.ndarray:
    """(N, 3) base poses of a drive around the ring's corridor."""
    corners = np.array([(1.0, 1.0), (15.0, 1.0), (15.0, 11.0), (1.0, 11.0)])
    poses, way = [], 0.0
    while way < rounds * 4:
        a, b = corners[int(way) % 4], corners[(int(way) + 1) % 4]
        length = np.hypot(*(b - a))
        t, heading = way % 1.0, np.arctan2(*(b - a)[::-1])
        if t * length < 1e-9 and poses:
            poses += [np.append(a, heading - np.pi / 2 + k * np.pi / 8) for k in range(4)]
        poses.append(np.append(a + t * (b - a), heading))
        way = min(way + step / length, np.floor(way) + 1.0)
        if np.floor(way) - way > -1e-9:
            way = np.floor(way + 1e-9)
    out = np.array(poses)
    out[:, 2] = se2.wrap(out[:, 2])
    return out


def record(walls: np.ndarray, poses: np.ndarray, seed: int = 0, drift: float = 0.03, noise: float = 0.01) -> ScanLog:
    """What a robot at ``poses`` (N, 3) logs: noisy ranges, and odometry whose heading and way run off."""
    chance = np.random.default_rng(seed)
    ranges, _ = cast(walls, se2.compose(poses, LASER), BEARINGS, 30.0)
    ranges = ranges + noise * chance.normal(size=ranges.shape)
    moved = se2.relative(poses[:-1], poses[1:])
    way = np.hypot(moved[:, 0], moved[:, 1])
    moved[:, :2] *= 1.0 + drift
    moved[:, 2] += drift * (0.5 * way + chance.normal(size=len(way)) * (way + np.abs(moved[:, 2])))
    odometry = [poses[0]]
    for m in moved:
        odometry.append(se2.compose(odometry[-1], m))
    return ScanLog(0.2 * np.arange(len(poses)), ranges, np.array(odometry), BEARINGS, LASER, 30.0)


def error(poses: np.ndarray, true: np.ndarray) -> float:
    """Root mean square distance [m] of poses (N, 3) that start where the true ones do."""
    return float(np.sqrt(((poses - true)[:, :2] ** 2).sum(1).mean()))
