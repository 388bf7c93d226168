"""Small maps of our own for a robot to find itself on, and the scans that it takes there."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from rgcore.geometry import se2
from rgcore.geometry.raycast import cast

BEARINGS = np.linspace(-np.pi / 2, np.pi / 2, 181)


def wall(*points: tuple[float, float]) -> np.ndarray:
    """Lines (k, 2, 2) from point to point; free space on their left."""
    p = np.array(points, float)
    return np.stack([p[:-1], p[1:]], 1)


def office() -> np.ndarray:
    """A hallway of 20 x 2 m along x, with two rooms above it behind doors, of different size and furniture."""
    return np.concatenate(
        [
            wall(
                (0, 0),
                (20, 0),
                (20, 2),
                (15, 2),
                (15, 2.15),
                (18, 2.15),
                (18, 7),
                (10, 7),
                (10, 2.15),
                (14, 2.15),
                (14, 2),
            ),
            wall((14, 2), (5, 2), (5, 2.15), (8, 2.15), (8, 6), (1, 6), (1, 2.15), (4, 2.15), (4, 2), (0, 2), (0, 0)),
            wall((13, 7), (13, 6.3), (11, 6.3), (11, 7)),  # a cabinet
            wall((3, 4), (3, 5), (3.6, 5), (3.6, 4), (3, 4)),  # a table
        ]
    )


def corridor(length: float = 200.0) -> np.ndarray:
    """Two endless walls 2 m apart."""
    return np.array([[[-length, 0.0], [length, 0.0]], [[length, 2.0], [-length, 2.0]]])


def scan(
    lines: np.ndarray, pose: np.ndarray, chance: np.random.Generator, noise: float = 0.012, reach: float = 30.0
) -> np.ndarray:
    """(B,) what a laser measures at a pose."""
    ranges = cast(lines, np.asarray(pose, float)[None], BEARINGS, reach)[0][0]
    return ranges + chance.normal(0, noise, len(ranges))


def drive(*stops: tuple[float, float], step: float = 0.2) -> np.ndarray:
    """(N, 3) poses on the way from stop to stop, looking ahead, turning on the spot."""
    out = []
    heading = np.arctan2(stops[1][1] - stops[0][1], stops[1][0] - stops[0][0])
    for a, b in pairwise(np.array(stops, float)):
        to = np.arctan2(*(b - a)[::-1])
        turn = float(se2.wrap(to - heading))
        out += [[*a, heading + turn * t] for t in np.linspace(0, 1, int(abs(turn) / 0.2) + 1, endpoint=False)]
        n = int(np.ceil(np.hypot(*(b - a)) / step))
        out += [[*(a + (b - a) * t), to] for t in np.linspace(0, 1, n, endpoint=False)]
        heading = to
    return np.array([*out, [*stops[-1], heading]])


def odometry(poses: np.ndarray, chance: np.random.Generator, scale: float = 1.0) -> np.ndarray:
    """(N, 3) what drifting odometry makes of the way, from a frame of its own."""
    moved = se2.relative(poses[:-1], poses[1:])
    moved[:, :2] *= scale
    moved += chance.normal(0, [0.01, 0.005, 0.01], moved.shape)
    out = [np.array([3.0, -2.0, 1.0])]
    for m in moved:
        out.append(se2.compose(out[-1], m))
    return np.array(out)
