"""The layers of the view: each a function from the map to a few drawings (plain arrays; no viser here).

A layer is drawn whole into a few batched nodes, never one node a thing, and is drawn again only when a field that it
names in ``reads`` has changed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from rgcore.model.records import RGMap
from rgcore.model.rows import line_ends
from rgviz import theme
from rgviz.artist import Artist
from rgviz.drawings import (
    BOX_EDGES,
    BOX_FACES,
    Dots,
    Drawings,
    Faces,
    Strokes,
    at,
    bounds,
    box_corners,
    joined,
    node_name,
    object_corners,
    ring,
)

MOST_POINTS = 120_000
"""echoes that are drawn: more make every frame slow where there is no GPU, and look the same"""


@dataclass(frozen=True)
class Layer:
    """``name`` is the node that holds it; ``reads`` the fields, by table of the map, that it is drawn from."""

    name: str
    title: str
    reads: Mapping[str, tuple[str, ...]]
    draw: Callable[[RGMap, Artist], Drawings]
    shown: bool = True
    hint: str = ""


def _points(_: RGMap, artist: Artist) -> Drawings:
    step = -(-len(artist.points) // MOST_POINTS) or 1
    return {"echoes": Dots(at(artist.points[::step], theme.Z_POINTS), theme.POINT, 0.03, "square")}


def _trajectory(_: RGMap, artist: Artist) -> Drawings:
    path = at(artist.trajectory, theme.Z_TRAJECTORY)
    return {"path": Strokes(np.stack([path[:-1], path[1:]], 1), theme.TRAJECTORY, theme.THIN_WIDTH)}


def _floors(map_: RGMap, artist: Artist) -> Drawings:
    by_class: dict[str, list[np.ndarray]] = {}
    for region in map_.regions.values():
        by_class.setdefault(region.class_, []).append(artist.floor(region))
    out: Drawings = {}
    for class_, floors in sorted(by_class.items()):
        corners = np.concatenate(floors).reshape(-1, 2)
        faces = np.arange(len(corners)).reshape(-1, 3)
        color = theme.over_white(theme.class_color(class_))  # blending would cost every pixel twice
        out[node_name(class_)] = Faces(at(corners, theme.Z_FLOOR), faces, color)
    return out


def _outlines(map_: RGMap, artist: Artist) -> Drawings:
    by_class: dict[str, list[np.ndarray]] = {}
    for region in map_.regions.values():
        by_class.setdefault(region.class_, []).append(artist.rings(region))
    return {
        node_name(c): Strokes(joined(rings, theme.Z_OUTLINE), theme.class_color(c), theme.THIN_WIDTH)
        for c, rings in sorted(by_class.items())
    }


def _lines(map_: RGMap, artist: Artist) -> Drawings:
    ends = at(line_ends(map_.lines), theme.Z_LINE)
    return {"lines": Strokes(ends, artist.line_colors(map_.lines), theme.LINE_WIDTH)}


def _walls(map_: RGMap, _: Artist) -> Drawings:
    """Lines raised to walls, but for those that an object explains."""
    furniture = {i for o in map_.objects.values() for i in o.lines}
    ends = line_ends(map_.lines)[np.array([k not in furniture for k in map_.lines], bool)]
    low, high = at(ends, 0.0), at(ends, theme.WALL_HEIGHT)
    corners = np.stack([low[:, 0], low[:, 1], high[:, 1], high[:, 0]], 1).reshape(-1, 3)
    first = 4 * np.arange(len(ends))[:, None, None]
    faces = (first + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
    return {"walls": Faces(corners, faces, theme.WALL, shaded=True, both_sides=True)}


def _boxes(map_: RGMap, _: Artist) -> Drawings:
    strokes = [ring(box_corners(r.box)) for r in map_.regions.values()]
    return {"boxes": Strokes(joined(strokes, theme.Z_BOX), theme.BOX, theme.THIN_WIDTH)}


def _axes(map_: RGMap, _: Artist) -> Drawings:
    """Crosses in the middle of each region along its main axes, the stronger one longer."""
    strokes = []
    for r in map_.regions.values():
        reach = 0.25 * min(r.box.size)
        for n, angle in enumerate(r.axes):
            arm = (reach if n == 0 else 0.6 * reach) * np.array([np.cos(angle), np.sin(angle)])
            strokes.append(np.array([[r.box.center - arm, r.box.center + arm]]))
    return {"axes": Strokes(joined(strokes, theme.Z_BOX), theme.AXIS, theme.OUTLINE_WIDTH)}


def _gateways(map_: RGMap, _: Artist) -> Drawings:
    all_ = map_.gateways.values()
    posts = np.array([g.posts for g in all_]).reshape(-1, 2, 2)
    crossings = np.array([p for g in all_ for p in g.crossing_points]).reshape(-1, 2)
    entries = np.array([p for g in all_ for p in g.gateway_points]).reshape(-1, 2)
    ways = [_ways(g.crossing_points, g.gateway_points) for g in all_]
    return {
        "openings": Strokes(at(posts, theme.Z_GATEWAY), theme.GATEWAY, theme.GATEWAY_WIDTH),
        "ways": Strokes(joined(ways, theme.Z_GATEWAY), theme.GATEWAY_POINT, theme.THIN_WIDTH),
        "posts": Dots(at(posts.reshape(-1, 2), theme.Z_MARK), theme.POST, 0.11, "square"),
        "crossing": Dots(at(crossings, theme.Z_MARK), theme.CROSSING, 0.14, "circle"),
        "entries": Dots(at(entries, theme.Z_MARK), theme.GATEWAY_POINT, 0.12, "diamond"),
    }


def _ways(crossings: tuple[tuple[float, float], ...], entries: tuple[tuple[float, float], ...]) -> np.ndarray:
    """(N, 2, 2) from each gateway-point to the crossing-point nearest to it."""
    if not crossings or not entries:
        return np.zeros((0, 2, 2))
    a, b = np.array(entries), np.array(crossings)
    nearest = np.linalg.norm(a[:, None] - b[None], axis=2).argmin(1)
    return np.stack([a, b[nearest]], 1)


def _objects(map_: RGMap, _: Artist) -> Drawings:
    boxes = [object_corners(o) for o in map_.objects.values()]
    corners = np.concatenate(boxes) if boxes else np.zeros((0, 3))
    first = 8 * np.arange(len(boxes))[:, None, None]
    return {
        "bodies": Faces(corners, (first + BOX_FACES).reshape(-1, 3), theme.OBJECT, 0.55, shaded=True),
        "edges": Strokes(corners[(first + BOX_EDGES).reshape(-1, 2)], theme.OBJECT, theme.OUTLINE_WIDTH),
    }


def _notes(map_: RGMap, _: Artist) -> Drawings:
    places = np.array([n.place for n in map_.notes.values()]).reshape(-1, 2)
    return {"notes": Dots(at(places, theme.Z_MARK), theme.NOTE, 0.16, "diamond")}


def _nothing(_: RGMap, __: Artist) -> Drawings:
    return {}


_OUTLINE = {"regions": ("class_", "boundary", "holes")}
_SHAPE = ("start", "end")

LAYERS: tuple[Layer, ...] = (
    Layer("/floors", "Floors", _OUTLINE, _floors, hint="coloured by class"),
    Layer("/outlines", "Outlines", _OUTLINE, _outlines),
    Layer("/labels", "Labels", {}, _nothing, hint="more of them as you zoom in"),
    Layer("/backdrop", "Floor plan", {}, _nothing, hint="a picture or drawing that lies under the map"),
    Layer("/lines", "Lines", {"lines": (*_SHAPE, "regions")}, _lines, hint="coloured by region"),
    Layer(
        "/gateways",
        "Gateways",
        {"gateways": ("posts", "crossing_points", "gateway_points")},
        _gateways,
        hint="posts, crossing-points, gateway-points",
    ),
    Layer("/objects", "Objects", {"objects": ("center", "size", "yaw")}, _objects),
    Layer("/notes", "Notes", {"notes": ("place",)}, _notes),
    Layer("/points", "Points", {}, _points),
    Layer("/trajectory", "Trajectory", {}, _trajectory, shown=False),
    Layer("/boxes", "Boxes", {"regions": ("box",)}, _boxes, shown=False, hint="all possible robot positions"),
    Layer("/axes", "Main axes", {"regions": ("box", "axes")}, _axes, shown=False),
    Layer("/walls", "Walls (3D)", {"lines": _SHAPE, "objects": ("lines",)}, _walls, shown=False, hint="lines raised"),
)


def outdated(layer: Layer, before: RGMap | None, after: RGMap) -> bool:
    """Whether a layer must be drawn anew: something that it reads is another value than before."""
    if before is None:
        return True
    for table, names in layer.reads.items():
        old, new = getattr(before, table), getattr(after, table)
        if old is new:
            continue
        if old.keys() != new.keys():
            return True
        changed = ((old[k], v) for k, v in new.items() if old[k] is not v)
        if any(getattr(a, n) is not getattr(b, n) for a, b in changed for n in names):
            return True
    return False


def growing_path(trajectory: np.ndarray) -> Drawings:
    """The robot's way so far and where it is now, while a log is mapped."""
    path = at(trajectory, theme.Z_TRAJECTORY)
    return {
        "path": Strokes(np.stack([path[:-1], path[1:]], 1), theme.BRAND, theme.LINE_WIDTH),
        "robot": Dots(at(trajectory[-1:], theme.Z_MARK), theme.GATEWAY, 0.3, "circle"),
    }


def extent(map_: RGMap, artist: Artist) -> np.ndarray:
    """(2, 2) lower left and upper right of the map [m]: its regions, else its lines, else whatever there is to see.

    A few lines outside of all regions, seen through a window, do not shrink the view of everything else.
    """
    parts = [np.asarray(r.boundary) for r in map_.regions.values()]
    parts = parts or [np.array([v.start, v.end]) for v in map_.lines.values()]
    return bounds(np.concatenate(parts or [np.asarray(artist.points, float), np.asarray(artist.trajectory, float)]))
