"""Places of every run with a truth: one row a run, the mean, and how far the confidence of gateways can be believed.

    python tests/bench/bench_places.py [NAME ...]

Rooms and gateways are scored by the tool beside the data. ``sure`` of the right of the table: of the gateways with a
confidence in each band, how many lie on a true one (within 0.75 m; those on doubtful truths count for neither).
``share``: CPU time of free space, places, classes and objects over that of the whole run, kernels compiled before.
"""

from __future__ import annotations

import itertools
import json
import sys
import tempfile
import time
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from rgcore import pipeline
from rgcore.exports.formats import export
from rgcore.progress import Progress
from rgcore.scans.read import read_log

DATA = Path(__file__).parents[2] / "../shared/data"
OURS = ("freespace", "places", "classes", "objects")
BANDS = (0.0, 0.6, 0.8, 0.9, 0.97, 1.0001)
COLUMNS = {
    "room_precision": "room P",
    "room_recall": "room R",
    "room_f1": "room F1",
    "gateway_precision": "gate P",
    "gateway_recall": "gate R",
    "gateway_f1": "gate F1",
    "width_error_median": "width m",
    "hallway_agreement": "hallway",
    "cabinet_recall": "cabinets",
}


def main(wanted: list[str]) -> None:
    runs = sorted(p.name.removesuffix(".truth.json") for p in DATA.glob("runs/*.truth.json"))
    tool = scorer()
    rows, sure = [], []
    pipeline.run(read_log(log_of(runs[0])))
    for name in (r for r in runs if not wanted or r in wanted):
        with tempfile.TemporaryDirectory() as folder:
            row = one(name, Path(folder), tool)
        sure.append(row.pop("sure"))
        rows.append(row)
    show(rows)
    reliability(np.concatenate(sure))


def log_of(run: str) -> Path:
    own = DATA / f"runs/{run}.log.gz"
    return own if own.exists() else DATA / f"logs/{run.removesuffix('-real')}.log.gz"


def scorer() -> Any:
    loader = SourceFileLoader("score_places", str(DATA.parent / "tools/score_places.py"))
    tool = module_from_spec(spec_from_loader("score_places", loader))  # type: ignore[arg-type]
    loader.exec_module(tool)
    return tool


def one(name: str, folder: Path, tool: Any) -> dict[str, Any]:
    """Map one run; its scores, seconds of CPU by stage, and (confidence, right) of its gateways."""
    seconds: dict[str, float] = {}

    def watch(p: Progress) -> None:
        now = time.process_time()
        seconds[p.stage] = now if p.done == 0 else now - seconds[p.stage]

    began = time.process_time()
    run = pipeline.run(read_log(log_of(name)), watch=watch)
    total = time.process_time() - began
    for ending in ("json", "tum"):
        export(folder / f"map.{ending}", run.map, run.trajectory)
    files = str(folder / "map.json"), str(folder / "map.tum"), str(DATA / "runs" / name)
    scores = tool.score(*files)
    found = round((scores["cabinet_recall"] or 0) * scores["cabinets"])
    return scores | {
        "name": name,
        "false": scores["objects"] - found if scores["cabinets"] else None,
        "seconds": sum(seconds[s] for s in OURS),
        "share": sum(seconds[s] for s in OURS) / total,
        "sure": believed(*files, tool),
    }


def believed(map_json: str, tum: str, run: str, tool: Any) -> np.ndarray:
    """(K, 2) confidence of each gateway, and whether a true one is there; doubtful ones are left out."""
    gateways = json.loads(Path(map_json).read_text())["gateways"]
    true = json.loads(Path(f"{run}.truth.json").read_text())["gateways"]
    turn, move, *_ = tool.align(tool.load_tum(tum), tool.load_tum(f"{run}.poses.tum"))
    middle = np.array([np.mean(g["posts"], 0) for g in gateways]).reshape(-1, 2) @ turn.T + move
    there = np.array([np.mean(g["posts"], 0) for g in true]).reshape(-1, 2)
    pairs = dict(tool.greedy(-np.linalg.norm(middle[:, None] - there[None], axis=2), -0.75))
    doubtful = {j for j, g in enumerate(true) if g.get("kind") == "uncertain"}
    rows = [(g["confidence"], i in pairs) for i, g in enumerate(gateways) if pairs.get(i) not in doubtful]
    return np.array(rows, float).reshape(-1, 2)


def show(rows: list[dict[str, Any]]) -> None:
    table = Table(title="places", title_justify="left")
    for head in ("run", *COLUMNS.values(), "false / true objects", "s", "share %"):
        table.add_column(head, justify="left" if head == "run" else "right")
    mean = {k: _mean([r[k] for r in rows]) for k in (*COLUMNS, "seconds", "share", "false", "cabinets")}
    for r in [*rows, mean | {"name": "mean"}]:
        objects = "-" if r["false"] is None else f"{r['false']:.0f} / {r['cabinets']:.0f}"
        values = [number(r[k]) for k in COLUMNS]
        table.add_row(r["name"], *values, objects, f"{r['seconds']:.2f}", f"{100 * r['share']:.1f}")
    Console(width=180).print(table)


def reliability(sure: np.ndarray) -> None:
    table = Table(title="confidence of gateways", title_justify="left")
    for head in ("from", "to", "gateways", "mean confidence", "right"):
        table.add_column(head, justify="right")
    for low, high in itertools.pairwise(BANDS):
        band = sure[(sure[:, 0] >= low) & (sure[:, 0] < high)]
        if len(band):
            confidence, right = band.mean(0)
            table.add_row(f"{low:g}", f"{min(high, 1):g}", str(len(band)), f"{confidence:.3f}", f"{right:.3f}")
    Console(width=180).print(table)


def _mean(values: list[float | None]) -> float | None:
    known = [v for v in values if v is not None]
    return float(np.mean(known)) if known else None


def number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


if __name__ == "__main__":
    main(sys.argv[1:])
