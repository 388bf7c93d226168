"""Polygons with holes: from a raster and back to plain rings. The one place that knows shapely."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import MultiPolygon, Polygon

from rgcore.geometry.grid import Grid

Ring = tuple[tuple[float, float], ...]
"""A closed ring of points [m], the first not repeated; outlines run counter-clockwise, holes clockwise."""

THIN = 0.01
"""m on both sides of a line that a way must not cross."""


STEP, TILT = 1.5, 0.025
"""Pieces of outline are one edge if all of both is nearer to their line than so many times the tolerance, and if that
line leans by no more [rad] from the longer of them."""


def from_mask(mask: Grid) -> list[Polygon]:
    """Polygons that cover the cells of a mask exactly, largest first, in metres."""
    cells = np.asarray(mask.values) != 0
    edge = np.diff(np.pad(cells, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    (row, start), (_, end) = np.nonzero(edge == 1), np.nonzero(edge == -1)
    low = mask.origin + mask.resolution * np.stack([start, row], 1)
    high = mask.origin + mask.resolution * np.stack([end, row + 1], 1)
    runs = shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    return sorted(_parts(shapely.union_all(runs)), key=lambda p: -p.area)


def simplify(polygon: Polygon, tolerance: float) -> Polygon:
    """Fewer corners, none farther than ``tolerance`` [m] from the outline (Douglas & Peucker 1973); stays valid."""
    simple = polygon.simplify(tolerance, preserve_topology=True)
    return max(_parts(simple.buffer(0)), key=lambda p: p.area, default=polygon)


def straighten(shape: Polygon, tolerance: float) -> Polygon:
    """The polygon with straight edges: split where it bends by more than ``tolerance`` [m] (Douglas & Peucker 1973),
    each edge the least-squares line of its piece of outline, corners where these meet."""
    rings_ = [np.asarray(r.coords)[:-1] for r in (shape.exterior, *shape.interiors)]
    fitted = [_straight_ring(r, tolerance) for r in rings_]
    outer = Polygon(fitted[0])
    whole = Polygon(fitted[0], [h for h in fitted[1:] if len(h) >= 3])
    good = whole if whole.is_valid else outer
    if good.is_valid and abs(good.area - shape.area) < 0.1 * shape.area:
        return good
    return simplify(shape, tolerance)


def _straight_ring(ring: np.ndarray, tolerance: float) -> np.ndarray:
    """Corners (n, 2) of a ring (m, 2) after fitting its straight pieces."""
    dense = np.asarray(shapely.LinearRing(ring).segmentize(tolerance / 2).coords)[:-1]
    corners = np.asarray(Polygon(dense).simplify(tolerance, preserve_topology=True).exterior.coords)[:-1]
    start = [int(np.hypot(*(dense - c).T).argmin()) for c in corners]
    if len(start) < 3 or dense.shape[0] < 6:
        return corners
    direction = 1 if (start[1] - start[0]) % len(dense) < len(dense) / 2 else -1
    pieces = []
    for i, a in enumerate(start):
        n = direction * (start[(i + 1) % len(start)] - a) % len(dense)
        piece = dense[(a + direction * np.arange(n + 1)) % len(dense)]
        if np.hypot(*(piece[-1] - piece[0])) >= 3 * tolerance:  # shorter ones only cut a corner
            pieces.append(piece)
    pieces = _without_steps(pieces, STEP * tolerance)
    if len(pieces) < 3:
        return corners
    out = []
    lines = [(*_fitted(piece)[:2], piece[0], piece[-1]) for piece in pieces]
    for (p, u, _, end), (q, v, begin, _) in zip(lines, [*lines[1:], lines[0]], strict=True):
        turn = u[0] * v[1] - u[1] * v[0]
        if abs(turn) > 0.3:
            meet = p + u * ((q - p)[0] * v[1] - (q - p)[1] * v[0]) / turn
            if np.hypot(*(meet - (end + begin) / 2)) < 4 * tolerance:
                out.append(meet)
                continue
        out += [p + u * ((end - p) @ u), q + v * ((begin - q) @ v)]
    return np.array(out)


def _fitted(piece: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """The least-squares line of points (n, 2): a point, its direction, and the farthest point's distance from it."""
    middle = piece.mean(0)
    x, y = (piece - middle).T
    angle = 0.5 * math.atan2(2 * (x @ y), x @ x - y @ y)
    c, s = math.cos(angle), math.sin(angle)
    return middle, np.array([c, s]), float(np.abs(c * y - s * x).max())


def _without_steps(pieces: list[np.ndarray], tolerance: float) -> list[np.ndarray]:
    """The pieces of a ring, neighbours joined while one line fits both: between them was a step of the raster."""
    i = since = 0
    while len(pieces) > 3 and since < len(pieces):
        j = (i + 1) % len(pieces)
        both = np.concatenate([pieces[i], pieces[j]])
        longer = max(pieces[i], pieces[j], key=len)
        (_, u, far), (_, v, _) = _fitted(both), _fitted(longer)
        if far <= tolerance and abs(u[0] * v[1] - u[1] * v[0]) <= TILT:
            pieces = [both if k == i else p for k, p in enumerate(pieces) if k != j]
            i, since = min(i, len(pieces) - 1), 0
        else:
            i, since = j, since + 1
    return pieces


def rings(polygon: Polygon, digits: int = 4) -> tuple[Ring, tuple[Ring, ...]]:
    """Outline (counter-clockwise) and holes (clockwise) as plain points, rounded to ``digits`` decimals of a metre."""
    p = shapely.geometry.polygon.orient(polygon)

    def plain(ring: shapely.LinearRing) -> Ring:
        return tuple((round(float(x), digits), round(float(y), digits)) for x, y in ring.coords[:-1])

    return plain(p.exterior), tuple(plain(r) for r in p.interiors)


def polygon(boundary: Ring, holes: tuple[Ring, ...] = ()) -> Polygon:
    """A shapely polygon of plain rings, repaired where they cross themselves."""
    p = Polygon(boundary, holes)
    return p if p.is_valid else max(_parts(p.buffer(0)), key=lambda q: q.area, default=Polygon())


def triangulate(boundary: Ring, holes: tuple[Ring, ...] = ()) -> np.ndarray:
    """(T, 3, 2) triangles that cover the polygon, counter-clockwise (constrained Delaunay triangulation)."""
    inner = shapely.constrained_delaunay_triangles(polygon(boundary, holes))
    triangles = [np.asarray(shapely.geometry.polygon.orient(t).exterior.coords)[:3] for t in inner.geoms]
    return np.array(triangles).reshape(-1, 3, 2)


def label_place(boundary: Ring, holes: tuple[Ring, ...] = ()) -> tuple[tuple[float, float], float]:
    """Where a label goes, and how far that is from the outline [m].

    The centroid, or the middle of the largest circle within the polygon where that has clearly more room.
    """
    shape = polygon(boundary, holes)
    if shape.area < 1e-6:
        return boundary[0], 0.0
    radius = shapely.maximum_inscribed_circle(shape, max(0.05, 0.01 * shape.length))
    middle = shape.centroid
    room = shape.boundary.distance(middle) if shape.contains(middle) else 0.0
    if room < 0.75 * radius.length:
        middle, room = shapely.Point(radius.coords[0]), radius.length
    return (float(middle.x), float(middle.y)), float(room)


def locate(shapes: Sequence[Polygon], points: np.ndarray) -> np.ndarray:
    """(N,) index of the first polygon that covers each point (N, 2), its edge included; -1 where none does."""
    p = np.asarray(points, float).reshape(-1, 2)
    order = np.argsort(p[:, 0])
    x, y = np.ascontiguousarray(p[order].T)
    found = np.full(len(p), -1)
    for i, shape in enumerate(shapes):
        shapely.prepare(shape)
        left, low, right, high = shape.bounds
        a, b = np.searchsorted(x, left, "left"), np.searchsorted(x, right, "right")
        k = a + np.flatnonzero((y[a:b] >= low) & (y[a:b] <= high) & (found[a:b] < 0))
        found[k[shapely.intersects_xy(shape, x[k], y[k])]] = i
    out = np.empty_like(found)
    out[order] = found
    return out


def shrink(shape: Polygon, by: float, lines: np.ndarray | None = None) -> MultiPolygon:
    """The points of a polygon at least ``by`` [m] from its edge and from ``lines`` (K, 2, 2) in it.

    Corners of obstacles stay corners, bevelled.
    """
    room = shape.buffer(-by, join_style="mitre", mitre_limit=1.1) if by > 0 else shape
    if lines is not None and len(lines):
        walls = shapely.buffer(shapely.linestrings(lines), max(by, THIN), cap_style="square")
        room = room.difference(shapely.union_all(walls))
    return MultiPolygon(_parts(room))


def turns(shapes: MultiPolygon) -> np.ndarray:
    """(n, 3, 2) the corners about which a way in the polygons can bend: previous, corner, next along the ring."""
    rings_ = [np.asarray(r.coords)[:-1] for p in _parts(shapes) for r in _left(p)]
    if not rings_:
        return np.zeros((0, 3, 2))
    c = np.concatenate([np.stack([np.roll(r, 1, 0), r, np.roll(r, -1, 0)], 1) for r in rings_])
    a, b = c[:, 1] - c[:, 0], c[:, 2] - c[:, 1]
    return c[a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] < -1e-9]


def covers(shapes: MultiPolygon | Polygon, ends: np.ndarray, slack: float = 1e-6) -> np.ndarray:
    """(K,) whether straight pieces (K, 2, 2) lie in the polygons, or leave them by no more than ``slack`` [m]."""
    room = shapes.buffer(slack, join_style="mitre")
    shapely.prepare(room)
    lines = shapely.linestrings(ends)
    point = (ends[:, 0] == ends[:, 1]).all(1)  # no line, and so covered by nothing
    return np.where(point, shapely.intersects(room, lines), shapely.covers(room, lines))


def nearest(shapes: MultiPolygon | Polygon, points: np.ndarray) -> np.ndarray:
    """(K, 2) the nearest point in the polygons to each of points (K, 2): itself where it is inside; nan in none."""
    p = np.asarray(points, float).reshape(-1, 2)
    if shapes.is_empty:
        return np.full(p.shape, np.nan)
    links = shapely.shortest_line(shapes, shapely.points(p))
    return np.asarray(shapely.get_coordinates(shapely.get_point(links, 0)))


def _left(shape: Polygon) -> tuple[shapely.LinearRing, ...]:
    """The rings of a polygon with its inside to their left."""
    p = shapely.geometry.polygon.orient(shape)
    return (p.exterior, *p.interiors)


def _parts(shape: shapely.Geometry) -> list[Polygon]:
    """The polygons of whatever an operation gave."""
    if isinstance(shape, Polygon):
        return [] if shape.is_empty else [shape]
    if isinstance(shape, MultiPolygon):
        return [p for p in shape.geoms if not p.is_empty]
    return [p for g in getattr(shape, "geoms", ()) for p in _parts(g)]


def without_small_holes(shape: Polygon, area: float) -> Polygon:
    """The polygon with holes below ``area`` [m2] filled."""
    return Polygon(shape.exterior, [h for h in shape.interiors if Polygon(h).area >= area])


def min_rectangle(points: np.ndarray) -> tuple[tuple[float, float], tuple[float, float], float]:
    """Smallest rectangle around points (N, 2): centre, size (long side first) and the long side's angle in [0, pi)."""
    box = shapely.minimum_rotated_rectangle(shapely.multipoints(np.asarray(points, float)).convex_hull.buffer(1e-3))
    corners = np.asarray(box.exterior.coords)[:4]
    side = corners[1:3] - corners[:2]
    length = np.hypot(*side.T)
    long = int(length[1] > length[0])
    yaw = float(np.arctan2(side[long, 1], side[long, 0]) % np.pi)
    x, y = corners.mean(0)
    return (round(x, 4), round(y, 4)), (round(float(length[long]), 4), round(float(length[1 - long]), 4)), round(yaw, 4)


def walls_of(spaces: Sequence[np.ndarray], blocked: Sequence[np.ndarray]) -> np.ndarray:
    """(S, 2, 2) edges of the union of polygons (n, 2) without the blocked ones, free space to the left."""
    room = shapely.union_all([Polygon(s).buffer(0) for s in spaces])
    room = room.difference(shapely.union_all([Polygon(b).buffer(0) for b in blocked]))
    rings_ = [np.asarray(r.coords) for p in _parts(room) for r in _left(p)]
    return np.concatenate([np.stack([r[:-1], r[1:]], 1) for r in rings_] or [np.zeros((0, 2, 2))])
