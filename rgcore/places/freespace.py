"""Free space: where the laser saw through."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.config import Places as Settings
from rgcore.evidence import Evidence
from rgcore.geometry.grid import Grid
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class FreeSpace(Evidence):
    """Counts of beams on one raster.

    hits    (H, W) beams that ended in the cell
    passes  (H, W) beams that went through it
    origin, resolution: the frame of the raster, as in Grid
    """

    hits: np.ndarray
    passes: np.ndarray
    origin: np.ndarray
    resolution: float

    @classmethod
    def whole(cls) -> frozenset[str]:
        return frozenset({"hits", "passes", "origin"})

    def grid(self, values: np.ndarray) -> Grid:
        return Grid(values, self.origin, self.resolution)


def free_space(log: ScanLog, trajectory: Trajectory, settings: Settings) -> FreeSpace:
    """Cast every beam of every scan into a raster that holds them all."""
    raise NotImplementedError
