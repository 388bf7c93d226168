"""What holds in every map, whatever edits were made: no name of a thing that is not there, no shape that is none."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

from rgcore.geometry import cutting
from rgcore.model.records import Gateway, RGMap

KINDS = ("lines", "regions", "gateways", "objects", "notes", "ignored", "backdrops")


def broken(map: RGMap) -> list[str]:
    """What is wrong with a map, a sentence each; nothing in any that edits made of a sound one."""
    return [*_names(map), *_shapes(map), *_gateways(map)]


def _names(map: RGMap) -> Iterator[str]:
    ids = {id for kind in KINDS for id in getattr(map, kind)}
    for kind in KINDS:
        yield from (f"{id} stands under another name" for id, v in getattr(map, kind).items() if v.id != id)
    named: list[tuple[str, tuple[str, ...], Collection[str]]]
    named = [(v.id, v.regions, map.regions) for v in map.lines.values()]
    named += [(g.id, g.regions, map.regions) for g in map.gateways.values()]
    named += [(o.id, o.lines, map.lines) for o in map.objects.values()]
    named += [(o.id, (o.region,), map.regions) for o in map.objects.values() if o.region is not None]
    for id, names, table in named:
        yield from (f"{id} names {name}, which is not in the map" for name in names if name not in table)
        if len(set(names)) < len(names):
            yield f"{id} names one thing twice"
    for n in map.notes.values():
        if n.item is not None and n.item not in ids:
            yield f"{n.id} is on {n.item}, which is not in the map"
    for f in map.ignored.values():
        yield from (f"{f.id} names {name}, which is not in the map" for name in f.items if name not in ids)


def _shapes(map: RGMap) -> Iterator[str]:
    for r in map.regions.values():
        reason = cutting.fault(r.boundary, r.holes)
        if reason is not None:
            yield f"the outline of {r.id} {reason}"
        (x, y), size = r.box.center, r.box.size
        if not all(math.isfinite(value) for value in (x, y, *size, r.box.yaw, *r.axes)):
            yield f"the box or axes of {r.id} are no numbers"
        if not all(0 <= a < math.pi for a in r.axes) or not r.name:
            yield f"{r.id} has no name, or an axis beyond half a turn"
    for v in map.lines.values():
        if math.dist(v.start, v.end) < 1e-3:
            yield f"{v.id} has no length"
    for o in map.objects.values():
        if min(o.size) <= 0:
            yield f"{o.id} has no extent"


def _gateways(map: RGMap) -> Iterator[str]:
    for g in map.gateways.values():
        if not g.regions:
            yield f"{g.id} belongs to no region"
        if len(g.gateway_points) != len(g.regions):
            yield f"{g.id} has {len(g.gateway_points)} gateway-points for {len(g.regions)} regions"
        yield from _crossing(g)


def _crossing(g: Gateway) -> Iterator[str]:
    if math.dist(*g.posts) < 1e-3:
        yield f"the posts of {g.id} are one"
    if not g.crossing_points:
        yield f"{g.id} is crossed nowhere"
