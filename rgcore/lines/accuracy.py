"""The accuracy measure: how well the lines predict the scans (paper, section IV-C)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.config import Accuracy as Settings
from rgcore.evidence import Evidence
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


def predict(ends: np.ndarray, poses: np.ndarray, bearings: np.ndarray, max_range: float) -> np.ndarray:
    """(N, B) ranges [m] that lines ``ends`` (L, 2, 2) give a laser at ``poses`` (N, 3); inf where no line is hit."""
    raise NotImplementedError


def measure_accuracy(log: ScanLog, trajectory: Trajectory, ends: np.ndarray, settings: Settings) -> Accuracy:
    """Compare every scan with its back-projection from the lines ``ends`` (L, 2, 2)."""
    raise NotImplementedError
