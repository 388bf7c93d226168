"""The figures of a map: the paper's table I for the whole and by region, with accuracy and axes."""

from __future__ import annotations

import math
import sys
from dataclasses import asdict
from typing import Any

from rich.console import Console
from rich.table import Table

from rgcore.exports.report import ENOUGH, Fit, fits
from rgcore.model.project import Project
from rgcore.slam.relations import RelationError

PIPED = 160
"""Columns of the tables where no terminal sets them: nothing is cut off in a file or a pipe."""


FIT = ("median off", "in 5 cm", "in 10 cm", "missed")


def figures(project: Project) -> dict[str, Any]:
    """Counts, reduction factor (segments / lines), accuracy [m], axes [rad]; for the map and by region; s by stage."""
    m, s = project.map, project.map.stats
    whole, own = fits(project)
    return {
        "project": str(project.path),
        "scans": s.scans,
        "points": s.points,
        "segments": s.segments,
        "lines": len(m.lines),
        "reduction": round(s.segments / max(len(m.lines), 1), 2),
        "accuracy": s.accuracy,
        "accuracy_penalty": s.accuracy_penalty,
        "fit": _fit(whole),
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
                "fit": _fit(own[r.id]),
                "axes": list(r.axes),
                "gateways": m.gateways_of(r.id),
            }
            for r in m.regions.values()
        ],
    }


def _fit(found: Fit | None) -> dict[str, Any] | None:
    """Median [m] of the readings that a line predicts, and shares of all readings; None: not enough evidence."""
    if found is None:
        return None
    shares = {"within_5_cm": found.within_5, "within_10_cm": found.within_10, "missed": found.missed}
    median = None if math.isnan(found.median) else round(found.median, 5)
    return {"readings": found.echoes, "median": median, **{k: round(v, 5) for k, v in shares.items()}}


def relation_figures(error: RelationError) -> dict[str, float]:
    """The figures of a trajectory, as the benchmark gives them: translation [m], rotation [degrees]."""
    figures = asdict(error)
    return {k: round(math.degrees(v), 5) if k.startswith("rot") else round(v, 5) for k, v in figures.items()}


def print_tables(f: dict[str, Any]) -> None:
    """The figures as tables on stdout; angles in degrees, accuracy in millimetres as the paper prints them."""
    console = Console() if sys.stdout.isatty() else Console(width=PIPED)
    total = Table(title=f["project"], title_justify="left")
    for head in ("scans", "points", "segments", "lines", "factor", "accuracy", *FIT, "regions", "gateways", "objects"):
        total.add_column(head, justify="right")
    total.add_row(
        *map(str, (f["scans"], f["points"], f["segments"], f["lines"], f["reduction"])),
        _mm(f["accuracy"]),
        *_fit_cells(f["fit"]),
        *map(str, (len(f["regions"]), f["gateways"], f["objects"])),
    )
    console.print(total)
    table = Table()
    for head in ("region", "name", "class"):
        table.add_column(head)
    for head in ("scans", "lines", "axis 1", "axis 2", "accuracy", *FIT, "gateways"):
        table.add_column(head, justify="right")
    for r in f["regions"]:
        axes = [f"{math.degrees(a):.0f}°" for a in r["axes"]] + ["", ""]
        table.add_row(
            r["id"],
            r["name"],
            r["class"],
            str(r["scans"]),
            str(r["lines"]),
            axes[0],
            axes[1],
            _mm(r["accuracy"]),
            *_fit_cells(r["fit"]),
            str(len(r["gateways"])),
        )
    console.print(table)
    if r := f.get("relations"):
        console.print(
            f"trajectory over {r['matched']} of {r['relations']} relations:"
            f" {r['trans_mean']:.4f} +- {r['trans_std']:.4f} m,"
            f" {r['rot_mean']:.3f} +- {r['rot_std']:.3f} degrees; worst {r['trans_max']:.3f} m"
        )
    console.print(f"accuracy with a penalty of {f['accuracy_penalty']} m for a reading that no line predicts")
    console.print(
        "median off and shares: of the readings of a sample of the scans, projected back from the map as it stands;"
        f" - where fewer than {ENOUGH} scans were taken"
    )


def _fit_cells(found: dict[str, Any] | None) -> list[str]:
    if found is None:
        return ["-"] * len(FIT)
    return [_mm(found["median"]), *(f"{100 * found[k]:.1f}%" for k in ("within_5_cm", "within_10_cm", "missed"))]


def _mm(metres: float | None) -> str:
    return "-" if metres is None else f"{1000 * metres:.0f} mm"
