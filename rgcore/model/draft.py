"""Drafts: from what a hand or a script points at to the edit that is meant. Each gives an edit; nothing is changed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from rgcore.errors import EditError
from rgcore.geometry import cutting
from rgcore.model.boxes import fit_box
from rgcore.model.edit import kind_of, the_line, the_region
from rgcore.model.edits_gateways import AddGateway
from rgcore.model.edits_lines import AlignLines, DrawLine
from rgcore.model.edits_notes import AddNote
from rgcore.model.edits_objects import AddObject, SeedObject
from rgcore.model.edits_regions import SplitRegion
from rgcore.model.fields import new_id
from rgcore.model.gates import LEAST_WIDTH, regions_beside
from rgcore.model.ground import free_space, shape_of
from rgcore.model.records import Line, Point, RGMap, rounded
from rgcore.model.rows import is_clutter, line_ends

SNAP = 0.3
"""m: a drawn point so near to the end of a wall means it"""
ALONG = math.radians(10)
"""rad: a cut that runs so nearly along a wall is meant along it"""
REACH = 3.0
"""m: how far a wall is prolonged to catch a cut"""
WIDEST_DOOR = 1.5
"""m: a wider gateway is an opening unless said otherwise"""


def split_region(
    map: RGMap, region: str, path: Sequence[Point], gateway: bool = False, name: str = "", snap: float = SNAP
) -> SplitRegion:
    """The edit that parts a region along a drawn path: it snaps to walls and runs on to the outline.

    A straight path that nearly runs along a wall is laid onto it; else ends near the end of a wall snap to that.
    Raises EditError if there is no such region.
    """
    home = shape_of(the_region(map, region))
    near = _beside(map, home, snap)
    walls = list(map.lines.values())
    cut = list(path)
    wall = _along((walls[n] for n in near), cut, snap) if len(cut) == 2 else None
    if wall is not None:
        cut = [_foot(p, wall) for p in cut]
    else:
        cut = [_snapped(map, near, cut[0], snap), *cut[1:-1], _snapped(map, near, cut[-1], snap)]
    if math.dist(cut[0], cut[-1]) < LEAST_WIDTH:  # both caught by one corner
        cut = list(path)
    return SplitRegion(
        region=region,
        cut=tuple(cut),
        id=new_id(map, "regions"),
        name=name,
        gateway=new_id(map, "gateways") if gateway else None,
    ).checked()


def add_gateway(
    map: RGMap,
    posts: tuple[Point, Point],
    regions: tuple[str, ...] | None = None,
    class_: str | None = None,
    snap: float = SNAP,
) -> AddGateway:
    """The edit that makes a gateway between drawn posts, which snap to ends of walls.

    Without ``regions`` it joins those on both sides; without ``class_`` it is a narrow_passage up to 1.5 m, an opening
    beyond. Raises EditError if there are no two regions beside it.
    """
    a, b = (snapped(map, p, snap) for p in posts)
    if math.dist(a, b) < snap:  # both caught by one corner
        a, b = posts
    joined = regions_beside(map, (a, b)) if regions is None else regions
    if regions is None and len(joined) != 2:
        raise EditError(f"there {'is' if len(joined) == 1 else 'are'} {len(joined)} of 2 regions beside these posts")
    width = math.dist(a, b)
    return AddGateway(
        id=new_id(map, "gateways"),
        posts=(a, b),
        regions=joined,
        class_=class_ or ("narrow_passage" if width <= WIDEST_DOOR else "opening"),
    ).checked()


def draw_wall(map: RGMap, start: Point, end: Point, free: Point | None = None, snap: float = SNAP) -> DrawLine:
    """The edit that draws a wall between points, which snap to ends of walls; ``free``: a point on its free side.

    Without one, free space is on the side nearer to a region; left of start -> end where both are as near.
    """
    a, b = snapped(map, start, snap), snapped(map, end, snap)
    if math.dist(a, b) < snap:
        a, b = start, end
    (ax, ay), (bx, by) = a, b
    if free is not None:
        left = (bx - ax) * (free[1] - ay) - (by - ay) * (free[0] - ax) >= 0
    else:
        left = free_space(map, a, b) <= free_space(map, b, a)
    a, b = (a, b) if left else (b, a)
    return DrawLine(id=new_id(map, "lines"), start=a, end=b).checked()


def align_lines(map: RGMap, lines: Sequence[str]) -> AlignLines:
    """The edit that lays lines along or across the nearest main axis of their region. EditError if there is none."""
    chosen = [the_line(map, id) for id in lines]
    axes = [a for v in chosen for r in v.regions[:1] if r in map.regions for a in map.regions[r].axes]
    if not axes:
        raise EditError("these lines have no region with a main axis")
    d = np.array([np.subtract(v.end, v.start) for v in chosen])
    angles = np.arctan2(d[:, 1], d[:, 0])
    off = [sum(abs(math.remainder(a - b, math.pi / 2)) for b in angles) for a in axes]
    return AlignLines(lines=tuple(lines), direction=axes[int(np.argmin(off))]).checked()


def object_from_lines(map: RGMap, lines: Iterable[str], height: float = 1.0, label: str = "") -> SeedObject:
    """The edit that makes a box of ``height`` [m] over lines: the smallest rectangle along one of them, on the floor.

    Raises EditError if there is no such line.
    """
    chosen = [the_line(map, id) for id in dict.fromkeys(lines)]
    if not chosen:
        raise EditError("an object needs at least one line")
    homes = [line.regions[0] for line in chosen if line.regions]
    home = max(homes, key=homes.count) if homes else None
    axes = map.regions[home].axes if home in map.regions else ()
    (x, y), (along, across), yaw = fit_box(np.array([[line.start, line.end] for line in chosen]), axes)
    return SeedObject(
        id=new_id(map, "objects"),
        lines=tuple(line.id for line in chosen),
        center=(x, y, height / 2),
        size=(along, across, height),
        yaw=yaw,
        label=label,
        region=home,
    ).checked()


def object_in_rectangle(
    map: RGMap, low: Point, high: Point, height: float = 1.0, label: str = ""
) -> SeedObject | AddObject:
    """The edit that makes a box of what stands in a rectangle: over the lines that lie in it, else the rectangle.

    An empty rectangle's box stands along the main axes of the region around it where they are within 5 degrees.
    """
    inside = lines_in_rectangle(map, low, high)
    if inside:
        return object_from_lines(map, inside, height, label)
    corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    middle = (float(corners[:, 0].mean()), float(corners[:, 1].mean()))
    home = next((r for r in map.regions.values() if cutting.distance(shape_of(r), middle) == 0), None)
    sides = np.stack([corners, np.roll(corners, -1, 0)], 1)
    (x, y), (along, across), yaw = fit_box(sides, home.axes if home else ())
    return AddObject(
        id=new_id(map, "objects"),
        center=(x, y, height / 2),
        size=(along, across, height),
        yaw=yaw,
        label=label,
        region=home.id if home else None,
    ).checked()


def lines_in_rectangle(map: RGMap, low: Point, high: Point) -> tuple[str, ...]:
    """Ids of the lines that lie wholly in an upright rectangle between two opposite corners."""
    box = np.sort(np.array([low, high]), axis=0)
    inside = ((line_ends(map.lines) >= box[0]) & (line_ends(map.lines) <= box[1])).all((1, 2))
    return tuple(id for id, yes in zip(map.lines, inside, strict=True) if yes)


def note_on(map: RGMap, text: str, item: str) -> AddNote:
    """The edit that puts a note onto an item, at its middle. Raises EditError if there is no such item."""
    return AddNote(id=new_id(map, "notes"), text=text, place=place_of(map, item), item=item).checked()


def place_of(map: RGMap, id: str) -> Point:
    """A point of an item that a view can go to. Raises EditError if there is no such item."""
    item = getattr(map, kind_of(map, id))[id]
    if id in map.regions:
        inner = cutting.inner_point(shape_of(item))
        return rounded(inner[0]), rounded(inner[1])
    if id in map.notes:
        return item.place
    if id in map.objects:
        return item.center[:2]
    (ax, ay), (bx, by) = (item.start, item.end) if id in map.lines else item.posts
    return rounded((ax + bx) / 2), rounded((ay + by) / 2)


def snapped(map: RGMap, point: Point, reach: float = SNAP, without: str | None = None) -> Point:
    """The nearest end of a wall within ``reach`` [m] of a point, else the point; ``without`` a line."""
    places = np.arange(len(map.lines))
    return _snapped(map, places if without is None else places[[id != without for id in map.lines]], point, reach)


def _snapped(map: RGMap, places: np.ndarray, point: Point, reach: float) -> Point:
    """``snapped``, to the lines at these places of their table."""
    ends = line_ends(map.lines)[places][~is_clutter(map.lines)[places]].reshape(-1, 2)
    far = np.hypot(*(ends - point).T)
    if not len(ends) or far.min() > reach:
        return point
    x, y = ends[int(far.argmin())]
    return float(x), float(y)


def is_end(map: RGMap, point: Point) -> bool:
    """Whether a line begins or ends exactly there."""
    return bool((line_ends(map.lines) == point).all(2).any())


def _beside(map: RGMap, shape: Any, reach: float) -> np.ndarray:
    """Places in their table of the lines within ``reach`` [m] of a polygon."""
    ends, (x0, y0, x1, y1) = line_ends(map.lines), shape.bounds
    low, high = ends.min(1) - reach, ends.max(1) + reach
    near = np.flatnonzero(((low < (x1, y1)) & (high > (x0, y0))).all(1))  # a cheap look before the exact one
    return near[cutting.gaps(shape, ends[near]) < reach]


def _along(lines: Iterable[Line], cut: Sequence[Point], reach: float) -> Line | None:
    """The longest wall that a straight cut is meant along; None if there is none."""
    a, b = np.array(cut[0]), np.array(cut[1])
    best, longest = None, 0.0
    for v in lines:
        p, q = np.array(v.start), np.array(v.end)
        length = math.dist(v.start, v.end)
        u = (q - p) / max(length, 1e-9)
        turn = math.remainder(math.atan2(*(b - a)[::-1]) - math.atan2(u[1], u[0]), math.pi)
        aside = max(abs(float(u[0] * (e - p)[1] - u[1] * (e - p)[0])) for e in (a, b))
        s = sorted((float((a - p) @ u), float((b - p) @ u)))
        gap = max(s[0] - length, -s[1], 0.0)
        if abs(turn) < ALONG and aside <= reach and gap <= REACH and length > longest:
            best, longest = v, length
    return best


def _foot(point: Point, line: Line) -> Point:
    p, d = np.array(line.start), np.subtract(line.end, line.start)
    x, y = p + d * ((np.array(point) - p) @ d) / max(float(d @ d), 1e-12)
    return rounded(x), rounded(y)
