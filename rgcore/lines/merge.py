"""Merging of segments to the lines of the map (paper, section IV-B).

The measure, the thresholds (mu, rho, gamma, distance) and the moments are the paper's. What it leaves open is the
order in which lines are compared, which decides how far a merged line can drift. Here the strongest segment not yet
used is the seed of a line; all segments that the measure allows join it, the line is fitted anew from the moments,
and all are asked again until nothing changes (:mod:`rgcore.lines.grow`). The line is then cut where too few segments
cover it, so that collinear walls left and right of a door stay two lines that end at the door's posts
(:mod:`rgcore.lines.cover`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.config import Lines as Settings
from rgcore.evidence import Evidence
from rgcore.geometry import moments as mo
from rgcore.geometry import segments as geometry
from rgcore.lines.cover import drop_hidden
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

    Only segments of one region (``region_of_segment`` (M,), -1 = none) and of one side merge: opposite faces of a
    thin wall stay two lines. Segments go nowhere that are disregarded (rho) or whose line would be too short (mu) or
    seen too rarely.
    """
    ends = geometry.transformed(trajectory.map_from_laser[segments.scan], segments.ends)
    region = np.asarray(region_of_segment, np.int64)
    if len(ends) == 0:
        return _no_lines(), np.zeros(0, np.int64)
    center = ends.mean((0, 1))  # keeps the numbers small far from the map's origin
    found, line_of = grow_lines(ends - center, segments.points, region, settings)
    keep = drop_hidden(
        found,
        region_of(line_of, region, len(found)),
        np.bincount(line_of[line_of >= 0], minlength=len(found)),
        settings,
    )
    line_of = np.where(line_of >= 0, np.where(keep, np.cumsum(keep) - 1, -1)[line_of], -1)
    return _ordered(found[keep] + center, line_of, ends, segments.scan, region)


def region_of(line_of: np.ndarray, region: np.ndarray, count: int) -> np.ndarray:
    """(L,) region of the members of each line."""
    out = np.full(count, -1, np.int64)
    members = line_of >= 0
    out[line_of[members]] = region[members]
    return out


def _ordered(
    ends: np.ndarray, line_of: np.ndarray, segment_ends: np.ndarray, scan: np.ndarray, region: np.ndarray
) -> tuple[Lines, np.ndarray]:
    """The lines by the scan that saw them first, with everything that their members tell."""
    count = len(ends)
    members = np.flatnonzero(line_of >= 0)
    first = np.full(count, np.iinfo(np.int64).max)
    np.minimum.at(first, line_of[members], members)  # members are in the order of scans and beams
    order = np.argsort(first, kind="stable")
    rank = np.empty(count, np.int64)
    rank[order] = np.arange(count)
    line_of = np.where(line_of >= 0, rank[line_of], -1)
    ends = ends[order]

    of = line_of[members]
    sums = np.zeros((count, 6))
    np.add.at(sums, of, mo.moments(segment_ends[members]))
    d = ends[:, 1] - ends[:, 0]
    normal = np.stack([-d[:, 1], d[:, 0]], 1) / np.hypot(d[:, 0], d[:, 1])[:, None]
    off = np.einsum("mpk,mk->mp", segment_ends[members] - ends[of][:, :1], normal[of])
    weight = geometry.lengths(segment_ends[members])
    squares = np.bincount(of, weight * (off**2).mean(1), count) / np.bincount(of, weight, count)
    support = np.bincount(of, minlength=count)
    lines = Lines(ends, sums, support, np.sqrt(squares), region_of(line_of, region, count), scan[first[order]])
    return lines, line_of


def _no_lines() -> Lines:
    none = np.zeros(0, np.int64)
    return Lines(np.zeros((0, 2, 2)), np.zeros((0, 6)), none, np.zeros(0), none, none)
