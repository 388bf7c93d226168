"""ScanLog: what a robot's log holds, whatever format it came in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.evidence import Evidence
from rgcore.geometry import se2


@dataclass(frozen=True, eq=False)
class ScanLog(Evidence):
    """All scans of one laser, in the log's own order (N scans of B beams).

    stamps          (N,)   s, as in the log: may repeat or run backwards
    ranges          (N, B) m; ``inf`` = no echo (free as far as the laser sees), ``nan`` = no information
    odom_from_base  (N, 3) raw odometry of the robot's centre when the scan was taken; zeros if the log has none
    bearings        (B,)   rad, counter-clockwise, in the laser frame (0 = straight ahead)
    base_from_laser (3,)   mounting of the laser on the robot
    max_range       m, the longest range that the laser reports as an echo
    has_odometry    False where the log carries no odometry
    surveyed        True where odom_from_base are the poses themselves: virtual scans of a map that is there already
    source          file name; sha256 of its content; format name, e.g. "carmen"
    notes           one line a quirk that the reader met ("12 ODOM lines after the last scan"), joined by newlines
    """

    stamps: np.ndarray
    ranges: np.ndarray
    odom_from_base: np.ndarray
    bearings: np.ndarray
    base_from_laser: np.ndarray
    max_range: float
    has_odometry: bool = True
    source: str = ""
    sha256: str = ""
    format: str = ""
    notes: str = ""
    surveyed: bool = False

    @classmethod
    def whole(cls) -> frozenset[str]:
        return frozenset({"bearings", "base_from_laser"})

    @property
    def odom_from_laser(self) -> np.ndarray:
        """(N, 3) raw odometry of the laser."""
        return se2.compose(self.odom_from_base, self.base_from_laser)

    def usable(self, max_range: float) -> np.ndarray:
        """(N, B) mask of readings that are an echo nearer than ``max_range`` [m]."""
        return np.isfinite(self.ranges) & (self.ranges > 0) & (self.ranges < max_range)

    def points(self, scan: int, max_range: float = np.inf) -> np.ndarray:
        """(K, 2) echoes of one scan nearer than ``max_range`` [m], laser frame, in the order of the beams."""
        r = self.ranges[scan]
        ok = np.isfinite(r) & (r > 0) & (r < max_range)
        return np.stack([r[ok] * np.cos(self.bearings[ok]), r[ok] * np.sin(self.bearings[ok])], 1)
