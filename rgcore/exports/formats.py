"""The formats that a map is written to, by the ending of the file.

To add one, write a module with ``render(map, trajectory, options) -> Exported`` and add a row to ``FORMATS``.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from rgcore.errors import RgError
from rgcore.exports import building, dxf, geojson, gltf, graph, nav2, nav2_route, osm, rgjson, svg, tum
from rgcore.exports.options import Exported, Options
from rgcore.model.disk import replace_file
from rgcore.model.records import RGMap
from rgcore.slam.trajectory import Trajectory

Render = Callable[[RGMap, "Trajectory | None", Options], Exported]

_BOUNDS = {"wall_height": (0.01, 100.0), "resolution": (0.01, 1.0)}  # m


class Format(NamedTuple):
    """``title`` for menus, ``media_type`` for downloads, ``render`` gives the file and those beside it."""

    title: str
    media_type: str
    render: Render


FORMATS: dict[str, Format] = {
    ".json": Format("Map (JSON)", "application/json", rgjson.render),
    ".glb": Format("3D model (glTF)", "model/gltf-binary", gltf.render),
    ".svg": Format("Drawing (SVG)", "image/svg+xml", svg.render),
    ".yaml": Format("Grid and masks (Nav2)", "application/yaml", nav2.render),
    ".route.geojson": Format("Route graph (Nav2)", "application/geo+json", nav2_route.render),
    ".building.yaml": Format("Building (Open-RMF)", "application/yaml", building.render),
    ".dxf": Format("Drawing (DXF)", "image/vnd.dxf", dxf.render),
    ".geojson": Format("Features (GeoJSON)", "application/geo+json", geojson.render),
    ".fg.json": Format("Features (JSON-FG)", "application/geo+json", geojson.render_fg),
    ".osm": Format("Indoor map (OSM)", "application/xml", osm.render),
    ".graphml": Format("Graph (GraphML)", "application/graphml+xml", graph.render_graphml),
    ".csv": Format("Tables (CSV)", "text/csv", graph.render_csv),
    ".tum": Format("Trajectory (TUM)", "text/plain", tum.render),
}
"""By ending, in the order in which menus show them. An ending may have two parts (``.route.geojson``)."""


def ending_of(name: str) -> str:
    """The ending of a file's name that a format goes by: the longest that is known, else its last suffix."""
    known = [e for e in FORMATS if name.lower().endswith(e) and len(name) > len(e)]
    return max(known, key=len, default=Path(name).suffix.lower())


def exported(ending: str, map: RGMap, trajectory: Trajectory | None = None, **options: Any) -> Exported:
    """The map in the format of an ending such as ``.glb``; ``options`` are those of :class:`Options`.

    Raises RgError for an unknown ending, a setting out of bounds, or where the format needs a trajectory and there is
    none.
    """
    found = FORMATS.get(ending.lower())
    if found is None:
        raise RgError(f"no export format {ending or '(no ending)'}; known endings: {' '.join(FORMATS)}")
    asked = replace(Options(), **options)
    for name, (least, most) in _BOUNDS.items():
        value = getattr(asked, name)
        if not least <= value <= most:
            raise RgError(f"{name.replace('_', ' ')} {value:g} m: must lie between {least:g} and {most:g} m")
    out = found.render(map, trajectory, asked)
    if map.backdrops and ending.lower() not in (".json", ".tum"):
        out = replace(out, lost=(*out.lost, "floor plans that lie under the map"))
    return out


def render(ending: str, map: RGMap, trajectory: Trajectory | None = None, **options: Any) -> bytes:
    """The file alone of :func:`exported`."""
    return exported(ending, map, trajectory, **options).data


def archived(ending: str, stem: str, out: Exported) -> tuple[bytes, bool]:
    """What a browser downloads of an export: the file, or a ZIP of it and those beside it (then True)."""
    if not out.beside:
        return out.data, False
    pack = io.BytesIO()
    with zipfile.ZipFile(pack, "w", zipfile.ZIP_DEFLATED) as z:
        for name, data in {ending: out.data, **out.beside}.items():
            z.writestr(zipfile.ZipInfo(stem + name), data)
    return pack.getvalue(), True


def export(path: str | Path, map: RGMap, trajectory: Trajectory | None = None, **options: Any) -> tuple[str, ...]:
    """Write the map to a file, and those that belong to it beside it; the ending names the format.

    What the format could not carry comes back, a sentence each. Each file is there whole or not at all. Raises RgError
    as :func:`exported` does, and where a file cannot be written.
    """
    path = Path(path)
    ending = ending_of(path.name)
    stem = path.name[: len(path.name) - len(ending)]
    try:
        out = exported(ending, map, trajectory, **{"stem": stem, **options})
    except RgError as e:
        raise RgError(f"{path}: {e}") from e
    beside = {path.with_name(stem + name): data for name, data in out.beside.items()}
    for target, data in {**beside, path: out.data}.items():  # the file last: who finds it finds what it names
        try:
            replace_file(target, data)
        except OSError as e:
            raise RgError(f"{target}: cannot be written: {e.strerror or e}") from e
    return out.lost
