"""How sure the lines of the map are: their covariance, from range noise and from what pose errors leave in the data.

The echoes of a wall are many, so their noise alone would leave a line sure to a fraction of a millimetre. But all
segments of a scan share its pose error, and scans taken near one another share most of theirs: a hundred of them are no
hundred witnesses. How much poses err, and over which way they err alike, the log tells itself: segments of one line
should agree, and the more way lies between two scans the less they do (the variogram of geostatistics, Matheron 1963).
Pose errors are taken for a sum of independent processes, white from scan to scan or correlated over some metres of way
(exp(-way / reach)), of the position across the line and of the heading; their variances fit the squared differences of
all pairs of segments best, none below zero. What remains is scaled line by line by its own residuals.

What moved together with all that was seen beside it shows nowhere: poses are registered on the very walls that they
map. Every registration adds to such a bend by the noise of the echoes, so a share of that noise is taken for it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from rgcore.geometry import se2
from rgcore.geometry import segments as geometry
from rgcore.geometry.compiled import inner, kernel
from rgcore.scans.extract import Segments
from rgcore.slam.trajectory import Trajectory

REACHES = np.array([0.0, 0.5, 5.0, 50.0])
"""m of way over which pose errors are alike; 0: each scan has its own."""
_TURN = 1.0  # m of way that a radian counts for
_LAGS = (1, 2, 4, 8, 16, 32, 64, 128, 256)  # members of a line between the two of a pair
_KNOWN = 8.0  # degrees of freedom that the whole log is worth beside the residuals of a single line
_ROUNDS = 5  # of fitting and weighing anew
_REFITS = 6  # of a line, each with the segments weighed by how far they lay off the fit before
_FAR = 9.0  # squared deviations off the fit: such a segment counts half
_CORNER = 0.08  # variances of range noise: the last echo at a corner goes to the wall that it lies nearer to
_WILD = 9.0  # times what is expected: pairs that differ more are of things that are no straight line


_BEND = np.array([0.22, 0.1])
"""m and rad by metre of noise: what the mapper's poses bend a line by. Simulated floors tell it, at 5, 12 and 30 mm."""
_MANY = 10  # echoes of the segments that tell the noise


class PoseNoise(NamedTuple):
    """Variances (K,) of the processes of ``REACHES``: position across a line [m2] and heading [rad2]."""

    across: np.ndarray
    heading: np.ndarray


class Members(NamedTuple):
    """The segments of lines, by line and then by scan (M of them).

    line     (M,)    index of the line
    scan     (M,)    index of the scan
    way      (M,)    m, driven up to the scan
    along    (M,)    m, of the segment's middle from the line's along it
    lever    (M,)    m, the same from the laser: what a heading error turns
    offset   (M,)    m, of the segment's middle from the line, to the left
    turn     (M,)    rad, of its direction from the line's
    noise    (M, 3)  its own covariance from range noise, as in Segments
    points   (M,)    number of its echoes
    """

    line: np.ndarray
    scan: np.ndarray
    way: np.ndarray
    along: np.ndarray
    lever: np.ndarray
    offset: np.ndarray
    turn: np.ndarray
    noise: np.ndarray
    points: np.ndarray


def line_covariance(
    ends: np.ndarray, line_of: np.ndarray, segments: Segments, trajectory: Trajectory, surveyed: bool = False
) -> np.ndarray:
    """(L, 3) of lines ``ends`` (L, 2, 2) as they stand, about their middles: variance of the offset across [m2],
    covariance of it with the direction [m rad], variance of the direction [rad2]; left is positive.

    ``line_of`` (M,) is the line of each segment, -1 = none. Where a line lies off the robust fit of its segments, that
    counts too: the moments of the paper weigh a segment by its length, be it a cabinet's corner beside the wall. Zero
    for lines without members. ``surveyed``: the poses are known, so that nothing bends the map.
    """
    correction, covariance = fitted(ends, line_of, segments, trajectory)
    offset, turn = correction.T
    bend, tilt = np.zeros(2) if surveyed else (echo_noise(segments) * _BEND) ** 2
    known = np.asarray(covariance[:, :1] > 0.0)
    whole = covariance + np.stack([offset * offset + bend, offset * turn, turn * turn + tilt], 1)
    return np.where(known, whole, 0.0)


def echo_noise(segments: Segments) -> float:
    """m: median deviation of the echoes across their segments, of those with many; 0 without any."""
    many = segments.points >= min(_MANY, int(segments.points.max(initial=0)))
    n = segments.points[many]
    return float(np.median(segments.rms[many] * np.sqrt(n / np.maximum(n - 2, 1)))) if len(n) else 0.0


def turned(ends: np.ndarray, correction: np.ndarray) -> np.ndarray:
    """Lines (L, 2, 2) moved to their left and turned to their left about their middle by ``correction`` (L, 2)."""
    middle, half = ends.mean(1), (ends[:, 1] - ends[:, 0]) / 2
    left = np.stack([-half[:, 1], half[:, 0]], 1)
    off = correction[:, :1] * left / np.hypot(left[:, 0], left[:, 1])[:, None]
    c, s = np.cos(correction[:, 1:]), np.sin(correction[:, 1:])
    half = c * half + s * left
    return np.stack([middle + off - half, middle + off + half], 1)


def fitted(
    ends: np.ndarray, line_of: np.ndarray, segments: Segments, trajectory: Trajectory
) -> tuple[np.ndarray, np.ndarray]:
    """Robust fit of the members of lines ``ends`` (L, 2, 2): how far it lies off them (L, 2), its covariance (L, 3).

    Each segment counts by what it is worth, range noise and pose errors considered, and next to nothing if it lies far
    off. Both about the middles of the lines: offset to the left [m] and turn to the left [rad]; variance [m2],
    covariance [m rad], variance [rad2]. Zero for lines without members.
    """
    m = members_of(ends, line_of, segments, trajectory)
    noise = pose_noise(m)
    each = (m.line, m.scan, m.way, m.along, m.lever, m.offset, m.turn, m.noise, m.points)
    fit = _fit_all(*each, *noise, REACHES, len(ends))
    return fit[:, :2], fit[:, 2:]


def members_of(ends: np.ndarray, line_of: np.ndarray, segments: Segments, trajectory: Trajectory) -> Members:
    """The segments of the lines, as they lie to them."""
    own = np.flatnonzero(line_of >= 0)
    own = own[np.lexsort((own, line_of[own]))]  # segments are in the order of scans
    line, scan = line_of[own], segments.scan[own]
    poses = trajectory.map_from_laser
    seen = geometry.transformed(poses[scan], segments.ends[own])
    middle, d = seen.mean(1), seen[:, 1] - seen[:, 0]
    axis = (ends[:, 1] - ends[:, 0]) / geometry.lengths(ends)[:, None]
    u = axis[line]
    off = middle - ends.mean(1)[line]
    step = poses[1:] - poses[:-1]
    way = np.hypot(step[:, 0], step[:, 1]) + _TURN * np.abs(se2.wrap(step[:, 2]))
    return Members(
        line,
        scan,
        np.concatenate([[0.0], np.cumsum(way)])[scan],
        (off * u).sum(1),
        ((middle - poses[scan, :2]) * u).sum(1),
        u[:, 0] * off[:, 1] - u[:, 1] * off[:, 0],
        np.arctan2(u[:, 0] * d[:, 1] - u[:, 1] * d[:, 0], (u * d).sum(1)),
        segments.covariance[own],
        segments.points[own].astype(np.float64),
    )


def pose_noise(m: Members) -> PoseNoise:
    """The pose errors that explain best how much the segments of one line differ."""
    k = len(REACHES)
    rows, values = [np.zeros((0, 2 * k))], [np.zeros(0)]
    for lag in _LAGS:
        p = _pairs(m, lag)
        for model, value, own in (
            (np.concatenate([p.apart, p.lever], 1), m.offset, p.noise[:, 0]),
            (np.concatenate([np.zeros_like(p.apart), p.apart], 1), m.turn, p.noise[:, 1]),
        ):
            rows.append(model / own[:, None])
            values.append((value[p.first] - value[p.second]) ** 2 / own - 1.0)
    return _fitted(np.concatenate(rows), np.concatenate(values))


class _Pairs(NamedTuple):
    """Pairs of segments of one line: members ``first`` and ``second`` (N,), what range noise adds to the squared
    differences of offset and turn, ``noise`` (N, 2), and what a unit of each process adds: of position to that of
    offset, of heading to that of turn, ``apart`` (N, K); of heading to that of offset, ``lever`` (N, K)."""

    first: np.ndarray
    second: np.ndarray
    noise: np.ndarray
    apart: np.ndarray
    lever: np.ndarray


def _pairs(m: Members, lag: int) -> _Pairs:
    i = np.arange(max(0, len(m.line) - lag))
    i = i[(m.line[i] == m.line[i + lag]) & (m.scan[i] != m.scan[i + lag])]
    j = i + lag
    alike = _alike(m.way[j] - m.way[i])
    a, b = m.lever[i][:, None], m.lever[j][:, None]
    noise = m.noise[i][:, [0, 2]] + m.noise[j][:, [0, 2]]
    return _Pairs(i, j, noise, 2.0 * (1.0 - alike), a * a + b * b - 2.0 * a * b * alike)


def _fitted(rows: np.ndarray, values: np.ndarray) -> PoseNoise:
    """Variances that make ``rows`` (N, 2 K) give ``values`` (N,), in units of what range noise alone would do.

    Squares scatter as much as they are large: each is weighed by what the fit before expects of it.
    """
    k = len(REACHES)
    found = np.zeros(2 * k)
    for _ in range(_ROUNDS):
        expected = 1.0 + rows @ found
        weight = (values + 1.0 < _WILD * expected) / expected if found.any() else np.ones(len(values))
        a = rows * weight[:, None]
        square = a.T @ a
        size = np.sqrt(np.maximum(np.diag(square), 1e-300))
        root = np.linalg.cholesky(square / np.outer(size, size) + 1e-9 * np.eye(2 * k))
        found = nnls(root.T, np.linalg.solve(root, a.T @ (values * weight) / size))[0] / size
    return PoseNoise(found[:k], found[k:])


def _alike(way: np.ndarray) -> np.ndarray:
    """(N, K) correlation of the pose errors of two scans with so much way between them, process by process."""
    return np.exp(-np.abs(way)[:, None] / np.maximum(REACHES, 1e-9)) * (REACHES > 0)


@kernel
def _fit_all(line, scan, way, along, lever, offset, turn, own, points, across, heading, reaches, count):  # type: ignore[no-untyped-def]
    """Correction (offset, turn) of each line to the robust fit of its members, and the covariance of that: (L, 5)."""
    out, weights = np.zeros((count, 5)), np.zeros((len(line), 3))
    robust, before = np.ones(len(line)), np.zeros((2 * len(reaches), 2))
    pose = across.sum(), heading.sum()
    start = 0
    while start < len(line):
        stop, g = start + 1, line[start]
        while stop < len(line) and line[stop] == g:
            stop += 1
        for i in range(start, stop):  # information of a segment, as if its errors were its own
            a = own[i, 0] + pose[0] + lever[i] * lever[i] * pose[1]
            b, c = own[i, 1] + lever[i] * pose[1], own[i, 2] + pose[1]
            det = a * c - b * b
            weights[i, 0], weights[i, 1], weights[i, 2] = c / det, -b / det, a / det
        for _ in range(_REFITS):
            _solve(start, stop, along, offset, turn, weights, robust, out, g)
            for i in range(start, stop):
                d, e = offset[i] - out[g, 0] - along[i] * out[g, 1], turn[i] - out[g, 1]
                w0, w1, w2 = weights[i]
                robust[i] = 1.0 / (1.0 + ((d * d * w0 + 2.0 * d * e * w1 + e * e * w2) / _FAR) ** 2)
        _errors(
            start, stop, scan, way, along, lever, own, points, weights, robust, across, heading, reaches, before, out, g
        )
        scale = _scale(
            start, stop, scan, way, along, lever, offset, turn, own, robust, across, heading, reaches, out, g
        )
        for c in range(2, 5):
            out[g, c] *= scale
        start = stop
    return out


@inner
def _solve(start, stop, along, offset, turn, weights, robust, out, g):  # type: ignore[no-untyped-def]
    """Weighted least squares of offset and turn; leaves the inverse of the information in ``out[g, 2:]``."""
    a, b, c, x, y = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(start, stop):
        t, w = along[i], robust[i]
        w0, w1, w2 = w * weights[i, 0], w * weights[i, 1], w * weights[i, 2]
        a, b, c = a + w0, b + t * w0 + w1, c + t * t * w0 + 2.0 * t * w1 + w2
        p, q = w0 * offset[i] + w1 * turn[i], w1 * offset[i] + w2 * turn[i]
        x, y = x + p, y + t * p + q
    det = a * c - b * b
    out[g, 0], out[g, 1] = (c * x - b * y) / det, (a * y - b * x) / det
    out[g, 2], out[g, 3], out[g, 4] = c / det, -b / det, a / det


@inner
def _errors(  # type: ignore[no-untyped-def]
    start, stop, scan, way, along, lever, own, points, weights, robust, across, heading, reaches, before, out, g
):
    """The covariance of the fit: every error by its weight in it, those that are alike taken together."""
    s00, s01, s11 = 0.0, 0.0, 0.0
    k = len(reaches)
    left0, left1, right0, right1 = 0.0, 0.0, 0.0, 0.0
    before[:] = 0.0  # what the scans before left, as far as their errors are still alike
    for i in range(start, stop):
        t = along[i]
        w0, w1, w2 = robust[i] * weights[i, 0], robust[i] * weights[i, 1], robust[i] * weights[i, 2]
        d0, d1, e0, e1 = w0, t * w0 + w1, w1, t * w1 + w2  # what a unit of offset and of turn adds to both sums
        v0, v1, v2 = own[i]
        s00 += d0 * d0 * v0 + 2.0 * d0 * e0 * v1 + e0 * e0 * v2
        s01 += d0 * d1 * v0 + (d0 * e1 + d1 * e0) * v1 + e0 * e1 * v2
        s11 += d1 * d1 * v0 + 2.0 * d1 * e1 * v1 + e1 * e1 * v2
        shift, tilt = (
            np.sqrt(v0 / points[i]),
            np.sqrt(3.0 * v2 / points[i]),
        )  # by an echo at the end that is a sigma off
        left0, left1 = left0 + d0 * shift + e0 * tilt, left1 + d1 * shift + e1 * tilt
        right0, right1 = right0 + d0 * shift - e0 * tilt, right1 + d1 * shift - e1 * tilt
        for q in range(2 * k):
            v = across[q] if q < k else heading[q - k]
            if v == 0.0:
                continue
            x, y = (d0, d1) if q < k else (d0 * lever[i] + e0, d1 * lever[i] + e1)
            alike = _alike_before(scan, way, i, start, reaches[q % k])
            bx, by = alike * before[q, 0], alike * before[q, 1]
            s00 += v * x * (x + 2.0 * bx)
            s01 += v * (x * y + x * by + y * bx)
            s11 += v * y * (y + 2.0 * by)
            before[q, 0], before[q, 1] = bx + x, by + y
    s00 += _CORNER * (left0 * left0 + right0 * right0)
    s01 += _CORNER * (left0 * left1 + right0 * right1)
    s11 += _CORNER * (left1 * left1 + right1 * right1)
    i00, i01, i11 = out[g, 2], out[g, 3], out[g, 4]
    h00, h01, h10, h11 = i00 * s00 + i01 * s01, i00 * s01 + i01 * s11, i01 * s00 + i11 * s01, i01 * s01 + i11 * s11
    out[g, 2], out[g, 3], out[g, 4] = h00 * i00 + h01 * i01, h00 * i01 + h01 * i11, h10 * i01 + h11 * i11


@inner
def _alike_before(scan, way, i, start, reach):  # type: ignore[no-untyped-def]
    """Correlation of a pose error of member i with that of the member before."""
    if i == start:
        return 0.0
    if scan[i] == scan[i - 1]:
        return 1.0
    return np.exp(-(way[i] - way[i - 1]) / reach) if reach > 0.0 else 0.0


@inner
def _scale(start, stop, scan, way, along, lever, offset, turn, own, robust, across, heading, reaches, out, g):  # type: ignore[no-untyped-def]
    """How much more the members of a line differ than they should: from those one after the other."""
    total, count = 0.0, 0.0
    for lag in (1, 8):
        for i in range(start + lag, stop):
            j = i - lag
            if scan[i] == scan[j]:
                continue
            d = offset[i] - offset[j] - (along[i] - along[j]) * out[g, 1]
            expected = own[i, 0] + own[j, 0]
            for q in range(len(reaches)):
                alike = np.exp(-(way[i] - way[j]) / reaches[q]) if reaches[q] > 0.0 else 0.0
                expected += 2.0 * across[q] * (1.0 - alike)
                expected += heading[q] * (lever[i] ** 2 + lever[j] ** 2 - 2.0 * lever[i] * lever[j] * alike)
            w = robust[i] * robust[j]
            total += w * d * d / expected
            count += w
    return (_KNOWN + total) / (_KNOWN + count)
