"""Drawings that were edited elsewhere, read as items: GeoJSON, JSON-FG, DXF, OSM, and our own JSON.

An item is known by its id; what has none was drawn elsewhere, and its layer or tags tell what it is.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import defusedxml.ElementTree
import ezdxf
import numpy as np
from ezdxf import units

from rgcore.errors import InputError
from rgcore.exports import dxf, osm
from rgcore.exports.drawn import Drawn, drawn, ring
from rgcore.exports.earth import to_map
from rgcore.exports.formats import ending_of
from rgcore.exports.options import Georeference
from rgcore.exports.rgjson import read_json

LARGEST = 200 << 20
"""bytes: no drawing of a building is larger"""
_KINDS = {"Polygon": "region", "LineString": "line", "Point": "note"}


def read_drawing(path: Path, where: Georeference | None = None) -> list[Drawn]:
    """The items of a drawing; ``where``: the georeference it was exported with. Raises InputError."""
    readers: dict[str, Callable[[Path, Georeference | None], Iterator[Drawn]]] = {
        ".geojson": _geojson,
        ".fg.json": _geojson,
        ".json": lambda p, _: drawn(read_json(p)),
        ".dxf": _dxf,
        ".osm": _osm,
    }
    reader = readers.get(ending_of(path.name))
    if reader is None:
        raise InputError(path, f"no drawing that can come back; known endings: {' '.join(readers)}")
    try:
        if path.stat().st_size > LARGEST:
            raise InputError(path, f"is larger than {LARGEST >> 20} MB; that is no map of a building")
        found = list(reader(path, where))
    except OSError as e:
        raise InputError(path, f"cannot be read: {e.strerror or e}") from e
    except (ValueError, KeyError, TypeError, IndexError, AttributeError, RecursionError) as e:
        raise InputError(path, f"is damaged: {(str(e).splitlines() or [type(e).__name__])[0][:120]}") from e
    bad = next((d for d in found if not all(np.isfinite(r).all() for r in d.rings)), None)
    if bad is not None:
        raise InputError(path, f"{bad.id or 'a new ' + bad.kind} has coordinates that are no numbers")
    twice = [d.id for d in found if d.id is not None]
    if len(set(twice)) < len(twice):
        again = next(i for n, i in enumerate(twice) if i in twice[:n])
        raise InputError(path, f"{again} is there twice; a copy must lose its id")
    return found


def _geojson(path: Path, where: Georeference | None) -> Iterator[Drawn]:
    """Both kinds: a feature of JSON-FG has its ``place`` in metres."""
    tree = json.loads(path.read_text(encoding="utf-8"))
    for f in tree["features"]:
        about = f.get("properties") or {}
        shape = f.get("place") or f.get("geometry")
        if shape is None:
            continue
        kind = about.get("kind") or str(f.get("featureType", "")).removeprefix("rg:") or _KINDS.get(shape["type"])
        earthly = where is not None and not f.get("place")
        parts = shape["coordinates"] if shape["type"] == "Polygon" else [shape["coordinates"]]
        parts = [[p] if shape["type"] == "Point" else p for p in parts]
        rings = tuple(ring([p[:2] for p in part]) for part in parts)
        if earthly:
            assert where is not None
            rings = tuple(to_map(where, r) for r in rings)
        if kind in ("region", "gateway", "line", "object", "note"):
            own = f.get("id") or about.get("id")
            name = about.get("label" if kind == "object" else "name")
            id = str(own) if own is not None else None
            height, floor = _upright(about)
            yield Drawn(kind, id, rings, name, about.get("class"), about.get("text"), height, floor)


def _upright(about: dict[str, Any]) -> tuple[float | None, float | None]:
    """Height and floor of an object."""
    if not {"z", "height"} <= set(about):
        return None, None
    high = float(about["height"])
    return high, float(about["z"]) - high / 2


def _dxf(path: Path, where: Georeference | None) -> Iterator[Drawn]:
    try:
        doc = ezdxf.readfile(path)
    except OSError:
        raise
    except Exception as e:  # a damaged file ends its parser in many ways
        raise InputError(
            path, f"no DXF that can be read: {(str(e).splitlines() or [type(e).__name__])[0][:120]}"
        ) from e
    scale = units.conversion_factor(units.InsertUnits(doc.units), units.InsertUnits.Meters) if doc.units else 1.0
    kinds = {layer: kind for kind, layer in dxf.LAYERS.items()} | {dxf.CLUTTER: "line", dxf.NOTES: "note"}
    space, names, holes = doc.modelspace(), dict[str, str](), dict[str, list[np.ndarray]]()
    for t in space.query("TEXT"):
        about, said = _xdata(t), str(t.dxf.text)
        if about.get("kind") == "name":
            names[about["id"]] = said
        elif t.dxf.layer == dxf.NOTES:
            yield Drawn("note", about.get("id"), (scale * np.array([t.dxf.insert.xyz[:2]]),), text=said)
    lines = [(x, np.array([x.dxf.start.xyz[:2], x.dxf.end.xyz[:2]])) for x in space.query("LINE")]
    polylines: list[Any] = list(space.query("LWPOLYLINE"))
    outlines = [(x, ring(x.get_points("xy"))) for x in polylines]
    for x, points in outlines:
        if _xdata(x).get("kind") == "hole":
            holes.setdefault(_xdata(x)["id"], []).append(scale * points)
    for x, points in (*lines, *outlines):
        about = _xdata(x)
        kind, id = about.get("kind") or kinds.get(x.dxf.layer), about.get("id")
        if kind not in ("line", "gateway", "region", "object") or (kind in ("line", "gateway") and len(points) != 2):
            continue
        rings = (scale * points, *(holes.get(id or "", []) if kind == "region" else []))
        name = names.get(id or "") if kind == "region" else about.get("name")
        height, floor = (scale * x.dxf.thickness, scale * x.dxf.elevation) if kind == "object" else (None, None)
        yield Drawn(kind, id, rings, name, about.get("class"), None, height, floor)


def _xdata(entity: Any) -> dict[str, str]:
    if not entity.has_xdata(dxf.APP):
        return {}
    pairs = (str(v).partition("=") for code, v in entity.get_xdata(dxf.APP) if code == 1000)
    return {k: v for k, _, v in pairs}


def _osm(path: Path, where: Georeference | None) -> Iterator[Drawn]:
    try:
        root = defusedxml.ElementTree.parse(path).getroot()
    except (defusedxml.ElementTree.ParseError, defusedxml.DefusedXmlException, LookupError) as e:
        raise InputError(path, f"no OSM XML that can be read: {e}") from e
    frame = where or Georeference(0.0, 0.0)
    alive = [e for e in root if e.get("action") != "delete" and e.get("visible") != "false"]
    nodes = [e for e in alive if e.tag == "node"]
    degrees = np.array([(e.attrib["lon"], e.attrib["lat"]) for e in nodes], float).reshape(-1, 2)
    at = dict(zip((e.get("id") for e in nodes), to_map(frame, degrees), strict=True))
    ways = {e.get("id"): np.array([at[n.get("ref")] for n in e.iter("nd")]) for e in alive if e.tag == "way"}
    for x in alive:
        tags = {t.get("k"): t.get("v") for t in x.iter("tag")}
        kind = tags.get("rg:kind") or _osm_kind(x.tag, tags)
        if kind is None:
            continue
        if x.tag == "node":
            rings: tuple[np.ndarray, ...] = (at[x.get("id")][None],)
        elif x.tag == "relation":
            members = sorted(x.iter("member"), key=lambda m: m.get("role") != "outer")
            rings = tuple(ring(ways[m.get("ref")]) for m in members if m.get("ref") in ways)
        else:
            points = ways[x.get("id")]
            rings = (points if kind in ("line", "gateway") else ring(points),)
        class_ = tags.get("rg:class") or (_osm_class(tags) if kind == "region" else None)
        height = float(tags["height"]) if kind == "object" and "height" in tags else None
        yield Drawn(kind, tags.get("rg:id"), rings, tags.get("name"), class_, tags.get("note"), height)


def _osm_kind(element: str, tags: dict[Any, Any]) -> str | None:
    """What an element is that has no tags of ours."""
    if tags.get("indoor") in ("room", "corridor", "area"):
        return "region"
    if tags.get("indoor") == "wall":
        return "line"
    return "gateway" if element == "way" and "door" in tags else None


def _osm_class(tags: dict[Any, Any]) -> str:
    return next((c for c, word in osm.INDOOR.items() if word == tags.get("indoor")), "TOMA")
