"""The map as OpenStreetMap XML with Simple Indoor Tagging, to look at and edit in JOSM.

Every element carries ``rg:id``, since editors number anew; ids are negative: nothing of it is in the public database.
Without a georeference the map lies at 0, 0.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any
from xml.etree import ElementTree

import numpy as np

from rgcore.exports.cells import footprint
from rgcore.exports.earth import to_earth
from rgcore.exports.flat import flat, printable
from rgcore.exports.options import Exported, Georeference, Options
from rgcore.model.base import natural
from rgcore.model.records import RGMap
from rgcore.slam.trajectory import Trajectory

INDOOR = {"CDMA": "corridor", "ODMA": "corridor", "TOMA": "room", "CC": "room"}
"""``indoor=*`` by class of region; what people made is an area."""

_AREA = {"area": "yes"}  # readers that do not know of indoor tags take a closed way for a line
_LONGEST = 255  # characters of a value
_NOWHERE = "the place on the earth: without a georeference the map lies at latitude 0, longitude 0"
_LOST = ("class scores, main axes, crossing-points and gateway-points",)


def render(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """The XML file."""
    writer = _Writer(options.georeference or Georeference(0.0, 0.0))
    for r in _ordered(map.regions):
        tags = {"indoor": INDOOR.get(r.class_, "area"), "level": "0", **_rg("region", r)}
        if r.name:
            tags["name"] = r.name
        if not r.holes:
            writer.way(r.boundary, {**tags, **_AREA}, closed=True)
        else:
            outer, *inner = (writer.way(ring, {}, closed=True) for ring in (r.boundary, *r.holes))
            writer.relation([(outer, "outer"), *((w, "inner") for w in inner)], {"type": "multipolygon", **tags})
    for v in _ordered(map.lines):
        writer.way((v.start, v.end), {"indoor": "wall", "level": "0", **_rg("line", v)})
    for g in _ordered(map.gateways):
        door = {"door": "yes" if g.class_ == "narrow_passage" else "no", "entrance": "no", "width": f"{g.width:.2f}"}
        named = {"name": g.name} if g.name else {}
        writer.way(g.posts, {"level": "0", **door, **named, **_rg("gateway", g)})
    for o in _ordered(map.objects):
        tags = {"indoor": "area", "level": "0", "height": f"{o.size[2]:.2f}", **_rg("object", o)}
        writer.way(footprint(o), tags | _AREA | ({"name": o.label} if o.label else {}), closed=True)
    for note in _ordered(map.notes):
        writer.point(note.place, {"note": note.text, **_rg("note", note)})
    return Exported(writer.xml(), lost=_LOST if options.georeference else (*_LOST, _NOWHERE))


class _Writer:
    """Elements as they come; a place is one node, however many ways use it."""

    def __init__(self, where: Georeference) -> None:
        self.where = where
        self.ways: list[ElementTree.Element] = []
        self._nodes: dict[tuple[float, float], int] = {}
        self._tags: dict[int, dict[str, str]] = {}
        self._last = 0

    def point(self, at: Any, tags: dict[str, str]) -> int:
        node = self._node(at)
        self._tags.setdefault(node, {}).update(tags)
        return node

    def way(self, points: Iterable[Any], tags: dict[str, str], closed: bool = False) -> int:
        nodes = [self._node(p) for p in points]
        nodes += nodes[:1] if closed else []
        way = self._element("way", tags, ("nd", ({"ref": str(n)} for n in nodes)))
        return int(way.attrib["id"])

    def relation(self, members: list[tuple[int, str]], tags: dict[str, str]) -> None:
        rows = ({"type": "way", "ref": str(w), "role": role} for w, role in members)
        self._element("relation", tags, ("member", rows))

    def xml(self) -> bytes:
        root = ElementTree.Element("osm", {"version": "0.6", "generator": "rgviz", "upload": "never"})
        places = np.array(list(self._nodes), float).reshape(-1, 2)
        for (lon, lat), id in zip(to_earth(self.where, places), self._nodes.values(), strict=True):
            at = {"id": str(id), "version": "1", "visible": "true", "lat": f"{lat:.9f}", "lon": f"{lon:.9f}"}
            _tagged(ElementTree.SubElement(root, "node", at), self._tags.get(id, {}))
        root.extend(self.ways)
        ElementTree.indent(root, " ")
        return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"

    def _node(self, at: Any) -> int:
        key = (round(float(at[0]), 4), round(float(at[1]), 4))
        if key not in self._nodes:
            self._last -= 1
            self._nodes[key] = self._last
        return self._nodes[key]

    def _element(
        self, name: str, tags: dict[str, str], parts: tuple[str, Iterable[dict[str, str]]]
    ) -> ElementTree.Element:
        self._last -= 1
        out = ElementTree.Element(name, {"id": str(self._last), "version": "1", "visible": "true"})
        for part in parts[1]:
            ElementTree.SubElement(out, parts[0], part)
        self.ways.append(_tagged(out, tags))
        return out


def _tagged(element: ElementTree.Element, tags: dict[str, str]) -> ElementTree.Element:
    for k, v in tags.items():
        ElementTree.SubElement(element, "tag", {"k": k, "v": printable(v)[:_LONGEST]})
    return element


def _rg(kind: str, item: Any) -> dict[str, str]:
    about = flat(item)
    kept = ("class", "accuracy", "confidence", "regions", "passed", "provenance")
    return {"rg:id": item.id, "rg:kind": kind, **{f"rg:{k}": str(about[k]) for k in kept if k in about}}


def _ordered(items: dict[str, Any]) -> list[Any]:
    return [items[k] for k in sorted(items, key=natural)]
