"""Every log that is there, through the whole pipeline, one process each: speed by stage, memory, compactness, accuracy.

    python tests/bench/bench_logs.py [NAME ...]

CPU time of the whole process, kernels compiled before; what their compilation takes stands above the table.
Trajectories are scored against hand-checked relations or true poses, regions and gateways against annotated ones, by
the scoring tools that lie beside the data.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

DATA = Path(__file__).parents[2] / "../shared/data"
TOOLS = DATA.parent / "tools"
RELATIONS = {
    "intel": ["intel-by-row.relations", "--odometry", "intel-odometry.csv.gz", "--rows=-4,5"],
    "intel-dense": ["intel-by-row.relations", "--odometry", "intel-odometry.csv.gz", "--rows=0,1"],
    "fr079": ["fr079.relations", "--forward", "0.04"],
}
GROUPS = {
    "read": ("read", "extract"),
    "poses": ("slam",),
    "places": ("freespace", "places"),
    "adapt": ("adapt",),
    "lines": ("lines",),
    "rest": ("accuracy", "classes", "objects"),
}
"""Columns of the table, and the stages that they sum."""


def main(wanted: list[str]) -> None:
    from rgviz.demo import LOG

    logs = [LOG, *sorted(DATA.glob("logs/*.gz")), *sorted(DATA.glob("runs/*.log.gz"))]
    logs = [p for p in logs if not wanted or name(p) in wanted]
    if len(logs) == 1 and not wanted:
        print(f"{DATA.resolve()} is absent: only the demo log is measured")
    with tempfile.TemporaryDirectory() as folder:
        fresh = os.environ | {"NUMBA_CACHE_DIR": folder}
        first, again = (child(LOG, Path(folder), fresh)["cpu"] for _ in range(2))
        child(LOG, Path(folder), os.environ)
    print(f"compilation of the kernels, once: {first - again:.0f} s of CPU time\n")
    rows = []
    for log in logs:
        with tempfile.TemporaryDirectory() as folder:
            row = child(log, Path(folder), os.environ)
            rows.append(row | {"name": name(log)} | score(log, Path(folder)))
    print_speed(rows)
    print_maps(rows)


def child(log: Path, folder: Path, environment: Mapping[str, str]) -> dict[str, Any]:
    """:func:`one` in a process of its own."""
    command = [sys.executable, __file__, "--one", str(log), str(folder)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, env=environment)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def name(log: Path) -> str:
    return log.name.split(".")[0]


def one(log_path: Path, folder: Path) -> dict[str, Any]:
    """Map one log in this process; counts, seconds by stage, memory."""
    from rgcore import pipeline
    from rgcore.exports.formats import export
    from rgcore.progress import Progress
    from rgcore.scans.read import read_log

    began = time.process_time()
    log = read_log(log_path)
    read = time.process_time() - began
    began_at: dict[str, float] = {}
    seconds = {"read": read}

    def watch(p: Progress) -> None:
        if p.done == 0:
            began_at[p.stage] = time.process_time()
        seconds[p.stage] = time.process_time() - began_at[p.stage]

    run = pipeline.run(log, watch=watch)
    cpu = time.process_time() - began
    for ending in ("json", "tum"):
        export(folder / f"map.{ending}", run.map, run.trajectory)
    m = run.map
    seen = run.accuracy.readings.sum()
    return {
        "scans": len(log),
        "cpu": cpu,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "seconds": seconds,
        "segments": m.stats.segments,
        "lines": len(m.lines),
        "regions": len(m.regions),
        "gateways": len(m.gateways),
        "accuracy": m.stats.accuracy,
        "median": float(np.nanmedian(run.accuracy.median)),
        "missed": float(run.accuracy.missed.sum() / seen) if seen else None,
    }


def score(log: Path, folder: Path) -> dict[str, Any]:
    """What the scoring tools say: relations, and rooms and gateways of the run of the same name."""
    out: dict[str, Any] = {}
    key = name(log)
    if key in RELATIONS:
        args = [str(DATA / "relations" / a) if (DATA / "relations" / a).exists() else a for a in RELATIONS[key]]
        out |= tool("score_relations.py", folder / "map.tum", *args)
    runs = {"fr079": DATA / "runs/fr079-real", "office": log.parent / "office"}
    truth = runs.get(key, log.parent / key)
    if truth.with_name(truth.name + ".truth.json").exists() and TOOLS.exists():
        out |= tool("score_places.py", folder / "map.json", folder / "map.tum", truth)
    return {k: v for k, v in out.items() if k not in ("regions", "gateways", "objects", "poses")}


def tool(script: str, *args: object) -> dict[str, Any]:
    command = [sys.executable, str(TOOLS / script), *map(str, args)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def print_speed(rows: list[dict[str, Any]]) -> None:
    title = "scans a second of CPU time, by stage and whole; segments a line; errors of lines and poses; F1 of places"
    table = Table(title=title, title_justify="left", box=box.MARKDOWN)
    heads = ("log", "scans", *GROUPS, "whole", "MB", "reduction", "acc(R) mm", "median mm")
    for head in (*heads, "relations m", "deg", "ATE m", "rooms", "gateways"):
        table.add_column(head, justify="left" if head == "log" else "right", no_wrap=True)
    for r in rows:
        stages = [r["scans"] / max(1e-3, sum(r["seconds"].get(s, 0.0) for s in group)) for group in GROUPS.values()]
        table.add_row(
            r["name"],
            str(r["scans"]),
            *(f"{s:.0f}" for s in stages),
            f"{r['scans'] / r['cpu']:.0f}",
            f"{r['memory']:.0f}",
            f"{r['segments'] / max(r['lines'], 1):.1f}",
            *(number(r[k], 0, 1000) for k in ("accuracy", "median")),
            number(r.get("trans_mean"), 4),
            number(r.get("rot_mean"), 2),
            number(r.get("ate_rmse"), 3),
            *(number(r.get(k), 2) for k in ("room_f1", "gateway_f1")),
        )
    Console(width=220).print(table)


def print_maps(rows: list[dict[str, Any]]) -> None:
    table = Table(title="more of the maps", title_justify="left", box=box.MARKDOWN)
    heads = ("log", "seconds", "lines", "missed %", "regions", "room P / R", "gateways", "width m", "cabinets")
    for head in heads:
        table.add_column(head, justify="left" if head == "log" else "right", no_wrap=True)
    for r in rows:
        table.add_row(
            r["name"],
            f"{r['cpu']:.1f}",
            str(r["lines"]),
            number(r["missed"], 1, 100),
            str(r["regions"]),
            f"{number(r.get('room_precision'), 2)} / {number(r.get('room_recall'), 2)}",
            str(r["gateways"]),
            number(r.get("width_error_median"), 2),
            number(r.get("cabinet_recall"), 2),
        )
    Console(width=220).print(table)


def number(value: float | None, digits: int, factor: float = 1) -> str:
    return "-" if value is None or not np.isfinite(value) else f"{value * factor:.{digits}f}"


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(one(Path(sys.argv[2]), Path(sys.argv[3]))))
    else:
        main(sys.argv[1:])
