"""Segments: the straight pieces of single scans."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.config import Extract
from rgcore.evidence import Evidence
from rgcore.scans.log import ScanLog


@dataclass(frozen=True, eq=False)
class Segments(Evidence):
    """Straight pieces of single scans, in the order of scans and beams (M segments).

    ends    (M, 2, 2) m, laser frame; the laser lies to the left of start -> end
    scan    (M,)      index of the scan
    beams   (M, 2)    first and last beam
    points  (M,)      number of echoes
    rms     (M,)      m, root mean square distance of the echoes from the segment
    """

    ends: np.ndarray
    scan: np.ndarray
    beams: np.ndarray
    points: np.ndarray
    rms: np.ndarray


def extract(log: ScanLog, settings: Extract) -> Segments:
    """Segments of all scans of a log."""
    raise NotImplementedError
