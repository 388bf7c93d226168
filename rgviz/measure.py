"""The figures of a map: the paper's table I for the whole and by region, with accuracy and axes."""

from __future__ import annotations

import math
from typing import Any

from rich.console import Console
from rich.table import Table

from rgcore.model.project import Project


def figures(project: Project) -> dict[str, Any]:
    """Counts, reduction factor (segments / lines), accuracy [m] for the map and by region, axes [rad], seconds by stage."""
    m, s = project.map, project.map.stats
    return {
        "project": str(project.path),
        "scans": s.scans,
        "points": s.points,
        "segments": s.segments,
        "lines": len(m.lines),
        "reduction": round(s.segments / max(len(m.lines), 1), 2),
        "accuracy": s.accuracy,
        "accuracy_penalty": s.accuracy_penalty,
        "gateways": len(m.gateways),
        "objects": len(m.objects),
        "seconds": project.run_info.seconds,
        "regions": [
            {
                "id": r.id,
                "name": r.name,
                "class": r.class_,
                "lines": len(m.lines_of(r.id)),
                "scans": r.scans,
                "accuracy": r.accuracy,
                "axes": list(r.axes),
                "gateways": m.gateways_of(r.id),
            }
            for r in m.regions.values()
        ],
    }


def print_tables(f: dict[str, Any]) -> None:
    """The figures as tables on stdout; angles in degrees, accuracy in millimetres as the paper prints them."""
    console = Console()
    total = Table(title=f["project"], title_justify="left")
    for head in ("scans", "points", "segments", "lines", "factor", "accuracy", "regions", "gateways", "objects"):
        total.add_column(head, justify="right")
    total.add_row(
        *map(str, (f["scans"], f["points"], f["segments"], f["lines"], f["reduction"])),
        _mm(f["accuracy"]),
        *map(str, (len(f["regions"]), f["gateways"], f["objects"])),
    )
    console.print(total)
    table = Table()
    for head in ("region", "name", "class"):
        table.add_column(head)
    for head in ("scans", "lines", "axis 1", "axis 2", "accuracy", "gateways"):
        table.add_column(head, justify="right")
    for r in f["regions"]:
        axes = [f"{math.degrees(a):.0f}°" for a in r["axes"]] + ["", ""]
        table.add_row(
            r["id"], r["name"], r["class"], str(r["scans"]), str(r["lines"]), axes[0], axes[1], _mm(r["accuracy"]), str(len(r["gateways"]))
        )
    console.print(table)
    console.print(f"accuracy with a penalty of {f['accuracy_penalty']} m for a reading that no line predicts")


def _mm(metres: float | None) -> str:
    return "-" if metres is None else f"{1000 * metres:.0f} mm"
