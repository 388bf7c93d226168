"""The ground: what follows for a map from new outlines of regions. Lines, gateways and objects go with the ground."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Collection, Iterable
from typing import Any

import numpy as np

from rgcore.config import Places as Settings
from rgcore.errors import EditError
from rgcore.geometry import cutting, polygons
from rgcore.model.edit import drop, put_all
from rgcore.model.records import Box2, Gateway, Line, Point, Region, RGMap, replace, rounded

ROBOT_RADIUS = Settings().robot_radius
"""m: the box of a region is that of all positions of such a robot"""
LEAST_REGION = 0.1
"""m2: what is smaller holds no robot"""
TOLERATED = 0.02
"""m2: outlines from a raster overlap by so much without meaning it"""
ASIDE = 0.15
"""m: how far off a line, towards its free side, its region is looked up"""


def shape_of(region: Region) -> Any:
    """The polygon of a region; made once for an outline, for a preview asks for those of all regions at every move."""
    return _polygon(region.boundary, region.holes)


_polygon = functools.lru_cache(maxsize=20_000)(polygons.polygon)


def reshaped(region: Region, shape: Any) -> Region:
    """The region with the outline of a polygon (not yet its box and axes). Raises EditError if hardly any is left."""
    if shape.area < LEAST_REGION:
        raise EditError(f"{region.id} would be smaller than {LEAST_REGION} m²")
    outer, holes = polygons.rings(polygons.simplify(shape, 0.002), 6)
    if cutting.fault(outer, holes) is not None:  # rounding closed a slit
        outer, holes = polygons.rings(polygons.polygon(outer, holes), 6)
    return replace(region, boundary=outer, holes=holes)


def checked_rings(what: str, boundary: Iterable[Point], holes: Iterable[Iterable[Point]]) -> tuple[Any, ...]:
    """Outline counter-clockwise and holes clockwise. Raises EditError if they are no outline of one area."""
    outer, inner = tuple(boundary), tuple(tuple(h) for h in holes)
    reason = cutting.fault(outer, inner)
    if reason is not None:
        raise EditError(f"the outline of {what} {reason}")
    if polygons.polygon(outer, inner).area < LEAST_REGION:
        raise EditError(f"{what} would be smaller than {LEAST_REGION} m²")
    return _turned(outer, left=True), tuple(_turned(h, left=False) for h in inner)


def _turned(ring: tuple[Point, ...], left: bool) -> tuple[Point, ...]:
    x, y = np.array(ring).T
    is_left = float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) > 0
    return ring if is_left == left else (ring[0], *ring[:0:-1])


def claim(map: RGMap, region: str, gained: Any) -> list[Region]:
    """The other regions without the ground that one of them gained, those that lose some.

    Raises EditError if one would be covered wholly or fall into pieces.
    """
    out = []
    for other in map.regions.values():
        shape = shape_of(other)
        if other.id == region or not shape.intersects(gained) or cutting.overlap(shape, gained).area <= TOLERATED:
            continue
        rest = cutting.parts(cutting.minus(shape, gained), LEAST_REGION)
        if len(rest) != 1:
            how = f"cut {other.id} into {len(rest)} pieces; split it first" if rest else f"cover all of {other.id}"
            raise EditError(f"{region} would {how}{'' if rest else '; merge them instead'}")
        out.append(reshaped(other, rest[0]))
    return out


def settle(old: RGMap, map: RGMap, changed: Collection[str], gone: Collection[str] = ()) -> RGMap:
    """The map after the outlines of the regions ``changed`` are new and those of ``gone`` no more.

    A line, gateway or object stays with its region unless that withdrew from it; then it goes to the nearest of those
    that changed. A gateway that joins no two regions any more goes. Boxes and axes follow. ``old``: the map before.
    """
    heir = _Heir(old, map, changed, gone)
    lines = [replace(v, regions=heir.of_line(v)) for v in map.lines.values() if heir.concerns(v.regions)]
    map = put_all(map, "lines", lines)
    at_home = {id: [v for v in map.lines.values() if v.regions[:1] == (id,)] for id in changed}
    map = put_all(map, "regions", (_measured(map.regions[id], at_home[id]) for id in changed))
    kept = [heir.gateway(g) for g in map.gateways.values() if heir.concerns(g.regions)]
    lost = [g.id for g in kept if len(g.regions) < min(2, len(map.gateways[g.id].regions))]
    map = put_all(map, "gateways", (g for g in kept if g.id not in lost))
    map = drop(map, "gateways", *lost) if lost else map
    objects = [o for o in map.objects.values() if o.region is None or heir.concerns((o.region,))]
    return put_all(map, "objects", (replace(o, region=heir.of_object(o)) for o in objects))


class _Heir:
    """Who gets what stood in a region that changed or went."""

    def __init__(self, old: RGMap, map: RGMap, changed: Collection[str], gone: Collection[str]) -> None:
        self.before = {id: shape_of(old.regions[id]) for id in (*changed, *gone) if id in old.regions}
        self.after = {id: shape_of(map.regions[id]) for id in changed}

    def concerns(self, regions: tuple[str, ...]) -> bool:
        return not regions or any(id in self.before or id in self.after for id in regions)

    def of(self, point: Point, region: str) -> str | None:
        """The region of something at a point that was ``region``'s; None if nothing is left there."""
        if region not in self.before and region not in self.after:
            return region
        was = cutting.distance(self.before[region], point) if region in self.before else math.inf
        if region in self.after and cutting.distance(self.after[region], point) <= was + 1e-6:
            return region
        far = {id: cutting.distance(shape, point) for id, shape in self.after.items()}
        best = min(far, key=lambda id: far[id], default=None)
        if region in self.after:
            return best if best is not None and far[best] < far[region] else region
        return best if best is not None and far[best] <= max(was, 2 * ASIDE) else None

    def free(self, point: Point) -> str | None:
        """The region of something that had none."""
        return next((id for id, shape in self.after.items() if cutting.distance(shape, point) == 0), None)

    def of_line(self, line: Line) -> tuple[str, ...]:
        point = before_line(line.start, line.end)
        if not line.regions:
            home = self.free(point)
            return (home,) if home else ()
        return tuple(dict.fromkeys(r for id in line.regions if (r := self.of(point, id)) is not None))

    def of_object(self, thing: Any) -> str | None:
        here = thing.center[:2]
        return self.free(here) if thing.region is None else self.of(here, thing.region)

    def gateway(self, g: Gateway) -> Gateway:
        """The gateway with its heirs, each with its gateway-point."""
        spare = ((g.posts[0][0] + g.posts[1][0]) / 2, (g.posts[0][1] + g.posts[1][1]) / 2)
        points = g.gateway_points if len(g.gateway_points) == len(g.regions) else (spare,) * len(g.regions)
        new: dict[str, Point] = {}
        for id, point in zip(g.regions, points, strict=True):
            heir = self.of(point, id)
            if heir is not None:
                new.setdefault(heir, point)
        return replace(g, regions=tuple(new), gateway_points=tuple(new.values()))


def before_line(start: Point, end: Point, by: float = ASIDE) -> Point:
    """A point before the middle of a line, on its free side."""
    (x0, y0), (x1, y1) = start, end
    length = max(math.dist(start, end), 1e-9)
    return (x0 + x1) / 2 - by * (y1 - y0) / length, (y0 + y1) / 2 + by * (x1 - x0) / length


def region_before(map: RGMap, start: Point, end: Point) -> str | None:
    """The region on the free side of a line; None if there is none within 0.3 m."""
    point = before_line(start, end)
    far = {r.id: cutting.distance(shape_of(r), point) for r in map.regions.values()}
    best = min(far, key=lambda id: far[id], default=None)
    return best if best is not None and far[best] <= 2 * ASIDE else None


def free_space(map: RGMap, start: Point, end: Point) -> float:
    """How far the free side of a line is from the nearest region [m]; 0 where it is in one."""
    point = before_line(start, end)
    return min((cutting.distance(shape_of(r), point) for r in map.regions.values()), default=math.inf)


def _measured(region: Region, lines: list[Line]) -> Region:
    """The region with the box and the main axes of its outline and lines."""
    from rgcore.places.classify import angle_histogram, main_axes  # brings Numba, which an editor does without

    shape = shape_of(region)
    room = cutting.parts(polygons.shrink(shape, ROBOT_RADIUS)) or [shape]
    center, size, yaw = polygons.min_rectangle(np.concatenate([np.asarray(p.exterior.coords) for p in room]))
    ring = np.array(region.boundary)
    outline = np.stack([ring, np.roll(ring, -1, 0)], 1)
    ends = np.array([(v.start, v.end) for v in lines]) if lines else outline
    histogram, peak = angle_histogram(ends, 36)
    axes = tuple(_axis(a) for a in main_axes(ends, histogram, peak) if math.isfinite(a))
    box = Box2(
        center=(rounded(center[0]), rounded(center[1])), size=(rounded(size[0]), rounded(size[1])), yaw=rounded(yaw)
    )
    return replace(region, box=box, axes=axes)


def _axis(angle: float) -> float:
    a = rounded(angle % math.pi)
    return a if a < math.pi else 0.0


def free_name(map: RGMap, like: str) -> str:
    """The next name of a kind: "Room 7" where there are six rooms."""
    stem = re.sub(r"\s*\d+\Z", "", like)[:70] or "Region"
    taken = {r.name.casefold() for r in map.regions.values()}
    return next(name for n in range(1, len(taken) + 2) if (name := f"{stem} {n}").casefold() not in taken)
