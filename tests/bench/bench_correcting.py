"""The cost of correcting: how many edits lead from the automatic map of each run with a truth to the true one.

    python tests/bench/bench_correcting.py [NAME ...] [--edits] [--alike 0.5]

The edits are found as ``correcting.py`` says, with the very edits of the browser. Per run: rooms that count, F1 of
rooms and gateways before and after (by the tool beside the data, which has no part in choosing), edits by kind, edits
per ten rooms; apart from these the relabels that the truth asks for. ``--edits`` tells each edit; ``--alike``: the
intersection over union from which on a region is its room (the tool's F1 stays that at 0.5).
"""

from __future__ import annotations

import argparse
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from bench_places import DATA, log_of, number, scorer
from correcting import Corrected, Truth, correct
from rich.console import Console
from rich.table import Table

from rgcore import pipeline
from rgcore.exports.formats import export
from rgcore.model.records import RGMap
from rgcore.scans.read import read_log
from rgcore.slam.trajectory import Trajectory

HEADS = ("run", "rooms", "room F1", "after", "gate F1", "after", "edits", "per 10 rooms", "relabels", "by kind")


def main() -> None:
    asked = argparse.ArgumentParser()
    asked.add_argument("names", nargs="*")
    asked.add_argument("--edits", action="store_true")
    asked.add_argument("--alike", type=float, default=0.5)
    args = asked.parse_args()
    runs = sorted(p.name.removesuffix(".truth.json") for p in DATA.glob("runs/*.truth.json"))
    rows = []
    for name in (r for r in runs if not args.names or r in args.names):
        made = pipeline.run(read_log(log_of(name)))
        rows.append(corrected(name, made.map, made.trajectory, scorer(), args.alike))
        if args.edits:
            print(*_told(rows[-1]["done"], made.map), sep="\n")
    show(rows)


def corrected(name: str, map_: RGMap, trajectory: Trajectory, tool: Any, alike: float = 0.5) -> dict[str, Any]:
    """What correcting the map of a run costs, and its scores before and after."""
    run = str(DATA / "runs" / name)
    with tempfile.TemporaryDirectory() as folder:
        tum = str(Path(folder) / "map.tum")
        export(tum, map_, trajectory)
        turn, move, *_ = tool.align(tool.load_tum(tum), tool.load_tum(f"{run}.poses.tum"))
        truth = Truth.of(Path(f"{run}.truth.json"), Path(f"{run}.rooms.png"), turn, move, alike)
        done = correct(map_, truth)
        scores = []
        for state in (map_, done.map):
            export(Path(folder) / "map.json", state, trajectory)
            scores.append(tool.score(str(Path(folder) / "map.json"), tum, run))
    return {"name": name, "rooms": len(truth.ids), "before": scores[0], "after": scores[1], "done": done}


def show(rows: list[dict[str, Any]]) -> None:
    table = Table(title="cost of correcting", title_justify="left")
    for head in HEADS:
        table.add_column(head, justify="left" if head in ("run", "by kind") else "right")
    for r in rows:
        kinds = Counter(type(e).__name__ for e in r["done"].edits)
        f1 = [number(r[when][f"{what}_f1"]) for what in ("room", "gateway") for when in ("before", "after")]
        counts = len(r["done"].edits), 10 * len(r["done"].edits) / r["rooms"], len(r["done"].classes)
        by_kind = ", ".join(f"{n} {k}" for k, n in kinds.most_common())
        table.add_row(r["name"], str(r["rooms"]), *f1, str(counts[0]), f"{counts[1]:.2f}", str(counts[2]), by_kind)
    edits, rooms = sum(len(r["done"].edits) for r in rows), sum(r["rooms"] for r in rows)
    relabels = sum(len(r["done"].classes) for r in rows)
    mean = [
        number(float(np.mean([r[when][f"{what}_f1"] for r in rows])))
        for what in ("room", "gateway")
        for when in ("before", "after")
    ]
    each = float(np.mean([10 * len(r["done"].edits) / r["rooms"] for r in rows]))
    pooled = f"{10 * edits / rooms:.2f} over all rooms"
    table.add_row("mean", str(rooms), *mean, str(edits), f"{each:.2f}", str(relabels), pooled)
    Console(width=200).print(table)


def _told(done: Corrected, map_: RGMap) -> list[str]:
    out = []
    for edit in done.edits + done.classes:
        out.append(f"  {edit.title(map_)}")
        map_ = edit.apply(map_)
    return out


if __name__ == "__main__":
    main()
