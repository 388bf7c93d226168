"""Regions: the free space between the gateways (paper, sections II and IV-D)."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import find_objects

from rgcore.config import Places as Settings
from rgcore.geometry import polygons, se2
from rgcore.geometry.grid import Grid, dilate, erode
from rgcore.places.chords import find_chords
from rgcore.places.divide import cut, free_mask, open_space, split_at_pillars
from rgcore.places.freespace import FreeSpace
from rgcore.places.gateways import crossings, find_gateways
from rgcore.places.hypotheses import Hypotheses, judge
from rgcore.places.places import FoundRegion, Places
from rgcore.scans.extract import Segments
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory


def find_places(
    free: FreeSpace, log: ScanLog, trajectory: Trajectory, segments: Segments, settings: Settings
) -> Places:
    """Cut the free space at its gateways; what is left in one piece is a region."""
    open_, furniture = open_space(free, settings)
    found = judge(find_chords(open_, free.resolution, settings), free.resolution, settings)
    labels, found = divided(free, open_, furniture, found, trajectory.map_from_base[:, :2], settings)
    return _places(labels, found, trajectory, settings)


def divided(
    free: FreeSpace,
    open_: np.ndarray,
    furniture: np.ndarray,
    found: Hypotheses,
    positions: np.ndarray,
    settings: Settings,
) -> tuple[Grid, Hypotheses]:
    """The raster of regions (-1 = none) that the hypotheses divide the open space into, and those that do.

    ``open_`` and ``furniture`` are the masks of :func:`rgcore.places.divide.open_space`; ``positions`` (N, 2) m.
    """
    found = _less_sure_unpassed(found, free, positions, settings)
    open_, found = split_at_pillars(open_, free_mask(free), found, free.resolution, settings)
    labels, cuts = cut(open_, found, free.resolution, settings)
    labels[furniture] = -1
    return free.grid(labels), found[np.array(cuts, int)]


def _less_sure_unpassed(found: Hypotheses, free: FreeSpace, positions: np.ndarray, settings: Settings) -> Hypotheses:
    """The hypotheses, weak where the robot never went through and the network is not nearly sure."""
    posts = free.origin + (found.posts + 0.5) * free.resolution
    passed = np.array([len(crossings(positions, a, b)) > 0 for a, b in posts], bool)
    weak = found.weak | (~passed & (found.score < settings.unpassed_confidence))
    return Hypotheses(found.posts, found.score, found.kind, weak)


def _places(labels: Grid, found: Hypotheses, trajectory: Trajectory, settings: Settings) -> Places:
    """Number regions and gateways by the scan that came first, and describe them."""
    positions = trajectory.map_from_base[:, :2]
    at = labels.at(positions, outside=-1)
    count = int(labels.values.max()) + 1
    first = np.full(count, -1)
    for i in reversed(range(len(at))):
        if at[i] >= 0:
            first[at[i]] = i
    order = np.lexsort((np.arange(count), np.where(first < 0, len(at), first)))
    rank = np.append(np.argsort(order), -1).astype(np.int32)
    labels = labels.like(rank[labels.values])
    windows = find_objects(labels.values + 1)
    regions = tuple(describe(labels, i, int(first[order[i]]), settings, windows[i]) for i in range(count))
    return Places(labels, regions, find_gateways(labels, found, positions, settings))


SMOOTH, STRAIGHT = 3, 1.6
"""cells: notches and spikes narrower than twice the one are noise; outlines stray no farther than the other."""

MIN_HOLE = 0.3
"""m2: smaller holes are clutter."""


def _smooth(mask: np.ndarray) -> np.ndarray:
    """The mask without narrow notches and spikes, unless nothing would be left of it."""
    full = erode(dilate(mask, SMOOTH), SMOOTH)
    smooth = dilate(erode(full, SMOOTH - 1), SMOOTH - 1)
    return smooth if smooth.any() else mask


def describe(
    labels: Grid, index: int, first_scan: int, settings: Settings, window: tuple[slice, slice] | None = None
) -> FoundRegion:
    """Outline and box of one region; ``window``: the rows and columns that hold it, where they are known."""
    window = window or find_objects((labels.values == index).astype(np.uint8))[0]
    y, x = (slice(s.start - SMOOTH - 1, s.stop + SMOOTH + 1) for s in window)
    low = np.array([x.start, y.start])
    mask = Grid(labels.values[y, x] == index, labels.origin + low * labels.resolution, labels.resolution)
    shape = polygons.from_mask(mask.like(_smooth(mask.values)))[0]
    shape = polygons.straighten(polygons.without_small_holes(shape, MIN_HOLE), STRAIGHT * labels.resolution)
    boundary, holes = polygons.rings(shape)
    inner = erode(mask.values, round(settings.robot_radius / labels.resolution))
    center, size, yaw = polygons.min_rectangle(mask.centers(_row_ends(inner if inner.any() else mask.values)))
    return FoundRegion(
        boundary=boundary, holes=holes, box_center=center, box_size=size, box_yaw=yaw, first_scan=first_scan
    )


def _row_ends(mask: np.ndarray) -> np.ndarray:
    """(n, 2) first and last cell (ix, iy) of each row of a mask: they have the same hull as all its cells."""
    rows = np.flatnonzero(mask.any(1))
    first, last = mask[rows].argmax(1), mask.shape[1] - 1 - mask[rows, ::-1].argmax(1)
    return np.concatenate([np.stack([first, rows], 1), np.stack([last, rows], 1)])


PROBES = (0.1, 0.15, 0.2, 0.3)
"""m: how far off a segment, towards its free side, its region is looked up."""


def region_of_segments(segments: Segments, trajectory: Trajectory, places: Places) -> np.ndarray:
    """(M,) index of the region whose free space each segment bounds, -1 = none.

    Probes the label raster a little to the left of start -> end, at the middle first and then nearer to the ends.
    """
    ends = se2.transform(trajectory.map_from_laser[segments.scan][:, None], segments.ends)
    d = ends[:, 1] - ends[:, 0]
    n = np.stack([-d[:, 1], d[:, 0]], 1) / np.maximum(np.hypot(*d.T), 1e-9)[:, None]
    region = np.full(len(segments), -1)
    for share in (0.5, 0.3, 0.7):
        for step in PROBES:
            open_ = region < 0
            points = ends[open_, 0] + share * d[open_] + step * n[open_]
            region[open_] = places.labels.at(points, outside=-1)
    return region
