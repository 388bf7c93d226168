"""Trajectory: where the robot was at each scan."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rgcore.evidence import Evidence
from rgcore.geometry import se2

NAMED = 5
"""Breaks that are told by number; of the others, how many."""


@dataclass(frozen=True, eq=False)
class Trajectory(Evidence):
    """One pose a scan, in the log's own order (N scans).

    stamps           (N,)   s, as in the log
    map_from_base    (N, 3) pose of the robot's centre
    base_from_laser  (3,)   mounting of the laser
    breaks           (M,)   numbers of the scans that could not be connected to the one before, ascending: where
                            they are relative to it is a guess
    healed           (H,)   the same of scans whose part was found on the rest of the map again
    jumps            (J,)   numbers of the scans where odometry jumped and the scans did not
    """

    stamps: np.ndarray
    map_from_base: np.ndarray
    base_from_laser: np.ndarray
    breaks: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    healed: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    jumps: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))

    @classmethod
    def whole(cls) -> frozenset[str]:
        return frozenset({"base_from_laser", "breaks", "healed", "jumps"})

    @property
    def map_from_laser(self) -> np.ndarray:
        """(N, 3) pose of the laser at each scan."""
        return se2.compose(self.map_from_base, self.base_from_laser)

    @property
    def notes(self) -> tuple[str, ...]:
        """What a person should know of it, a line each: breaks, those that are healed, and jumps of the odometry."""
        told = (
            (self.breaks, "could not be joined to the one before: the robot was moved, or scans are missing"),
            (self.healed, "could not be joined to the one before, but what follows was found on the map again"),
            (self.jumps, "came with a jump of the odometry, which was not believed"),
        )
        return tuple(f"{_named(scans)} {what}" for scans, what in told if len(scans))


def _named(scans: np.ndarray) -> str:
    """The first numbers of the scans, and how many more there are."""
    told, more = ", ".join(str(k) for k in scans[:NAMED]), len(scans) - NAMED
    return f"scan{'s'[: len(scans) - 1]} {told}{f' and {more} more' if more > 0 else ''}"
