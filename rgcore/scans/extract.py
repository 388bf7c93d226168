"""Segments: the straight pieces of single scans, by split and merge (paper, section IV-A, after Gutmann 2000)."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np
from scipy.stats import chi2

from rgcore.config import Extract
from rgcore.evidence import Evidence
from rgcore.scans.log import ScanLog
from rgcore.scans.straight import split_and_merge

_BEAMS_AT_ONCE = 400_000  # readings in one call of the kernel: bounds its buffers
_SAMPLE = 120  # scans that tell the noise of a log
_WIDER = 3.3  # times the usual noise: what segments may deviate while the noise is not known
_LONG, _LONG_POINTS, _FACING = 0.5, 10, 0.5  # m, echoes, sine of the incidence: segments that tell the noise
_LEAST_LONG = 20  # segments
_QUIET = 0.2  # quantile of their noise
_BEST = 0.001  # m: no laser is better
_USUAL = 0.02  # m: up to this noise the least length stands as it is set


@dataclass(frozen=True, eq=False)
class Segments(Evidence):
    """Straight pieces of single scans, in the order of scans and beams (M segments).

    ends    (M, 2, 2) m, laser frame; the laser lies to the left of start -> end
    scan    (M,)      index of the scan
    beams   (M, 2)    first and last beam (a wall across the seam of a full circle: first > last)
    points  (M,)      number of echoes
    rms     (M,)      m, root mean square distance of the echoes from the segment
    covariance (M, 3) m2, m rad, rad2: of the middle's offset across the segment and of its direction, both to the
                      left: variance, covariance, variance; :func:`polar` has it for rho and alpha
    """

    ends: np.ndarray
    scan: np.ndarray
    beams: np.ndarray
    points: np.ndarray
    rms: np.ndarray
    covariance: np.ndarray


def extract(log: ScanLog, settings: Extract) -> Segments:
    """Segments of all scans of a log, laser frame [m]; thresholds widen where the log is noisier than usual."""
    settings = adapted(log, settings)
    step = max(1, _BEAMS_AT_ONCE // max(1, log.ranges.shape[1]))
    parts = [_extract(log.ranges[i : i + step], log.bearings, settings, i) for i in range(0, len(log), step)]
    numbers = np.concatenate([p[0] for p in parts]) if parts else np.zeros((0, 8))
    indices = np.concatenate([p[1] for p in parts]) if parts else np.zeros((0, 4), np.int64)
    return _as_segments(numbers, indices)


def extract_scan(ranges: np.ndarray, bearings: np.ndarray, settings: Extract) -> Segments:
    """Segments of one scan: ``ranges`` (B,) [m], ``bearings`` (B,) [rad]; for use online. ``scan`` is 0.

    A noisy laser needs the settings that :func:`adapted` gives from a log of it, or ``noise`` set.
    """
    return _as_segments(*_extract(np.asarray(ranges, float)[None], bearings, settings, 0))


def _extract(ranges: np.ndarray, bearings: np.ndarray, s: Extract, first: int) -> tuple[np.ndarray, np.ndarray]:
    r = np.ascontiguousarray(ranges, np.float64)
    b = np.ascontiguousarray(bearings, np.float64)
    step = float(np.median(np.abs(np.diff(b)))) if len(b) > 1 else 0.0
    ring = len(b) > 2 and abs(b[-1] - b[0]) + 1.5 * step > 2 * np.pi  # the last beam and the first are neighbours
    limits = tuple(map(float, (s.max_range, s.cluster_distance, *_thresholds(s), s.noise)))
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
        numbers[:, 5:],
    )


def polar(segments: Segments) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lines of segments in Hessian form, laser frame: rho (M,) [m], alpha (M,) [rad], covariance (M, 2, 2).

    ``x cos(alpha) + y sin(alpha) = rho``: distance of the line from the laser and direction of its foot point.
    """
    start, d = segments.ends[:, 0], segments.ends[:, 1] - segments.ends[:, 0]
    u = d / np.hypot(d[:, 0], d[:, 1])[:, None]
    rho = start[:, 0] * u[:, 1] - start[:, 1] * u[:, 0]
    along = (segments.ends.mean(1) * u).sum(1)  # from the foot point to the middle, about which the covariance is
    offset, both, turn = segments.covariance.T
    # to the left is towards the laser: rho = -offset + along * turn
    across = offset - 2 * along * both + along**2 * turn
    mixed = along * turn - both
    return rho, np.arctan2(-u[:, 0], u[:, 1]), np.stack([across, mixed, mixed, turn], 1).reshape(-1, 2, 2)


def adapted(log: ScanLog, settings: Extract) -> Extract:
    """The settings with the noise of the log's own laser, from the residuals of long segments of some scans.

    Things that are not quite straight only add to residuals, so the lower fifth of the segments tells: the noise by
    which a fifth of them would lie so low (chi squared, by their echoes). The settings as they are where the log shows
    too few long walls.
    """
    some = log[np.unique(np.linspace(0, len(log) - 1, min(len(log), _SAMPLE)).astype(int))]
    wide = msgspec.structs.replace(settings, noise=_WIDER * settings.noise, min_points=_LONG_POINTS, min_length=_LONG)
    numbers, indices = _extract(some.ranges, log.bearings, wide, 0)
    long = _as_segments(numbers, indices)
    rho, _, _ = polar(long)
    share = rho / np.hypot(*long.ends.mean(1).T)
    facing = share > _FACING
    if facing.sum() < _LEAST_LONG:
        return settings
    dof = long.points[facing] - 2
    noise = long.rms[facing] / share[facing] * np.sqrt(long.points[facing] / chi2.ppf(_QUIET, dof))
    return msgspec.structs.replace(settings, noise=max(_BEST, float(np.quantile(noise, _QUIET))))


def _thresholds(s: Extract) -> tuple[float, float, float]:
    """point_line_distance, variance and min_length, never less than the noise asks for."""
    return (
        max(s.point_line_distance, 4.0 * s.noise),
        max(s.variance, 1.5 * s.noise),
        s.min_length * max(1.0, s.noise / _USUAL),
    )
