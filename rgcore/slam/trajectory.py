"""Trajectory: where the robot was at each scan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.evidence import Evidence
from rgcore.geometry import se2


@dataclass(frozen=True, eq=False)
class Trajectory(Evidence):
    """One pose a scan, in the log's own order (N scans).

    stamps           (N,)   s, as in the log
    map_from_base    (N, 3) pose of the robot's centre
    base_from_laser  (3,)   mounting of the laser
    """

    stamps: np.ndarray
    map_from_base: np.ndarray
    base_from_laser: np.ndarray

    @classmethod
    def whole(cls) -> frozenset[str]:
        return frozenset({"base_from_laser"})

    @property
    def map_from_laser(self) -> np.ndarray:
        """(N, 3) pose of the laser at each scan."""
        return se2.compose(self.map_from_base, self.base_from_laser)
