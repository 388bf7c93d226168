"""Every log that is there, through the whole pipeline, one process each: speed by stage, memory, compactness, accuracy.

    python tests/bench/bench_logs.py [NAME ...]

CPU time, kernels compiled before. Trajectories are scored against hand-checked relations or true poses, regions and
gateways against annotated ones, by the scoring tools that lie beside the data.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

DATA = Path(__file__).parents[2] / "../shared/data"
TOOLS = DATA.parent / "tools"
RELATIONS = {
    "intel": ["intel-by-row.relations", "--odometry", "intel-odometry.csv.gz", "--rows=-4,5"],
    "intel-dense": ["intel-by-row.relations", "--odometry", "intel-odometry.csv.gz", "--rows=0,1"],
    "fr079": ["fr079.relations", "--forward", "0.04"],
}
STAGES = ("read", "extract", "slam", "freespace", "places", "lines", "accuracy", "objects")


def main(wanted: list[str]) -> None:
    from rgviz.demo import LOG

    logs = [LOG, *sorted(DATA.glob("logs/*.gz")), *sorted(DATA.glob("runs/*.log.gz"))]
    logs = [p for p in logs if not wanted or name(p) in wanted]
    if len(logs) == 1 and not wanted:
        print(f"{DATA.resolve()} is absent: only the demo log is measured")
    subprocess.run([sys.executable, __file__, "--one", str(LOG), tempfile.mkdtemp()], check=True, capture_output=True)
    rows = []
    for log in logs:
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(
                [sys.executable, __file__, "--one", str(log), folder], check=True, capture_output=True, text=True
            )
            rows.append(json.loads(done.stdout) | {"name": name(log)} | score(log, Path(folder)))
    print_speed(rows)
    print_maps(rows)


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
    table = Table(title="speed: scans a second of CPU time, all stages; seconds by stage", title_justify="left")
    for head in ("log", "scans", "scans/s", "MB", *STAGES):
        table.add_column(head, justify="left" if head == "log" else "right")
    for r in rows:
        stages = [f"{r['seconds'].get(s, 0):.2f}" for s in STAGES]
        table.add_row(r["name"], str(r["scans"]), f"{r['scans'] / r['cpu']:.0f}", f"{r['memory']:.0f}", *stages)
    Console(width=200).print(table)


def print_maps(rows: list[dict[str, Any]]) -> None:
    table = Table(title="maps", title_justify="left")
    heads = ("log", "lines", "factor", "acc(R) mm", "median mm", "missed %", "relations m", "deg", "ATE m")
    for head in (*heads, "regions", "room P / R", "F1", "gateways", "gateway F1", "width m", "cabinets"):
        table.add_column(head, justify="left" if head == "log" else "right")
    for r in rows:
        table.add_row(
            r["name"],
            str(r["lines"]),
            f"{r['segments'] / max(r['lines'], 1):.1f}",
            number(r["accuracy"], 0, 1000),
            number(r["median"], 0, 1000),
            number(r["missed"], 1, 100),
            number(r.get("trans_mean"), 4),
            number(r.get("rot_mean"), 2),
            number(r.get("ate_rmse"), 3),
            str(r["regions"]),
            f"{number(r.get('room_precision'), 2)} / {number(r.get('room_recall'), 2)}",
            number(r.get("room_f1"), 2),
            str(r["gateways"]),
            number(r.get("gateway_f1"), 2),
            number(r.get("width_error_median"), 2),
            number(r.get("cabinet_recall"), 2),
        )
    Console(width=200).print(table)


def number(value: float | None, digits: int, factor: float = 1) -> str:
    return "-" if value is None or not np.isfinite(value) else f"{value * factor:.{digits}f}"


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(one(Path(sys.argv[2]), Path(sys.argv[3]))))
    else:
        main(sys.argv[1:])
