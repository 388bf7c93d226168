"""Segments: the straight pieces of single scans, by split and merge (paper, section IV-A, after Gutmann 2000)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.config import Extract
from rgcore.evidence import Evidence
from rgcore.scans.log import ScanLog
from rgcore.scans.straight import split_and_merge

_BEAMS_AT_ONCE = 400_000  # readings in one call of the kernel: bounds its buffers


@dataclass(frozen=True, eq=False)
class Segments(Evidence):
    """Straight pieces of single scans, in the order of scans and beams (M segments).

    ends    (M, 2, 2) m, laser frame; the laser lies to the left of start -> end
    scan    (M,)      index of the scan
    beams   (M, 2)    first and last beam (a wall across the seam of a full circle: first > last)
    points  (M,)      number of echoes
    rms     (M,)      m, root mean square distance of the echoes from the segment
    """

    ends: np.ndarray
    scan: np.ndarray
    beams: np.ndarray
    points: np.ndarray
    rms: np.ndarray


def extract(log: ScanLog, settings: Extract) -> Segments:
    """Segments of all scans of a log, laser frame [m]."""
    step = max(1, _BEAMS_AT_ONCE // max(1, log.ranges.shape[1]))
    parts = [_extract(log.ranges[i : i + step], log.bearings, settings, i) for i in range(0, len(log), step)]
    numbers = np.concatenate([p[0] for p in parts]) if parts else np.zeros((0, 5))
    indices = np.concatenate([p[1] for p in parts]) if parts else np.zeros((0, 4), np.int64)
    return _as_segments(numbers, indices)


def extract_scan(ranges: np.ndarray, bearings: np.ndarray, settings: Extract) -> Segments:
    """Segments of one scan: ``ranges`` (B,) [m], ``bearings`` (B,) [rad]; for use online. ``scan`` is 0."""
    return _as_segments(*_extract(np.asarray(ranges, float)[None], bearings, settings, 0))


def _extract(ranges: np.ndarray, bearings: np.ndarray, s: Extract, first: int) -> tuple[np.ndarray, np.ndarray]:
    r = np.ascontiguousarray(ranges, np.float64)
    b = np.ascontiguousarray(bearings, np.float64)
    step = float(np.median(np.abs(np.diff(b)))) if len(b) > 1 else 0.0
    ring = len(b) > 2 and abs(b[-1] - b[0]) + 1.5 * step > 2 * np.pi  # the last beam and the first are neighbours
    limits = tuple(map(float, (s.max_range, s.cluster_distance, s.point_line_distance, s.variance, s.min_length)))
    numbers, indices = split_and_merge(r, b, step, ring, limits, s.min_points)
    indices[:, 0] += first
    return numbers, indices


def _as_segments(numbers: np.ndarray, indices: np.ndarray) -> Segments:
    return Segments(
        numbers[:, :4].reshape(-1, 2, 2),
        indices[:, 0].copy(),
        indices[:, 1:3].copy(),
        indices[:, 3].copy(),
        numbers[:, 4],
    )
