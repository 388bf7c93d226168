"""Merging of segments to the lines of the map (paper, section IV-B).

The measure, the thresholds (mu, rho, gamma, distance) and the moments are the paper's. What it leaves open is the
order in which lines are compared, which decides how far a merged line can drift. Here the strongest segment not yet
used is the seed of a line; all segments that the measure allows join it, the line is fitted anew from the moments,
and all are asked again until nothing changes (:mod:`rgcore.lines.grow`). The line is then cut where too few segments
cover it, so that collinear walls left and right of a door stay two lines that end at the door's posts
(:mod:`rgcore.lines.cover`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from rgcore.config import Lines as Settings
from rgcore.evidence import Evidence
from rgcore.geometry import moments as mo
from rgcore.geometry import segments as geometry
from rgcore.lines.corners import close_corners
from rgcore.lines.cover import covered_runs, spans_of, unhidden
from rgcore.lines.grow import grow_lines
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
    covariance (L, 3)    m2, m rad, rad2: of the middle's offset across the line and of its direction, both to the
                         left: variance, covariance, variance; zero before the map is finished
    """

    ends: np.ndarray
    moments: np.ndarray
    support: np.ndarray
    rms: np.ndarray
    region: np.ndarray
    first_scan: np.ndarray
    covariance: np.ndarray


def merge_lines(
    segments: Segments,
    trajectory: Trajectory,
    region_of_segment: np.ndarray,
    settings: Settings,
    by_region: Sequence[Settings] = (),
) -> tuple[Lines, np.ndarray]:
    """Lines of the map, and for each segment (M,) the index of the line it went into (-1 = none).

    Only segments of one region (``region_of_segment`` (M,), -1 = none) and of one side merge: opposite faces of a
    thin wall stay two lines. Segments go nowhere that are disregarded (rho) or whose line would be too short (mu) or
    seen too rarely. ``by_region``: distance, rho, gamma, mu and support of each region, the last for segments of none;
    ``settings`` then hold for what regions share, hidden stretches and corners.
    """
    ends = geometry.transformed(trajectory.map_from_laser[segments.scan], segments.ends)
    region = np.asarray(region_of_segment, np.int64)
    if len(ends) == 0:
        return _no_lines(), np.zeros(0, np.int64)
    center = ends.mean((0, 1))  # keeps the numbers small far from the map's origin
    ends = np.ascontiguousarray(ends - center)
    eyes = trajectory.map_from_laser[segments.scan, :2] - center
    found, line_of = _merged(ends, segments.points, region, eyes, settings, by_region)
    if len(found) == 0:
        return _no_lines(), line_of
    found = unhidden(found, _count(line_of, len(found)), settings)
    keep = geometry.lengths(found) >= settings.min_length
    found, line_of = close_corners(found[keep], settings.corner), renumbered(line_of, keep)
    if by_region:
        home = region_of(line_of, region, len(found))
        mu, support = (np.array([getattr(s, k) for s in by_region])[home] for k in ("min_length", "min_support"))
        keep = (geometry.lengths(found) >= mu) & (_count(line_of, len(found)) >= support)
        found, line_of = found[keep], renumbered(line_of, keep)
    return describe(found, line_of, ends, center, segments.scan, region)


def _merged(
    ends: np.ndarray,
    points: np.ndarray,
    region: np.ndarray,
    eyes: np.ndarray,
    settings: Settings,
    by_region: Sequence[Settings],
) -> tuple[np.ndarray, np.ndarray]:
    """The lines of all regions and the line of each segment; regions of the same settings are merged in one go.

    Here mu and the support are the common ones: a region's own are asked at the end, when corners have made the ends.
    """
    common = {"min_length": settings.min_length, "min_support": settings.min_support}
    own = [msgspec.structs.replace(s, **common) for s in by_region] or [settings]
    found, line_of, count = [np.zeros((0, 2, 2))], np.full(len(ends), -1, np.int64), 0
    for s in dict.fromkeys(own):
        members = np.flatnonzero(np.array([o == s for o in own])[region if by_region else np.zeros_like(region)])
        frames, of = grow_lines(ends[members], points[members], region[members], s)
        if len(frames) == 0:
            continue
        among_all = np.full(len(ends), -1, np.int64)  # all beams tell what can be seen through
        among_all[members] = of
        lines, of = _cut(frames, among_all, ends, points, eyes, s)
        line_of[of >= 0] = of[of >= 0] + count
        found.append(lines)
        count += len(lines)
    return np.concatenate(found), line_of


def _cut(
    frames: np.ndarray, line_of: np.ndarray, ends: np.ndarray, points: np.ndarray, eyes: np.ndarray, settings: Settings
) -> tuple[np.ndarray, np.ndarray]:
    """The lines cut to what is there, each on the fit of its own members: (L, 2, 2), and the line of each segment."""
    runs, of = covered_runs(frames, line_of, ends, points, eyes, settings)
    long = runs[:, 1] - runs[:, 0] >= settings.min_length
    runs, of = runs[long], of[long]
    line_of = _run_of(frames, line_of, ends, runs, of)
    keep = _count(line_of, len(runs)) >= settings.min_support
    runs, of, line_of = runs[keep], of[keep], renumbered(line_of, keep)
    lines = frames[of][:, None, :2] + runs[..., None] * frames[of][:, None, 2:]
    middle = lines.mean(1)
    own = np.flatnonzero(line_of >= 0)
    sums = np.zeros((len(lines), 6))
    np.add.at(sums, line_of[own], mo.moments(ends[own] - middle[line_of[own]][:, None]))
    return middle[:, None] + mo.projected(sums, lines - middle[:, None]), line_of


def _run_of(frames: np.ndarray, line_of: np.ndarray, ends: np.ndarray, runs: np.ndarray, of: np.ndarray) -> np.ndarray:
    """(M,) the run of its line in which the middle of a segment lies, or -1."""
    out = np.full(len(line_of), -1, np.int64)
    own = np.flatnonzero(line_of >= 0)
    if len(runs) == 0 or len(own) == 0:
        return out
    middle = spans_of(frames[line_of[own]], ends[own]).mean(1)
    far = (
        2.0 * max(float(np.abs(runs).max()), float(np.abs(middle).max())) + 1.0
    )  # lays the lines end to end on one axis
    at = line_of[own] * far + middle
    run = np.searchsorted(of * far + runs[:, 0], at, side="right") - 1
    inside = (run >= 0) & (of[run] == line_of[own]) & (middle <= runs[run, 1])
    out[own[inside]] = run[inside]
    return out


def _count(line_of: np.ndarray, count: int) -> np.ndarray:
    return np.bincount(line_of[line_of >= 0], minlength=count)


def renumbered(line_of: np.ndarray, keep: np.ndarray) -> np.ndarray:
    """``line_of`` when only the lines of the mask ``keep`` stay."""
    if len(keep) == 0:
        return np.full(len(line_of), -1, np.int64)
    return np.where(line_of >= 0, np.where(keep, np.cumsum(keep) - 1, -1)[line_of], -1)


def region_of(line_of: np.ndarray, region: np.ndarray, count: int) -> np.ndarray:
    """(L,) region of the members of each line."""
    out = np.full(count, -1, np.int64)
    members = line_of >= 0
    out[line_of[members]] = region[members]
    return out


def describe(
    lines: np.ndarray, line_of: np.ndarray, ends: np.ndarray, center: np.ndarray, scan: np.ndarray, region: np.ndarray
) -> tuple[Lines, np.ndarray]:
    """The lines by the scan that saw them first, with all that their members tell; ``ends`` are about ``center``."""
    count = len(lines)
    members = np.flatnonzero(line_of >= 0)
    first = np.full(count, np.iinfo(np.int64).max)
    np.minimum.at(first, line_of[members], members)  # segments are in the order of scans and beams
    order = np.argsort(first, kind="stable")
    rank = np.empty(count, np.int64)
    rank[order] = np.arange(count)
    line_of[members] = rank[line_of[members]]
    lines, of = lines[order], line_of[members]

    sums = np.zeros((count, 6))
    np.add.at(sums, of, mo.moments(ends[members]))
    d = lines[:, 1] - lines[:, 0]
    normal = np.stack([-d[:, 1], d[:, 0]], 1) / np.hypot(d[:, 0], d[:, 1])[:, None]
    off = np.einsum("mpk,mk->mp", ends[members] - lines[of][:, :1], normal[of])
    weight = geometry.lengths(ends[members])
    squares = np.bincount(of, weight * (off**2).mean(1), count) / np.bincount(of, weight, count)
    return Lines(
        lines + center,
        mo.moved(sums, (center[0], center[1])),
        _count(line_of, count),
        np.sqrt(squares),
        region_of(line_of, region, count),
        scan[first[order]],
        np.zeros((count, 3)),
    ), line_of


def _no_lines() -> Lines:
    none = np.zeros(0, np.int64)
    return Lines(np.zeros((0, 2, 2)), np.zeros((0, 6)), none, np.zeros(0), none, none, np.zeros((0, 3)))
