"""Segments: the straight pieces of single scans, by split and merge (paper, section IV-A, after Gutmann 2000).

A scan is broken where neighbouring echoes lie too far apart (the adaptive breakpoint of Borges & Aldon 2004, so that
a wall seen at grazing incidence holds together), each cluster is split at its corners, corners are settled point by
point, and collinear neighbours are joined again where nothing was seen *through* the gap between them (missing
echoes, a chair leg in front of the wall). Every piece is a total least squares fit; its ends are its outermost echoes
projected on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from rgcore.config import Extract
from rgcore.evidence import Evidence
from rgcore.scans.log import ScanLog

_INCIDENCE = np.deg2rad(10.0)  # lambda of Borges & Aldon: a wall seen at less than this cannot be told from a jump
_GRAZING = np.sin(np.deg2rad(5.0))  # nowhere seen at more: a chain of mixed pixels, or of things behind one another
_LOOK_AHEAD = 3  # pieces: a wall goes on behind up to two things in front of it
_BEAMS_AT_ONCE = 400_000  # readings in one call of the kernel: bounds its buffers


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
    limits = (s.max_range, s.cluster_distance, s.point_line_distance, s.variance, s.min_length)
    numbers, indices = _split_and_merge(r, b, limits, s.min_points)
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


Limits = tuple[float, float, float, float, float]


@njit(cache=True, nogil=True)
def _split_and_merge(  # type: ignore[no-untyped-def]
    ranges: np.ndarray, bearings: np.ndarray, limits: Limits, min_points: int
):
    """All scans: (M, 5) start, end, rms and (M, 4) scan, first beam, last beam, points."""
    n_scans, n_beams = ranges.shape
    max_range, cluster_distance, max_distance, max_rms, min_length = limits
    numbers = np.zeros((n_scans * (n_beams // min_points + 1), 5))
    indices = np.zeros((len(numbers), 4), np.int64)
    cos, sin = np.cos(bearings), np.sin(bearings)
    beam = np.zeros(n_beams, np.int64)  # of each echo
    x, y = np.zeros(n_beams), np.zeros(n_beams)
    sums = np.zeros((n_beams + 1, 6))  # prefix sums: any run of echoes is fitted in constant time
    own = np.zeros((n_beams + 1, 6))  # sums of each piece
    pieces = np.zeros((n_beams + 1, 2), np.int64)  # [first, last] echo
    stack = np.zeros((n_beams + 1, 2), np.int64)
    m = 0
    for scan in range(n_scans):
        k = 0
        for j in range(n_beams):
            r = ranges[scan, j]
            if r > 0 and r < max_range:  # false for nan
                beam[k], x[k], y[k] = j, r * cos[j], r * sin[j]
                k += 1
        _prefix_sums(x, y, k, sums)
        n = 0
        start = 0
        for i in range(1, k + 1):
            if i == k or _is_break(x, y, beam, bearings, i, cluster_distance):
                n = _split(x, y, sums, start, i - 1, max_distance, max_rms, stack, pieces, n)
                start = i
        _settle_corners(x, y, sums, pieces, n)
        n = _join(ranges[scan], cos, sin, bearings, beam, x, y, sums, pieces, n, own, limits)
        for p in range(n):
            i, j = pieces[p, 0], pieces[p, 1]
            cx, cy, ux, uy, rms = _fit(own[p])
            s = (x[i] - cx) * ux + (y[i] - cy) * uy
            e = (x[j] - cx) * ux + (y[j] - cy) * uy
            if own[p, 0] < min_points or abs(e - s) < min_length or rms > max_rms:
                continue
            nearest = min(np.hypot(x[i], y[i]), np.hypot(x[j], y[j]))
            if abs(uy * cx - ux * cy) < _GRAZING * nearest:
                continue
            if (uy * cx - ux * cy > 0) != (s < e):  # the laser would lie to the right
                s, e = e, s
            numbers[m, 0], numbers[m, 1] = cx + s * ux, cy + s * uy
            numbers[m, 2], numbers[m, 3] = cx + e * ux, cy + e * uy
            numbers[m, 4] = rms
            indices[m, 0], indices[m, 1], indices[m, 2], indices[m, 3] = scan, beam[i], beam[j], int(own[p, 0])
            m += 1
    return numbers[:m].copy(), indices[:m].copy()


@njit(cache=True, nogil=True)
def _prefix_sums(x, y, k, sums):  # type: ignore[no-untyped-def]
    for i in range(k):
        sums[i + 1, 0] = i + 1
        sums[i + 1, 1] = sums[i, 1] + x[i]
        sums[i + 1, 2] = sums[i, 2] + y[i]
        sums[i + 1, 3] = sums[i, 3] + x[i] * x[i]
        sums[i + 1, 4] = sums[i, 4] + y[i] * y[i]
        sums[i + 1, 5] = sums[i, 5] + x[i] * y[i]


@njit(cache=True, nogil=True)
def _fit(sums):  # type: ignore[no-untyped-def]
    """Total least squares line of some echoes: centre, unit direction, root mean square distance."""
    n = sums[0]
    cx, cy = sums[1] / n, sums[2] / n
    xx, yy, xy = sums[3] / n - cx * cx, sums[4] / n - cy * cy, sums[5] / n - cx * cy
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    spread = np.sqrt((xx - yy) ** 2 + 4 * xy * xy)
    return cx, cy, np.cos(angle), np.sin(angle), np.sqrt(max(0.0, 0.5 * (xx + yy - spread)))


@njit(cache=True, nogil=True, inline="always")
def _is_break(x, y, beam, bearings, i, cluster_distance):  # type: ignore[no-untyped-def]
    """Do echoes i - 1 and i belong to different things? (Borges & Aldon 2004; one missing beam is forgiven.)"""
    step = abs(bearings[beam[i]] - bearings[beam[i] - 1]) * min(2, beam[i] - beam[i - 1])
    r = min(np.hypot(x[i - 1], y[i - 1]), np.hypot(x[i], y[i]))
    limit = cluster_distance
    if step < 0.5 * _INCIDENCE:
        limit = max(limit, r * np.sin(step) / np.sin(_INCIDENCE - step))
    return np.hypot(x[i] - x[i - 1], y[i] - y[i - 1]) > limit


@njit(cache=True, nogil=True)
def _split(x, y, sums, first, last, max_distance, max_rms, stack, pieces, n):  # type: ignore[no-untyped-def]
    """Split echoes first..last until each piece is straight; appends them to ``pieces``, gives the new count."""
    stack[0] = (first, last)
    top = 1
    while top > 0:
        top -= 1
        i, j = stack[top, 0], stack[top, 1]
        if j - i < 2:
            pieces[n] = (i, j)
            n += 1
            continue
        cx, cy, ux, uy, rms = _fit(sums[j + 1] - sums[i])
        worst = 0.0
        for q in range(i, j + 1):
            worst = max(worst, abs((y[q] - cy) * ux - (x[q] - cx) * uy))
        if worst <= max_distance and rms <= max_rms:
            pieces[n] = (i, j)
            n += 1
            continue
        at = _corner(x, y, i, j)
        stack[top] = (at + 1, j)
        stack[top + 1] = (i, at)
        top += 2
    return n


@njit(cache=True, nogil=True, inline="always")
def _corner(x, y, i, j):  # type: ignore[no-untyped-def]
    """The echo after which to split i..j: the one farthest from the chord."""
    dx, dy = x[j] - x[i], y[j] - y[i]
    at, far = i, -1.0
    for q in range(i + 1, j):
        d = abs((y[q] - y[i]) * dx - (x[q] - x[i]) * dy)
        if d > far:
            at, far = q, d
    return at


@njit(cache=True, nogil=True)
def _settle_corners(x, y, sums, pieces, n):  # type: ignore[no-untyped-def]
    """Hand the echoes at a common corner to the line that they lie nearer to."""
    for p in range(n - 1):
        if (
            pieces[p, 1] + 1 != pieces[p + 1, 0]
            or pieces[p, 1] - pieces[p, 0] < 2
            or pieces[p + 1, 1] - pieces[p + 1, 0] < 2
        ):
            continue
        a = _fit(sums[pieces[p, 1]] - sums[pieces[p, 0]])  # without the echo at the corner
        b = _fit(sums[pieces[p + 1, 1] + 1] - sums[pieces[p + 1, 0] + 1])
        while pieces[p, 1] - pieces[p, 0] > 1 and _distance(a, x, y, pieces[p, 1]) > _distance(b, x, y, pieces[p, 1]):
            pieces[p, 1] -= 1
            pieces[p + 1, 0] -= 1
        while pieces[p + 1, 1] - pieces[p + 1, 0] > 1 and _distance(b, x, y, pieces[p + 1, 0]) > _distance(
            a, x, y, pieces[p + 1, 0]
        ):
            pieces[p, 1] += 1
            pieces[p + 1, 0] += 1


@njit(cache=True, nogil=True, inline="always")
def _distance(line, x, y, q):  # type: ignore[no-untyped-def]
    return abs((y[q] - line[1]) * line[2] - (x[q] - line[0]) * line[3])


@njit(cache=True, nogil=True)
def _join(ranges, cos, sin, bearings, beam, x, y, sums, pieces, n, own, limits):  # type: ignore[no-untyped-def]
    """Join collinear pieces, also past a thing in front of them; fills ``own``, gives the number of pieces left."""
    k = 0
    for p in range(n):  # one or two echoes have no direction: they are what the others are joined across
        if pieces[p, 1] - pieces[p, 0] >= 2:
            pieces[k] = pieces[p]
            own[k] = sums[pieces[p, 1] + 1] - sums[pieces[p, 0]]
            k += 1
    n, p = k, 0
    while p < n:
        q = p + 1
        while q < min(n, p + 1 + _LOOK_AHEAD):
            if _is_one(ranges, cos, sin, bearings, beam, x, y, pieces[p], pieces[q], own[p], own[q], limits):
                pieces[p, 1] = pieces[q, 1]
                own[p] += own[q]
                pieces[q : n - 1] = pieces[q + 1 : n].copy()
                own[q : n - 1] = own[q + 1 : n].copy()
                n -= 1
                q = p + 1
            else:
                q += 1
        p += 1
    return n


@njit(cache=True, nogil=True)
def _is_one(ranges, cos, sin, bearings, beam, x, y, a, b, own_a, own_b, limits):  # type: ignore[no-untyped-def]
    """Are pieces a and b the same straight thing, with nothing seen through the gap between them?"""
    max_range, cluster_distance, max_distance, max_rms, _min_length = limits
    line = _fit(own_a + own_b)
    if line[4] > max_rms:
        return False
    for q in (a[0], a[1], b[0], b[1]):
        if _distance(line, x, y, q) > max_distance:
            return False
    i, j = a[1], b[0]
    gap = np.hypot(x[j] - x[i], y[j] - y[i])
    offset = line[0] * line[3] - line[1] * line[2]  # signed distance of the line from the laser
    step = abs(bearings[beam[i] + 1] - bearings[beam[i]])
    spacing = (x[i] * x[i] + y[i] * y[i]) * step / max(abs(offset), 1e-9)  # r * step / sin(incidence)
    if gap > max(cluster_distance, 2.5 * spacing):
        return False
    through = 0
    for k in range(beam[i] + 1, beam[j]):
        slant = cos[k] * line[3] - sin[k] * line[2]
        if ranges[k] < max_range and ranges[k] * abs(slant) > abs(offset) + max_distance:
            through += 1
    return through <= 1  # a single one is a mixed pixel
