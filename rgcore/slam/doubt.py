"""Doubt: a scan may fit and yet be from elsewhere, when the robot was put at a place that looks alike.

What tells is that scan and newest keyframes see through each other's walls. People and doors do that too, in some
buildings all the time; so a scan is doubted when it contradicts far more than the scans of this log have done so far,
and odometry as well.
"""

from __future__ import annotations

import numpy as np

from rgcore.slam.keyframes import Keyframes
from rgcore.slam.surface import Surface

WITNESSES = 5
"""Newest keyframes that are asked."""
LEAST_KNOWN = 15
"""Keyframes before which nobody knows what is usual."""
LEAST = 0.1
"""Share of contradicted points that is usual anywhere."""
USUAL = (0.98, 4.0)
"""So many times the share that this quantile of the keyframes stays below is far more than usual."""
SURPRISE = 3.0
"""Deviations by which odometry must be off as well: a place that looks alike lies elsewhere than it says."""
CLEAR = 0.05
"""Share of contradicted points up to which a scan is taken for the next one where those between could not be placed."""
DROP = 0.1
"""Between keyframes only scans that fit worse than the last one by this are looked at."""


class Doubt:
    """Knows what share of points scans of this log contradict."""

    def __init__(self, keyframes: Keyframes) -> None:
        self.keyframes = keyframes
        self._shares: list[float] = []
        self._bound = np.inf
        self._fit = 1.0  # of the last scan

    def worth_a_look(self, fit: float) -> bool:
        """Whether a scan that fits by this share should be compared even if it makes no keyframe."""
        drop, self._fit = self._fit - fit, fit
        return drop > DROP

    def startling(self, surface: Surface, ranges: np.ndarray, pose: np.ndarray, off: np.ndarray) -> bool:
        """Whether a scan at ``pose`` (3,), ``off`` (3,) deviations of odometry from where that says, contradicts far
        more than is usual.
        """
        return bool(np.abs(off).max() > SURPRISE and self._contradicted(surface, ranges, pose) > self._bound)

    def unclear(self, surface: Surface, ranges: np.ndarray, pose: np.ndarray, off: np.ndarray) -> bool:
        """Whether a scan at ``pose`` (3,), ``off`` (3,) deviations from where odometry says, contradicts anything."""
        return bool(np.abs(off).max() > SURPRISE or self._contradicted(surface, ranges, pose) > CLEAR)

    def learn(self, surface: Surface, ranges: np.ndarray, pose: np.ndarray) -> None:
        """A scan that is going to be a keyframe."""
        self._shares.append(self._contradicted(surface, ranges, pose))
        n = len(self._shares)
        if n >= LEAST_KNOWN and n % 5 == 0:
            self._bound = max(LEAST, USUAL[1] * float(np.quantile(self._shares, USUAL[0])))

    def _contradicted(self, surface: Surface, ranges: np.ndarray, pose: np.ndarray) -> float:
        frames = self.keyframes
        newest = np.arange(max(frames.since, len(frames) - WITNESSES), len(frames))
        confirmed, contradicted, _ = frames.agree(surface, ranges, pose, newest)
        return float(contradicted / max(1.0, confirmed + contradicted))
