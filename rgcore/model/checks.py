"""Lint: what looks wrong in a map, found by rules that a person can follow."""

from __future__ import annotations

from collections import Counter

from rgcore.model.records import Record, Region, RGMap


class Finding(Record, frozen=True, kw_only=True):
    """``rule`` that found it, ``item`` the id of what it is about, ``text`` a sentence."""

    rule: str
    item: str
    text: str


def check(map: RGMap) -> list[Finding]:
    """All findings, rule by rule, in the order of the items."""
    return [*_gateways(map), *_unreachable(map), *_names(map)]


def _gateways(map: RGMap) -> list[Finding]:
    """A gateway joins two regions (a junction any number); none names a region that is not there."""
    out = []
    for g in map.gateways.values():
        joined = [r for r in dict.fromkeys(g.regions) if r in map.regions]
        gone = [r for r in g.regions if r not in map.regions]
        if gone:
            text = f"{g.id} names {', '.join(gone)}, which is not in the map"
        elif len(joined) != 2 and not g.class_.startswith("junction_"):
            text = f"{g.id} ({g.class_}) joins {len(joined)} region{'s' * (len(joined) != 1)} instead of 2"
        elif not joined:
            text = f"{g.id} ({g.class_}) belongs to no region"
        else:
            continue
        out.append(Finding(rule="gateway-regions", item=g.id, text=text))
    return out


def _unreachable(map: RGMap) -> list[Finding]:
    """Regions that no chain of gateways joins to the largest part of the map."""
    parts = _parts(map)
    if len(parts) < 2:
        return []
    main = max(parts, key=len)
    return [
        Finding(
            rule="unreachable",
            item=id,
            text=f"{_called(map.regions[id])} cannot be reached from the rest",
        )
        for id in map.regions
        if id not in main
    ]


def _parts(map: RGMap) -> list[set[str]]:
    """Sets of regions that gateways join, in the order of their first region."""
    neighbours: dict[str, set[str]] = {id: set() for id in map.regions}
    for g in map.gateways.values():
        here = [r for r in g.regions if r in neighbours]
        for r in here:
            neighbours[r].update(here)
    parts: list[set[str]] = []
    seen: set[str] = set()
    for start in map.regions:
        if start in seen:
            continue
        part, todo = {start}, [start]
        while todo:
            new = neighbours[todo.pop()] - part
            part |= new
            todo += new
        seen |= part
        parts.append(part)
    return parts


def _names(map: RGMap) -> list[Finding]:
    """Two regions of one name, whatever the case of its letters."""
    count = Counter(r.name.casefold() for r in map.regions.values() if r.name)
    return [
        Finding(rule="duplicate-name", item=r.id, text=f"{r.id} shares its name, {r.name}, with another region")
        for r in map.regions.values()
        if count[r.name.casefold()] > 1
    ]


def _called(region: Region) -> str:
    return f"{region.id} ({region.name})" if region.name else region.id
