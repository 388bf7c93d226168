"""How the places of an old run lie in a new one: each moves with the scans that saw it."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from rgcore.geometry import se2
from rgcore.slam.trajectory import Trajectory


class Drift:
    """Takes places of an old run to where they lie in a new one, by the scans that both hold.

    A place moves with the scans whose robot stood near it and, with ``echoes``, with those that saw something near it:
    the two sides of a wall may have been seen from corridors that moved apart.
    ``known``: whether the runs share scans; without, nothing is known. ``same_log``: both were made from one log.
    """

    NEAR = 8
    TOGETHER = 0.1
    """m: scans that move a place within this of one another say the same"""

    def __init__(
        self,
        old: Trajectory,
        new: Trajectory,
        same_log: bool = False,
        echoes: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> None:
        """``echoes``: (K, 2) [m] of the old map, and the scan (K,) of each."""
        a, b = _same_scans(old, new, same_log)
        self.known = len(a) > 0
        if not self.known:
            return
        self._from, self._to = old.map_from_base[a], new.map_from_base[b]
        anchors, self._scan = self._from[:, :2], np.arange(len(a))
        if echoes is not None and len(echoes[0]):
            row = np.full(len(old), -1)
            row[a] = np.arange(len(a))
            scan = row[echoes[1]]
            anchors = np.concatenate([anchors, echoes[0][scan >= 0]])
            self._scan = np.concatenate([self._scan, scan[scan >= 0]])
        self._tree = cKDTree(anchors)

    def points(self, points: np.ndarray) -> np.ndarray:
        """Points (K, 2) [m] of the old map in the new one."""
        points = np.asarray(points, float).reshape(-1, 2)
        if not self.known or not len(points):
            return points
        weight, near = self._near(points)
        moved = se2.transform(self._motion(near), points[:, None, :])
        weight = weight * self._agreeing(moved, weight)
        return (weight[..., None] * moved).sum(1) / weight.sum(1, keepdims=True)

    def spread(self, points: np.ndarray) -> np.ndarray:
        """(K,) how far the scans near places disagree about where these lie in the new run [m]: farthest of a third."""
        points = np.asarray(points, float).reshape(-1, 2)
        if not self.known or not len(points):
            return np.zeros(len(points))
        weight, near = self._near(points)
        moved = se2.transform(self._motion(near), points[:, None, :])
        off = np.hypot(*(moved - self.points(points)[:, None]).transpose(2, 0, 1))
        order = np.argsort(off, 1)
        before = np.cumsum(np.take_along_axis(weight, order, 1), 1) < 2 / 3
        return np.take_along_axis(off, np.take_along_axis(order, before.sum(1)[:, None], 1), 1)[:, 0]

    def _agreeing(self, moved: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """Which of the scans near each place say the same of it as most do: what went another way does not count."""
        apart = np.hypot(*(moved[:, :, None] - moved[:, None]).transpose(3, 0, 1, 2))
        best = (apart * weight[:, None]).sum(2).argmin(1)
        return np.take_along_axis(apart, best[:, None, None], 1)[:, 0] <= self.TOGETHER

    @property
    def rigid(self) -> np.ndarray:
        """(3,) the one motion ``new_from_old`` that fits all common scans best: the medians of theirs, twice."""
        fit = np.zeros(3)
        for _ in range(3):
            here = se2.transform(fit, self._from[:, :2])
            turn = float(np.median(se2.wrap(self._to[:, 2] - self._from[:, 2] - fit[2])))
            middle = here.mean(0)
            spun = se2.transform(np.array([0.0, 0.0, turn]), here - middle) + middle
            by = np.median(self._to[:, :2] - spun, axis=0)
            c = middle + by - se2.transform(np.array([0.0, 0.0, turn]), middle)
            fit = se2.compose(np.array([*c, turn]), fit)
        return fit

    def turn(self, point: np.ndarray) -> float:
        """By how much directions at a point (2,) turn [rad]."""
        if not self.known:
            return 0.0
        weight, near = self._near(np.asarray(point, float).reshape(1, 2))
        return float((weight * self._motion(near)[..., 2]).sum())

    def _near(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        distance, near = self._tree.query(points, k=min(self.NEAR, self._tree.n))
        distance, near = distance.reshape(len(points), -1), near.reshape(len(points), -1)
        weight = 1.0 / (0.5 + distance)
        return weight / weight.sum(1, keepdims=True), self._scan[near]

    def _motion(self, scans: np.ndarray) -> np.ndarray:
        """``new_from_old`` (..., 3) at scans."""
        return se2.compose(self._to[scans], se2.invert(self._from[scans]))


def _same_scans(old: Trajectory, new: Trajectory, same_log: bool) -> tuple[np.ndarray, np.ndarray]:
    """Indices of scans that both runs hold: by order where one log begins like the other, else by unique stamps."""
    n = min(len(old), len(new))
    alike = bool(n) and np.array_equal(old.stamps[:n], new.stamps[:n])
    telling = len(np.unique(old.stamps[:n])) > n / 2  # some logs carry one stamp for all scans
    if alike and (telling or (same_log and len(old) == len(new))):
        return np.arange(n), np.arange(n)
    (s, i, k), (t, j, m) = (np.unique(x.stamps, return_index=True, return_counts=True) for x in (old, new))
    s, i, t, j = s[k == 1], i[k == 1], t[m == 1], j[m == 1]
    _, a, b = np.intersect1d(s, t, assume_unique=True, return_indices=True)
    return i[a], j[b]
