"""What is in a file, told without mapping it: a log, a bag, a project, a map."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from rgcore.errors import InputError
from rgcore.model.project import Project
from rgcore.model.records import RGMap
from rgcore.scans import bags
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log
from rgviz.measure import PIPED


def describe(path: Path) -> dict[str, Any]:
    """What a file is and holds, by name. Raises InputError for one of no known format."""
    if not path.exists():
        raise InputError(path, "there is no such file; check the path")
    if Project.exists(path):
        with Project.open(path) as project:
            return {"file": str(path), "kind": "project", "log": project.map.source.log, **_counts(project.map)}
    if path.is_file() and (drawn := _drawing(path)) is not None:
        return {"file": str(path), **drawn}
    found: dict[str, Any] = {"file": str(path), "kind": "log"}
    if bags.is_bag(path):
        found["topics"] = [t._asdict() for t in bags.topics(path)]
        found["kind"] = "bag"
        if not any(t["type"] in bags.LASERS for t in found["topics"]):
            return found  # to say what it holds, it need not be a log
    elif (map_ := _map(path)) is not None:
        return {"file": str(path), "kind": "map", "log": map_.source.log, **_counts(map_)}
    return {**found, **_scans(read_log(path))}


def _drawing(path: Path) -> dict[str, Any] | None:
    """A floor plan, by its first bytes, or a map that was edited elsewhere, by its ending; None for what is neither."""
    from rgcore.exports.formats import ending_of
    from rgcore.exports.readers import read_drawing
    from rgcore.scans.backdrop import Picture, read_backdrop, read_file

    ending = ending_of(path.name)
    with path.open("rb") as f:
        image = f.read(8).startswith((b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff"))
    if not image and ending not in (".dxf", ".geojson", ".fg.json", ".osm"):
        return None
    found: dict[str, Any] = {"kind": "drawing"}
    if image or ending == ".dxf":
        plan = read_backdrop(read_file(path), str(path))
        unit = "pixels" if isinstance(plan, Picture) else "m" if plan.measured else "units without a name"
        found = {"kind": "floor plan", "size": f"{plan.size[0]:.6g} x {plan.size[1]:.6g} {unit}"}
    if not image:
        kinds = [d.kind for d in read_drawing(path)]
        found |= {f"{kind}s": kinds.count(kind) for kind in ("region", "gateway", "line", "object") if kind in kinds}
    return found


def _map(path: Path) -> RGMap | None:
    """The map of a JSON file; None for a file that is none."""
    from rgcore.exports.rgjson import read_json

    if path.suffix != ".json":
        return None
    return read_json(path)


def _counts(m: RGMap) -> dict[str, Any]:
    return {
        "scans": m.stats.scans,
        "lines": len(m.lines),
        "regions": len(m.regions),
        "gateways": len(m.gateways),
        "objects": len(m.objects),
    }


def _scans(log: ScanLog) -> dict[str, Any]:
    echo, silent = np.isfinite(log.ranges), np.isinf(log.ranges)
    found: dict[str, Any] = {
        "format": log.format,
        "scans": len(log),
        "beams": len(log.bearings),
        "field_of_view": round(float(np.ptp(log.bearings)), 4),
        "max_range": round(log.max_range, 3),
        "echoes": round(float(echo.mean()), 4),
        "no_echo": round(float(silent.mean()), 4),
        "laser": [round(v, 4) for v in log.base_from_laser.tolist()],
        "seconds": round(float(np.ptp(log.stamps)), 2) if len(log) else 0.0,
        "odometry": log.has_odometry,
        "notes": log.notes.splitlines(),
    }
    if log.has_odometry:
        steps = np.diff(log.odom_from_base[:, :2], axis=0)
        found["way"] = round(float(np.hypot(*steps.T).sum()), 2)
    return found


def print_description(f: dict[str, Any]) -> None:
    """The same for a person, on stdout."""
    console = Console() if sys.stdout.isatty() else Console(width=PIPED)
    told = {k: _spoken(k, v) for k, v in f.items() if k not in ("file", "topics", "notes")}
    table = Table(title=f["file"], title_justify="left", show_header=False)
    for name, value in told.items():
        table.add_row(name.replace("_", " "), value)
    console.print(table)
    if "topics" in f:
        topics = Table("topic", "type", "messages")
        for t in f["topics"]:
            topics.add_row(t["name"], t["type"], str(t["messages"]))
        console.print(topics)
    for note in f.get("notes", []):
        console.print(f"note: {note}", markup=False, highlight=False)


def _spoken(name: str, value: Any) -> str:
    if name == "field_of_view":
        return f"{math.degrees(value):.1f}°"
    if name in ("max_range", "way"):
        return f"{value:g} m"
    if name in ("echoes", "no_echo"):
        return f"{100 * value:.1f} %"
    if name == "laser":
        return f"{value[0]:g} m ahead, {value[1]:g} m to the left, turned by {math.degrees(value[2]):.1f}°"
    if name == "odometry":
        return "yes" if value else "no"
    return str(value)
