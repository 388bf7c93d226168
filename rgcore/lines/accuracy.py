"""The accuracy measure: how well the lines predict the scans (paper, section IV-C)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.config import Accuracy as Settings
from rgcore.evidence import Evidence
from rgcore.geometry.raycast import cast
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Accuracy(Evidence):
    """acc(s) of every scan.

    scan      (N,) m, acc(s_i); nan where a scan has no usable reading
    readings  (N,) readings compared
    missed    (N,) readings that no line predicts
    median    (N,) m, median absolute difference of the predicted readings
    """

    scan: np.ndarray
    readings: np.ndarray
    missed: np.ndarray
    median: np.ndarray

    def of(self, scans: np.ndarray) -> float | None:
        """acc(R) [m] over some scans (mask or indices); None where there is no evidence."""
        acc = self.scan[scans]
        acc = acc[np.isfinite(acc)]
        return float(np.sqrt((acc**2).mean())) if len(acc) else None


_NOTHING = Accuracy(np.zeros(0), np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))
_READINGS_AT_ONCE = 1_000_000  # bounds the memory on long logs


def predict(ends: np.ndarray, poses: np.ndarray, bearings: np.ndarray, max_range: float) -> np.ndarray:
    """(N, B) ranges [m] that lines ``ends`` (L, 2, 2) give a laser at ``poses`` (N, 3); inf where no line is hit."""
    return cast(ends, poses, bearings, max_range)[0]


def measure_accuracy(log: ScanLog, trajectory: Trajectory, ends: np.ndarray, settings: Settings) -> Accuracy:
    """Compare every scan with its back-projection from the lines ``ends`` (L, 2, 2), map frame [m].

    ``acc(s_i)^2 = 1/N sum (d_o - d_m)^2`` over the N readings nearer than ``max_range``. As printed, "if there is no
    distance measure in the reproduced scan due to a missing line, a penalty value p is added instead"; we add p^2,
    the square of a difference p (the same number for p = 1 m, and the only one in the right unit). The paper says
    why: readings that the map does not represent shall not be overestimated, as they would be by "large (unrelated)
    distance readings". A beam that slips past the place of a missing line and hits another one far behind is such an
    unrelated reading, so a difference greater than p counts as missed too. Every reading thus costs at most p.
    A log of virtual scans (``surveyed``) measured nothing: there is no evidence in it.
    """
    if log.surveyed:
        none = np.zeros(len(log), np.int64)
        return Accuracy(np.full(len(log), np.nan), none, none, np.full(len(log), np.nan))
    poses = trajectory.map_from_laser
    step = max(1, _READINGS_AT_ONCE // max(1, len(log.bearings)))
    parts = [_measure(log[i : i + step], poses[i : i + step], ends, settings) for i in range(0, len(log), step)]
    return Accuracy(*(np.concatenate(columns) for columns in zip(*parts, strict=True))) if parts else _NOTHING


def _measure(log: ScanLog, poses: np.ndarray, ends: np.ndarray, settings: Settings) -> tuple[np.ndarray, ...]:
    """acc(s), readings, missed and median of some scans."""
    usable = log.usable(settings.max_range)
    reach = settings.max_range + settings.penalty  # a farther hit is missed in any case
    difference = np.abs(predict(ends, poses, log.bearings, reach) - np.where(usable, log.ranges, 0.0))
    missed = usable & ~(difference <= settings.penalty)
    readings = usable.sum(1)
    squares = np.where(usable, np.minimum(difference, settings.penalty), 0.0) ** 2
    acc = np.where(readings > 0, np.sqrt(squares.sum(1) / np.maximum(readings, 1)), np.nan)
    return acc, readings, missed.sum(1), _row_medians(np.where(usable & ~missed, difference, np.inf))


def _row_medians(values: np.ndarray) -> np.ndarray:
    """Medians (N,) of the finite values of each row; nan where a row has none."""
    values = np.sort(values, 1)
    count = np.isfinite(values).sum(1)
    rows = np.arange(len(values))
    low, high = values[rows, np.maximum(count - 1, 0) // 2], values[rows, np.minimum(count // 2, values.shape[1] - 1)]
    return np.where(count > 0, 0.5 * (low + high), np.nan)
