"""Merging of segments to the lines of the map (paper, section IV-B)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.config import Lines as Settings
from rgcore.evidence import Evidence
from rgcore.scans.extract import Segments
from rgcore.slam.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Lines(Evidence):
    """Lines of the map (L lines), ordered by the scan that saw them first.

    ends       (L, 2, 2) m, map frame; free space to the left of start -> end
    moments    (L, 6)    sum_W sum_X sum_Y sum_XX sum_YY sum_XY, length-weighted (paper, section IV-B)
    support    (L,)      number of segments merged
    rms        (L,)      m, length-weighted root mean square distance of the segments' ends
    region     (L,)      index of the region whose free space the line bounds; -1 = none
    first_scan (L,)      index of the scan that saw it first
    """

    ends: np.ndarray
    moments: np.ndarray
    support: np.ndarray
    rms: np.ndarray
    region: np.ndarray
    first_scan: np.ndarray


def merge_lines(
    segments: Segments, trajectory: Trajectory, region_of_segment: np.ndarray, settings: Settings
) -> tuple[Lines, np.ndarray]:
    """Lines of the map, and for each segment (M,) the index of the line it went into (-1 = none).

    Only segments of one region (``region_of_segment`` (M,), -1 = none) and of one side merge.
    """
    raise NotImplementedError
