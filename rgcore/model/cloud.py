"""The echoes of all scans in the map frame, thinned for the view."""

from __future__ import annotations

import numpy as np

from rgcore.geometry import se2
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

CELL = 0.04
"""m: one echo is kept of those that fall into a cell of this size, the first"""
MOST = 300_000
"""points that a browser draws without effort"""


def thinned(log: ScanLog, trajectory: Trajectory, max_range: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (K, 2) float32 [m], and the scan (K,) int32 of each, rising."""
    scan, beam = np.nonzero(log.usable(max_range))
    r = log.ranges[scan, beam]
    echoes = np.stack([r * np.cos(log.bearings[beam]), r * np.sin(log.bearings[beam])], 1)
    points = se2.transform(trajectory.map_from_laser[scan], echoes)
    cells = np.floor(points / CELL).astype(np.int64)
    _, first = np.unique(cells[:, 0] * (1 << 32) + cells[:, 1], return_index=True)
    keep = np.sort(first)
    if len(keep) > MOST:
        keep = keep[np.linspace(0, len(keep) - 1, MOST).astype(np.int64)]
    return points[keep].astype(np.float32), scan[keep].astype(np.int32)
