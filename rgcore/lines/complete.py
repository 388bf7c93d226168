"""The merged lines judged by the scans: what they leave unexplained is added, what is not worth its price goes.

Merging looks at segments alone. Here the scans are predicted from the lines (paper, section IV-C) and the map is made
the one that predicts best at so many readings a line: short lines where scattered echoes show something
(:mod:`rgcore.lines.clutter`), all lines cut to the stretches that more readings agree with than contradict, and lines
dropped, the least worth first (:mod:`rgcore.lines.worth`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, replace

import numpy as np

from rgcore.config import Lines as Settings
from rgcore.geometry import se2
from rgcore.geometry import segments as geometry
from rgcore.lines.clutter import strips
from rgcore.lines.corners import close_corners
from rgcore.lines.covariance import line_covariance
from rgcore.lines.join import joined
from rgcore.lines.merge import Lines, describe, renumbered
from rgcore.lines.worth import FAR, NEAR, Sights
from rgcore.scans.extract import Segments
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

_MOST_READINGS = 300_000  # of longer logs every second, third, ... scan: as good, and bounds time and memory
_ROUNDS = 2  # what stands before something else hides it from the first
_SIZE = 0.02  # m: how finely lines are cut
_PROBES = (0.1, 0.2, 0.3)  # m before a line, where its region is looked up
_FITS = 3  # of laying a line through its echoes
_SPREAD = 0.02  # m: echoes farther off count less
_FEW = 5.0  # echoes that where a line lay already counts for
_STIFF = 0.1  # m: of shorter lines the direction is not asked of the echoes
_NOISE = 0.012  # m, of an echo
_DEAREST = 4.0  # times the price: what is worth more stays, however few segments there are


def complete_lines(
    lines: Lines,
    line_of: np.ndarray,
    log: ScanLog,
    segments: Segments,
    trajectory: Trajectory,
    region_at: Callable[[np.ndarray], np.ndarray],
    settings: Settings,
    by_region: Sequence[Settings] = (),
) -> tuple[Lines, np.ndarray]:
    """Lines of the map and the line of each segment (M,), from those that merging gave.

    ``region_at`` gives the regions (K,) of points (K, 2) in the map frame, -1 = none. A line of scattered echoes has
    as its support the scans that saw it. ``by_region``: the price for the scans taken in each region, the last for
    those taken in none; where it is half, a reading counts twice.
    """
    if len(segments) == 0:
        return lines, line_of
    weight = None
    if by_region:
        price = np.array([s.price for s in by_region])
        weight = max(settings.price, 1e-9) / np.maximum(price, 1e-9)[region_at(trajectory.map_from_base[:, :2])]
    sights, scans, step = sights_of(log, trajectory, settings.max_range, _MOST_READINGS, weight)
    most = int(len(segments) / settings.reduction)
    found, of, name = finished(sights, lines.ends, lines.region, settings.price / step, most, settings.corner)
    line_of = np.append(name, -1)[line_of]

    ends = geometry.transformed(trajectory.map_from_laser[segments.scan], segments.ends)
    merged = of < len(lines)
    part = _parts(found[merged], of[merged], line_of, ends.mean(1), settings.gap)
    line_of = np.where(part >= 0, np.append(np.flatnonzero(merged), -1)[part], -1)
    line, pieces = _pieces(sights, found, np.flatnonzero(~merged), scans, segments, trajectory)
    order = np.argsort(np.concatenate([segments.scan, pieces.scan]), kind="stable")
    members, home = _joined(segments, pieces)[order], np.append(lines.region, -1)
    home = np.where(merged, home[np.where(merged, of, -1)], regions_before(found, region_at))
    line_of = np.concatenate([line_of, line])[order]
    there = np.bincount(line_of[line_of >= 0], minlength=len(found)) > 0
    line_of = renumbered(line_of, there)
    ends = geometry.transformed(trajectory.map_from_laser[members.scan], members.ends)
    center = ends.mean((0, 1))
    region = np.append(home[there], -1)[line_of]
    out, line_of = describe(found[there] - center, line_of, ends - center, center, members.scan, region)
    out = replace(out, covariance=line_covariance(out.ends, line_of, members, trajectory, log.surveyed))
    return out, line_of[order.argsort()[: len(segments)]]


def sights_of(
    log: ScanLog, trajectory: Trajectory, max_range: float, readings: int, weight: np.ndarray | None = None
) -> tuple[Sights, np.ndarray, int]:
    """About so many ``readings`` to judge lines by, the scans (K,) that they are of, and of how many scans each is one.

    ``weight`` (N,) is that of all scans.
    """
    usable = log.usable(max_range)
    step = max(1, int(np.ceil(usable.sum() / readings)))
    scans = np.arange(0, len(log), step)
    ranges = np.where(usable[scans], log.ranges[scans], 0.0)
    some = None if weight is None else weight[scans]
    return Sights(trajectory.map_from_laser[scans], log.bearings, ranges, some), scans, step


def finished(
    sights: Sights, lines: np.ndarray, region: np.ndarray, price: float, most: int, corner: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lines (K, 2, 2) of the finished map, from those (L, 2, 2) that merging gave, and which each is of (K,).

    Numbers from L on: lines through scattered echoes. Last, what each line is of now (L or more,): some went into
    others of their ``region`` (L,). ``price`` in readings of ``sights``; ``most`` lines are aimed at.
    """
    found, there = lines, np.ones(len(lines), bool)
    sights.clear()
    sights.add(found)
    for _ in range(_ROUNDS):
        more = sights.worthy(strips(*_echoes(sights, there)), price, _SIZE)
        sights.add(more, len(found))
        found, there = np.concatenate([found, more]), np.concatenate([there, np.ones(len(more), bool)])
        there = sights.keep(there, price)
    of = np.flatnonzero(there)
    sights.clear()
    sights.add(found[of])
    found, part_of = sights.stretches(found[of], price, _SIZE)
    found, of, name = joined(sights, found, of[part_of], region, price)
    sights.clear()
    sights.add(found)
    found = close_corners(_laid(sights, found), corner)
    there = sights.few(len(found), price, most, _DEAREST * price)
    return found[there], of[there], name


def _echoes(sights: Sights, there: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(P, 2) [m] the echoes that no line explains, and (P, 2) the directions of their beams."""
    n, i = np.nonzero(sights.unexplained(there))
    angle = sights.poses[n, 2] + sights.bearings[i]
    beams = np.stack([np.cos(angle), np.sin(angle)], 1)
    return sights.poses[n, :2] + sights.ranges[n, i][:, None] * beams, beams


def _laid(sights: Sights, lines: np.ndarray) -> np.ndarray:
    """The lines (L, 2, 2) laid through all echoes that they predict: a few segments may be bent together.

    Iteratively reweighted least squares of offset and slope, weights after Cauchy; few echoes move a line little.
    """
    beam = np.flatnonzero(np.abs(sights.distance[:, 0] - sights.ranges.ravel()) < FAR)
    of, beams = sights.line[beam, 0], sights.ranges.shape[1]
    angle = sights.poses[beam // beams, 2] + sights.bearings[beam % beams]
    length = geometry.lengths(lines)
    u = (lines[:, 1] - lines[:, 0]) / length[:, None]
    behind = sights.ranges.ravel()[beam] - sights.distance[beam, 0]
    off = behind * (u[of, 0] * np.sin(angle) - u[of, 1] * np.cos(angle))
    at = sights.along[beam, 0] + behind * (u[of, 0] * np.cos(angle) + u[of, 1] * np.sin(angle))
    near = (np.abs(off) < NEAR) & (at > 0.0) & (at < length[of])
    of, off, at = of[near], off[near], (at - 0.5 * length[of])[near]
    a, b = np.zeros(len(lines)), np.zeros(len(lines))
    for _ in range(_FITS):
        w = 1.0 / (1.0 + ((off - a[of] - b[of] * at) / _SPREAD) ** 2)
        count, x, spread = (np.bincount(of, w * at**k, len(lines)) for k in range(3))
        y, xy = (np.bincount(of, w * off * at**k, len(lines)) for k in range(2))
        n, xx = count + _FEW, spread + _FEW * (length**2 / 12 + _STIFF**2)
        b = (n * xy - x * y) / (n * xx - x * x)
        a = (y - b * x) / n
    move = a[:, None] + b[:, None] * length[:, None] * [-0.5, 0.5]
    return lines + move[..., None] * np.stack([-u[:, 1], u[:, 0]], 1)[:, None]


def _parts(lines: np.ndarray, of: np.ndarray, line_of: np.ndarray, middle: np.ndarray, reach: float) -> np.ndarray:
    """(M,) which part (K, 2, 2) of its line a segment lies on: that within ``reach`` [m] of its ``middle``, or -1.

    ``of`` (K,) is ascending: the line that each part is of.
    """
    out, nearest = np.full(len(line_of), -1), np.full(len(line_of), reach)
    first, last = np.searchsorted(of, line_of, side="left"), np.searchsorted(of, line_of, side="right")
    for k in range(int((last - first).max(initial=0))):
        own = np.flatnonzero((line_of >= 0) & (first + k < last))
        part = first[own] + k
        off = geometry.distances(middle[own], lines[part])
        nearer = off < nearest[own]
        out[own[nearer]], nearest[own[nearer]] = part[nearer], off[nearer]
    return out


def _pieces(
    sights: Sights, lines: np.ndarray, wanted: np.ndarray, scans: np.ndarray, like: Segments, trajectory: Trajectory
) -> tuple[np.ndarray, Segments]:
    """What the scans saw of the lines ``wanted`` (indices), as segments laid on the lines, and the line of each."""
    sights.clear()
    sights.add(lines[wanted])
    beams = sights.ranges.shape[1]
    beam = np.flatnonzero(np.abs(sights.distance[:, 0] - sights.ranges.ravel()) < NEAR)
    piece, of, points = np.unique(
        beam // beams * len(wanted) + sights.line[beam, 0], return_inverse=True, return_counts=True
    )
    scan, line = np.divmod(piece, max(len(wanted), 1))
    line = wanted[line]
    half = 0.5 * np.median(np.abs(np.diff(sights.bearings))) * sights.distance[beam, 0]  # half the width of a beam
    low, high = np.full(len(piece), np.inf), np.full(len(piece), -np.inf)
    np.minimum.at(low, of, sights.along[beam, 0] - half)
    np.maximum.at(high, of, sights.along[beam, 0] + half)
    u = lines[line, 1] - lines[line, 0]
    u /= np.hypot(*u.T)[:, None]
    ends = lines[line, :1] + np.stack([low, high], 1)[..., None] * u[:, None]
    first, last = np.full(len(piece), beams), np.zeros(len(piece), np.int64)
    np.minimum.at(first, of, beam % beams)
    np.maximum.at(last, of, beam % beams)
    off = sights.distance[beam, 0] - sights.ranges.ravel()[beam]
    rms = np.sqrt(np.bincount(of, off**2, len(piece)) / np.maximum(points, 1))
    scan = scans[scan]
    laser_from_map = se2.invert(trajectory.map_from_laser[scan])
    ends = geometry.transformed(laser_from_map, ends)
    spread = np.maximum(geometry.lengths(ends), 1e-3) ** 2 / 12.0
    variance = np.maximum(rms, _NOISE) ** 2 / points
    covariance = np.stack([variance, np.zeros(len(piece)), variance / spread], 1)
    return line, Segments(ends, scan, np.stack([first, last], 1), points, rms, covariance)


def _joined(a: Segments, b: Segments) -> Segments:
    return Segments(*(np.concatenate([getattr(a, f.name), getattr(b, f.name)]) for f in fields(Segments)))


def regions_before(lines: np.ndarray, region_at: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """(L,) the region a little before the middle of each line, on its left; -1 = none."""
    d = lines[:, 1] - lines[:, 0]
    n = np.stack([-d[:, 1], d[:, 0]], 1) / np.hypot(*d.T)[:, None]
    region = np.full(len(lines), -1)
    for step in _PROBES:
        open_ = region < 0
        region[open_] = region_at(lines[open_].mean(1) + step * n[open_])
    return region
