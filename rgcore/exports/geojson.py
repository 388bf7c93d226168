"""The map as GeoJSON (RFC 7946) and JSON-FG 1.0 (OGC 21-045r1): a feature an item, its id kept.

GeoJSON wants longitude and latitude: with a georeference it gets them, without one metres of the map frame (which QGIS
and GDAL read, and the export says so). JSON-FG has both: ``place`` in metres of the map frame, which it describes, and
``geometry`` in WGS 84 where there is a georeference, else null.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from rgcore.exports.cells import footprint
from rgcore.exports.earth import FRAME, to_earth
from rgcore.exports.flat import KINDS, flat
from rgcore.exports.options import Exported, Options
from rgcore.model.base import natural
from rgcore.model.records import RGMap
from rgcore.slam.trajectory import Trajectory

Geometry = dict[str, Any]

_METRES = "the coordinates are metres of the map frame, not degrees: a georeference would give them"
_LOST = "crossing-points and gateway-points, the deviations of lines, findings that a person lets stand"
_CONFORMS = tuple(f"http://www.opengis.net/spec/json-fg-1/1.0/conf/{c}" for c in ("core", "types-schemas"))


def render(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """GeoJSON."""
    where = options.georeference
    rows = []
    for kind, id, shape, about in _features(map):
        geometry = shape if where is None else _moved(shape, lambda xy: to_earth(where, xy))
        rows.append({"type": "Feature", "id": id, "geometry": geometry, "properties": {"kind": kind, **about}})
    head = {"type": "FeatureCollection", "name": options.stem}
    return Exported(_document(head, rows), lost=(_LOST,) if where is not None else (_METRES, _LOST))


def render_fg(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """JSON-FG."""
    where = options.georeference
    rows = []
    for kind, id, shape, about in _features(map):
        geometry = None if where is None else _moved(shape, lambda xy: to_earth(where, xy))
        rows.append(
            {
                "type": "Feature",
                "id": id,
                "featureType": f"rg:{kind}",
                "time": None,
                "place": shape,
                "geometry": geometry,
                "properties": about,
            }
        )
    frame = {"type": "PROJJSON", "value": FRAME}
    head = {"type": "FeatureCollection", "conformsTo": list(_CONFORMS), "coordRefSys": frame}
    return Exported(_document(head, rows), lost=(_LOST,))


def _features(map: RGMap) -> Iterator[tuple[str, str, Geometry, dict[str, Any]]]:
    """Kind, id, geometry [m, map frame] and properties of every item."""
    for kind in KINDS:
        items = getattr(map, f"{kind}s")
        for id in sorted(items, key=natural):
            yield kind, id, _geometry(kind, items[id]), flat(items[id])


def _geometry(kind: str, item: Any) -> Geometry:
    if kind == "line":
        return {"type": "LineString", "coordinates": [list(item.start), list(item.end)]}
    if kind == "gateway":
        return {"type": "LineString", "coordinates": [list(p) for p in item.posts]}
    if kind == "note":
        return {"type": "Point", "coordinates": list(item.place)}
    rings = [footprint(item)] if kind == "object" else [item.boundary, *item.holes]
    return {"type": "Polygon", "coordinates": [_closed(ring) for ring in rings]}


def _closed(ring: Any) -> list[list[float]]:
    points = [[round(float(x), 6) + 0.0, round(float(y), 6) + 0.0] for x, y in ring]
    return [*points, points[0]]


def _moved(shape: Geometry, move: Callable[[np.ndarray], np.ndarray]) -> Geometry:
    """The same geometry with all of its points moved."""

    def walk(part: Any) -> Any:
        if not isinstance(part[0], list):
            return move(np.array([part]))[0].tolist()
        return move(np.array(part)).tolist() if not isinstance(part[0][0], list) else [walk(p) for p in part]

    return {"type": shape["type"], "coordinates": walk(shape["coordinates"])}


def _document(head: dict[str, Any], rows: list[dict[str, Any]]) -> bytes:
    """One feature a line, so that a difference reads well."""
    lines = ",\n".join(json.dumps(row, ensure_ascii=False, sort_keys=True) for row in rows)
    return f'{json.dumps(head, ensure_ascii=False)[:-1]}, "features": [\n{lines}\n]}}\n'.encode()
