"""Lint: what looks wrong in a map, by rules that a person can follow, each with the edit that mends it if there is one.

A finding that a person lets stand is kept in the map (``IgnoreFinding``) and not told again.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from rgcore.config import Places as Settings
from rgcore.errors import EditError
from rgcore.geometry import cutting, polygons
from rgcore.model.draft import place_of
from rgcore.model.edits import (
    AnyEdit,
    AssignGateway,
    AssignLines,
    DeleteGateway,
    DeleteLines,
    MergeRegions,
    RenameRegion,
)
from rgcore.model.gates import regions_beside
from rgcore.model.ground import before_line, free_name, shape_of
from rgcore.model.records import Point, Region, RGMap
from rgcore.model.review import finding_id

ROBOT_WIDTH = 2 * Settings().robot_radius
"""m: of a usual robot"""
OVERLAP = 0.05
"""Share of the smaller of two regions from which on they overlap; outlines from a raster stray a little."""
BESIDE = 0.5
"""m: a wall no farther than this from an outline bounds that region"""


@dataclass(frozen=True)
class Finding:
    """Something that looks wrong.

    code     the rule that found it; items: ids of what it is about, the first one most
    text     a sentence; place: where to look, map frame
    remedy   the edit that mends it, where one is likely right
    """

    code: str
    items: tuple[str, ...]
    text: str
    place: Point
    remedy: AnyEdit | None = None

    @property
    def id(self) -> str:
        """What the finding is known by; the same as long as it is about the same items."""
        return finding_id(self.code, self.items)


RULES = {
    "gateway-regions": "a gateway joins two regions (a junction: one or more)",
    "narrow-gateway": "the robot fits through every gateway",
    "unreachable": "every region is joined to the largest part of the map by gateways that the robot fits through",
    "overlap": "regions do not overlap",
    "narrow-region": "a robot has room in every region",
    "stray-line": "every wall bounds a region",
    "stray-object": "every object stands in its region",
    "duplicate-name": "no two regions have one name",
}
"""Each rule by its code, as what should hold."""


def lint(map: RGMap, robot_width: float = ROBOT_WIDTH, ignored: bool = False) -> list[Finding]:
    """What looks wrong for a robot of this width [m], rule by rule; with ``ignored``, what is let stand as well."""
    shapes = {r.id: shape_of(r) for r in map.regions.values()}
    found = [
        *_gateway_regions(map),
        *_narrow_gateways(map, robot_width),
        *_unreachable(map, robot_width),
        *_overlaps(map, shapes),
        *_narrow_regions(map, shapes, robot_width),
        *_stray_lines(map, shapes),
        *_stray_objects(map, shapes),
        *_duplicate_names(map),
    ]
    return [f for f in found if ignored or f.id not in map.ignored]


def _gateway_regions(map: RGMap) -> Iterator[Finding]:
    for g in map.gateways.values():
        if len(g.regions) == 2 or (g.class_.startswith("junction_") and g.regions):
            continue
        beside = regions_beside(map, g.posts)
        mend: AnyEdit = DeleteGateway(gateway=g.id)
        if len(beside) == 2:
            mend = AssignGateway(gateway=g.id, regions=beside)
        count = f"{len(g.regions)} region{'s' * (len(g.regions) != 1)}"
        yield _finding(map, "gateway-regions", (g.id,), f"{g.id} ({g.class_}) joins {count} instead of 2", mend)


def _narrow_gateways(map: RGMap, width: float) -> Iterator[Finding]:
    for g in map.gateways.values():
        if g.width < width:
            text = f"{g.id} is {g.width:.2f} m wide; a robot of {width:.2f} m does not fit through"
            passed = " though it drove through" if g.passed else ""
            yield _finding(map, "narrow-gateway", (g.id,), text + passed)


def _unreachable(map: RGMap, width: float) -> Iterator[Finding]:
    """Regions outside of the largest part, by area, that gateways join."""
    parts = _parts(map, width)
    if len(parts) < 2:
        return
    area = {r.id: shape_of(r).area for r in map.regions.values()}
    main = max(parts, key=lambda part: sum(area[id] for id in part))
    for id, r in map.regions.items():
        if id not in main:
            narrow = [g.id for g in map.gateways.values() if id in g.regions and g.width < width]
            why = f": {narrow[0]} is too narrow" if narrow else ""
            yield _finding(map, "unreachable", (id,), f"{_called(r)} cannot be reached from the rest{why}")


def _parts(map: RGMap, width: float) -> list[set[str]]:
    """Sets of regions that gateways of at least this width join."""
    part = {id: {id} for id in map.regions}
    for g in map.gateways.values():
        joined = [part[r] for r in g.regions if r in part] if g.width >= width else []
        whole: set[str] = set().union(*joined)
        part.update(dict.fromkeys(whole, whole))
    return list({id(p): p for p in part.values()}.values())


def _overlaps(map: RGMap, shapes: dict[str, Any]) -> Iterator[Finding]:
    regions = list(map.regions.values())
    for i, j in cutting.meeting([shapes[r.id] for r in regions]).tolist():
        a, b = regions[i], regions[j]
        one, other = shapes[a.id], shapes[b.id]
        common = cutting.overlap(one, other)
        least = min(one.area, other.area)
        if common.area > OVERLAP * least:
            x, y = cutting.inner_point(max(cutting.parts(common), key=lambda p: p.area))
            small, large = sorted((a, b), key=lambda r: shapes[r.id].area)
            text = f"{_called(small)} overlaps {_called(large)} by {common.area:.1f} m²"
            inside = MergeRegions(regions=(large.id, small.id)) if common.area > 0.8 * least else None
            yield Finding("overlap", (a.id, b.id), text, (x, y), inside)


def _narrow_regions(map: RGMap, shapes: dict[str, Any], width: float) -> Iterator[Finding]:
    for r in map.regions.values():
        if polygons.shrink(shapes[r.id], width / 2).is_empty:
            text = f"{_called(r)} has no room for a robot of {width:.2f} m"
            yield _finding(map, "narrow-region", (r.id,), text, _merged_with_neighbour(map, r))


def _merged_with_neighbour(map: RGMap, region: Region) -> AnyEdit | None:
    """The edit that gives a region to the one behind its widest gateway."""
    doors = sorted((g for g in map.gateways.values() if region.id in g.regions), key=lambda g: -g.width)
    others = [r for g in doors for r in g.regions if r != region.id]
    return MergeRegions(regions=(others[0], region.id)) if others else None


def _stray_lines(map: RGMap, shapes: dict[str, Any]) -> Iterator[Finding]:
    stray = [v for v in map.lines.values() if not v.regions and not v.clutter]
    home: list[str | None] = [None] * len(stray)
    if stray and shapes:
        nearest, far = cutting.nearest(list(shapes.values()), np.array([before_line(v.start, v.end) for v in stray]))
        home = [list(shapes)[n] if d <= BESIDE else None for n, d in zip(nearest, far, strict=True)]
    for v, region in zip(stray, home, strict=True):
        mend = DeleteLines(lines=(v.id,)) if region is None else AssignLines(lines=(v.id,), region=region)
        yield Finding("stray-line", (v.id,), f"{v.id} bounds no region", place_of(map, v.id), mend)


def _stray_objects(map: RGMap, shapes: dict[str, Any]) -> Iterator[Finding]:
    for o in map.objects.values():
        if o.region is None or o.region not in shapes:
            yield _finding(map, "stray-object", (o.id,), f"{o.label or 'object'} {o.id} stands in no region")
        elif (far := cutting.distance(shapes[o.region], o.center[:2])) > float(np.hypot(*o.size[:2])) / 2 + BESIDE:
            text = f"{o.label or 'object'} {o.id} stands {far:.1f} m outside of {o.region}, its region"
            yield _finding(map, "stray-object", (o.id,), text)


def _duplicate_names(map: RGMap) -> Iterator[Finding]:
    """Two regions of one name, whatever the case of its letters."""
    named = defaultdict(list)
    for r in map.regions.values():
        named[r.name.casefold()].append(r)
    for same in named.values():
        for r in same[1:]:
            text = f"{r.id} has the name of {same[0].id}, {same[0].name}"
            mend = RenameRegion(region=r.id, name=free_name(map, r.name))
            yield _finding(map, "duplicate-name", (r.id, same[0].id), text, mend)


def _finding(map: RGMap, code: str, items: tuple[str, ...], text: str, remedy: AnyEdit | None = None) -> Finding:
    """A finding about items, with its remedy if the map takes that."""
    if remedy is not None:
        try:
            remedy.apply(map)
        except EditError:
            remedy = None
    return Finding(code, items, text, place_of(map, items[0]), remedy)


def _called(region: Region) -> str:
    return f"{region.id} ({region.name})" if region.name else region.id
