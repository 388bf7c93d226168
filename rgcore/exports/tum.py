"""The trajectory in TUM format: ``timestamp x y z qx qy qz qw``, a line a scan, metres, z = 0."""

from __future__ import annotations

import numpy as np

from rgcore.errors import RgError
from rgcore.exports.options import Exported, Options
from rgcore.model.records import RGMap
from rgcore.slam.trajectory import Trajectory

_LOST = ("only the trajectory: lines, regions, gateways and objects are not in this format",)


def render(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """Poses of the laser in the map, every scan in the log's own order. Raises RgError without a trajectory."""
    if trajectory is None:
        raise RgError("there is no trajectory to write; map the log again with `rgviz run`")
    x, y, theta = trajectory.map_from_laser.T
    half = theta / 2
    zero = np.zeros_like(x)
    table = np.stack([trajectory.stamps, x, y, zero, zero, zero, np.sin(half), np.cos(half)], 1) + 0.0
    row = "%.6f %.6f %.6f %.0f %.0f %.0f %.9f %.9f\n"
    return Exported("".join(row % tuple(values) for values in table.tolist()).encode(), lost=_LOST)
