"""What odometry is worth: how far it errs, learnt from the log itself, and whether it can be believed just now.

A prior of the next pose for the scan to be weighed against (Olson, "Real-time correlative scan matching", ICRA 2009): a
mixture of what odometry says and of a motion as steady as the last one, for wheels that slip or count backwards. How
far odometry errs is a quantile of what the scans said of it before, where they could say anything; how likely it lies
goes by whether it just did.
"""

from __future__ import annotations

import math

import numpy as np

from rgcore.geometry.compiled import kernel
from rgcore.slam.small import between

LIES = 0.01
"""Share of steps whose odometry is wrong by any amount."""
STILL_LIES = 0.9
"""Share of those that follow one."""
ANYWHERE = 1e-6
"""Density of a motion that neither foretold, where that at the odometry's own is 1."""
STEADY = 0.1
"""Deviation [m, rad] of a motion from the one before, beside that by its size."""
WITHIN, QUANTILE = 0.68, 3.5
"""Share of three standard normal deviates whose sum of squares is less than that."""
LEARNS = 0.06
"""Change of the logarithm of the scale by one step that is wider than that quantile."""
SCALES = (1.0, 4.0)
"""The noise in the settings is not off by more than these factors."""
MOVES = (0.03, 0.03)
"""[m, rad] less motion says nothing of odometry."""


def motion_deviation(moved: np.ndarray, noise: float) -> np.ndarray:
    """(3,) standard deviations [m, m, rad] of odometry that tells of a motion ``moved`` (3,)."""
    way, turn = math.hypot(moved[0], moved[1]), abs(moved[2])
    return np.array([0.02 + noise * way, 0.02 + noise * way, 0.01 + noise * (turn + 0.2 * way)])


class Motion:
    """The prior of the next motion; ``scale`` times the noise in the settings is what this log's odometry shows."""

    def __init__(self, noise: float) -> None:
        self.noise = noise
        self.scale = 1.0
        self.lying = LIES

    def deviation(self, moved: np.ndarray) -> np.ndarray:
        """(3,) standard deviations of odometry that tells of a motion ``moved`` (3,)."""
        return self.scale * motion_deviation(moved, self.noise)

    def surprise(self, moved: np.ndarray, told: np.ndarray, steady: np.ndarray) -> float:
        """Minus the logarithm of the density of a motion ``moved`` (3,), where odometry has ``told`` another and the
        one before was ``steady``; 0 where it is right.
        """
        true, lie = self._densities(moved, told, steady)
        return -math.log(true + lie + ANYWHERE)

    def learn(self, moved: np.ndarray, told: np.ndarray, steady: np.ndarray, seen: np.ndarray) -> None:
        """What a scan showed of a motion, with (3,) variances ``seen`` in the axes of the pose before."""
        true, lie = self._densities(moved, told, steady)
        lied = 1.0 - true / (true + lie + ANYWHERE)
        self.lying = LIES + (STILL_LIES - LIES) * lied
        if math.hypot(told[0], told[1]) < MOVES[0] and abs(told[2]) < MOVES[1]:
            return
        chi, known = _tested(between(told, moved), self.deviation(told), seen)
        if known > 1.5:
            step = LEARNS * (WITHIN if chi * 3.0 / known > QUANTILE else WITHIN - 1.0)
            self.scale = min(max(self.scale * math.exp(step), SCALES[0]), SCALES[1])

    def _densities(self, moved: np.ndarray, told: np.ndarray, steady: np.ndarray) -> tuple[float, float]:
        """Of the motion, by odometry and by steadiness, with the odds of each."""
        wide = motion_deviation(steady, self.noise) + STEADY
        densities: tuple[float, float] = _densities(
            between(told, moved), self.deviation(told), between(steady, moved), wide, self.lying
        )
        return densities


@kernel
def _tested(off, deviation, seen):  # type: ignore[no-untyped-def]
    """Chi squared of what odometry was off by, and of how many directions (0..3) the scan could tell."""
    chi, known = 0.0, 0.0
    for i in range(3):
        variance = deviation[i] ** 2
        known += variance / (variance + seen[i])
        chi += off[i] ** 2 / (variance + seen[i])
    return chi, known


@kernel
def _densities(off, near, unsteady, wide, lying):  # type: ignore[no-untyped-def]
    """Of a motion ``off`` (3,) from what odometry told, give or take ``near`` (3,), and ``unsteady`` (3,), give or take
    ``wide`` (3,); with the odds of each.
    """
    chi, steady, ratio = 0.0, 0.0, 1.0
    for i in range(3):
        chi += (off[i] / near[i]) ** 2
        steady += (unsteady[i] / wide[i]) ** 2
        ratio *= min(1.0, near[i] / wide[i])
    return (1.0 - lying) * np.exp(-0.5 * chi), lying * ratio * np.exp(-0.5 * steady)
