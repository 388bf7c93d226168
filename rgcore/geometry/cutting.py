"""Polygons cut in two, joined, and judged: what editing an outline needs. Knows shapely, as ``polygons`` does."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import Polygon

from rgcore.geometry.polygons import Ring


def fault(boundary: Ring, holes: tuple[Ring, ...] = ()) -> str | None:
    """What keeps rings from being the outline and holes of one area, as the end of a sentence; None if nothing."""
    p = Polygon(boundary, holes)
    if p.is_valid:
        return None if p.area > 0 else "encloses nothing"
    reason, _, place = shapely.is_valid_reason(p).partition("[")
    says = {
        "Self-intersection": "crosses itself",
        "Ring Self-intersection": "touches itself",
        "Hole lies outside shell": "has a hole outside of its outline",
        "Holes are nested": "has a hole in a hole",
        "Interior is disconnected": "falls into several pieces",
    }.get(reason, "is no outline of an area")
    where = [f"{float(v):.2f}" for v in place.rstrip("]").split()[:2]]
    return f"{says} at ({', '.join(where)})" if where else says


GRID = 1e-6
"""m: coordinates of what is cut and joined; on a grid these operations cannot fail (snap rounding)"""

PILLAR = 2.0
"""m: a cut that meets a hole no wider than this goes on behind it"""


def halve(shape: Polygon, path: np.ndarray, least: float = 0.0) -> tuple[list[Polygon], np.ndarray]:
    """The parts, largest first, of a polygon cut along ``path`` (n, 2), and the cut (m, 2) from edge to edge.

    The path goes on straight beyond its ends up to the outline, behind pillars too; what lies outside is left out.
    One part if the path does not cut the polygon through; none if it does not meet it at all. Where there are two parts
    of ``least`` [m2], the slivers that a cut leaves along a ragged edge go to them.
    """
    p = np.asarray(path, float)
    drawn, far = shapely.linestrings(p), 2 * shape.length
    first, last = (p[0] - p[1]) / np.hypot(*(p[0] - p[1])), (p[-1] - p[-2]) / np.hypot(*(p[-1] - p[-2]))
    long = shapely.linestrings(np.concatenate([[p[0] + far * first], p, [p[-1] + far * last]]))
    within = _most(_strings(shapely.intersection(long, Polygon(shape.exterior))), drawn)
    bits = sorted(_strings(within.intersection(shape)), key=lambda b: within.project(shapely.Point(b.coords[0])))
    start = _most(bits, drawn)
    if start.is_empty or not long.is_simple:
        return [], np.zeros((0, 2))
    low = high = bits.index(start)

    def parted(pieces: list[Polygon]) -> bool:
        return sum(p.area >= least for p in pieces) > 1

    halves = _cut(shape, bits[low : high + 1])
    while not parted(halves) and high + 1 < len(bits) and bits[high].distance(bits[high + 1]) < PILLAR:
        high += 1
        halves = _cut(shape, bits[low : high + 1])
    while not parted(halves) and low > 0 and bits[low].distance(bits[low - 1]) < PILLAR:
        low -= 1
        halves = _cut(shape, bits[low : high + 1])
    cut = np.concatenate([np.asarray(b.coords) for b in bits[low : high + 1]])
    halves = _without_slivers(halves, least) if parted(halves) else halves
    return halves, cut if (cut[-1] - cut[0]) @ (p[-1] - p[0]) >= 0 else cut[::-1]


def _without_slivers(pieces: list[Polygon], least: float) -> list[Polygon]:
    """The larger pieces, largest first; each sliver goes to the one that it has most edge in common with."""
    large = [p for p in pieces if p.area >= least]
    for sliver in (p for p in pieces if p.area < least):
        edge = [p.intersection(sliver).length for p in large]
        n = int(np.argmax(edge))
        large[n] = max(parts(shapely.union_all([large[n], sliver], grid_size=GRID)), key=lambda p: p.area)
    return sorted(large, key=lambda p: -p.area)


def _most(bits: list[shapely.LineString], drawn: shapely.LineString) -> shapely.LineString:
    """The piece that most of ``drawn`` runs along."""
    shared = [b.intersection(drawn.buffer(1e-6)).length for b in bits]
    return bits[int(np.argmax(shared))] if shared and max(shared) > 1e-5 else shapely.LineString()


def _cut(shape: Polygon, cuts: list[shapely.LineString]) -> list[Polygon]:
    """The parts of a polygon, largest first."""
    longer = [shapely.linestrings(_reaching(np.asarray(c.coords))) for c in cuts]
    faces = shapely.polygonize([shapely.union_all([shape.boundary, *longer])])
    return sorted((f for f in parts(faces) if shape.contains(f.representative_point())), key=lambda f: -f.area)


def _reaching(path: np.ndarray, by: float = 1e-6) -> np.ndarray:
    """A path a little longer at both ends, so that it surely reaches the edge that it ends on."""
    u, v = path[0] - path[1], path[-1] - path[-2]
    return np.concatenate([[path[0] + by * u / np.hypot(*u)], path[1:-1], [path[-1] + by * v / np.hypot(*v)]])


def _strings(shape: shapely.Geometry) -> list[shapely.LineString]:
    """The lines of whatever an operation gave."""
    if isinstance(shape, shapely.LineString):
        return [] if shape.is_empty else [shape]
    return [s for g in getattr(shape, "geoms", ()) for s in _strings(g)]


def unite(shapes: Sequence[Polygon], doors: np.ndarray, others: Sequence[Polygon] = ()) -> Polygon | None:
    """Polygons that lie side by side as one; None if they do not.

    Where a wall stands between them, they are joined through ``doors`` (K, 2, 2), the posts of each, or else closed
    over the least gap, up to 0.6 m. Nothing of ``others`` is taken.
    """
    taken = shapely.union_all(list(others), grid_size=GRID)
    for reach in (0.0, 0.02, 0.1, 0.2, 0.35, 0.5):
        bars = shapely.buffer(shapely.linestrings(doors), max(reach, 1e-3), cap_style="flat") if len(doors) else []
        whole = shapely.union_all([*shapes, *(minus(b, taken) for b in bars)], grid_size=GRID)
        if len(parts(whole)) == 1:
            return parts(whole)[0]
    for reach in (0.02, 0.05, 0.1, 0.2, 0.3):
        closed = whole.buffer(reach, join_style="mitre").buffer(-reach, join_style="mitre")
        pieces = parts(shapely.union(whole, minus(closed, taken), grid_size=GRID))
        if len(pieces) == 1:
            return pieces[0]
    return None


def minus(shape: shapely.Geometry, other: shapely.Geometry) -> shapely.Geometry:
    """What is left of an area without another one."""
    return shapely.difference(shape, other, grid_size=GRID)


def overlap(shape: shapely.Geometry, other: shapely.Geometry) -> shapely.Geometry:
    """What two areas have in common."""
    return shapely.intersection(shape, other, grid_size=GRID)


def meeting(shapes: Sequence[Polygon]) -> np.ndarray:
    """(K, 2) indices i < j of polygons that have points in common, in rising order."""
    if not shapes:
        return np.zeros((0, 2), int)
    found = shapely.STRtree(list(shapes)).query(list(shapes), predicate="intersects").T
    return np.asarray(sorted((int(i), int(j)) for i, j in found if i < j)).reshape(-1, 2)


def nearest(shapes: Sequence[Polygon], points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Index of the polygon nearest to each point (K, 2), and how far it is [m], 0 inside: (K,) both.

    There must be a polygon; of several as near, the first.
    """
    tree = shapely.STRtree(list(shapes))
    (asked, found), far = tree.query_nearest(shapely.points(points), return_distance=True)
    first = np.lexsort((found, asked))[np.searchsorted(np.sort(asked), np.arange(len(points)))]
    return found[first], far[first]


def distance(shape: Polygon, point: tuple[float, float]) -> float:
    """How far a point lies outside a polygon [m]; 0 inside."""
    return float(shapely.distance(shape, shapely.Point(point)))


def gaps(shape: Polygon, ends: np.ndarray) -> np.ndarray:
    """(K,) how far lines (K, 2, 2) lie outside a polygon [m]; 0 where they reach into it."""
    return np.asarray(shapely.distance(shape, shapely.linestrings(ends)))


def inner_point(shape: Polygon) -> tuple[float, float]:
    """A point inside of a polygon: the centroid where that is inside."""
    point = shape.centroid if shape.contains(shape.centroid) else shape.representative_point()
    return float(point.x), float(point.y)


def parts(shape: shapely.Geometry, least: float = 0.0) -> list[Polygon]:
    """The polygons of whatever an operation gave, those of more than ``least`` [m2]."""
    if isinstance(shape, Polygon):
        return [shape] if shape.area > least else []
    return [p for g in getattr(shape, "geoms", ()) for p in parts(g, least)]
