"""What of the readings any map could explain: ``python tests/bench/bench_explained.py [NAME ...]``, all logs in turn.

For each log the lines and, beside them, an occupancy grid of 5 cm made of the same scans at the same poses: reading
by reading both are asked for the range, nearer than 12 m. A cell is occupied that more beams end in than a share of
those that pass it; the share (a quarter, a half, all) is the one that explains most. Of what the lines miss by more
than 10 cm, *seen through* are the readings that end where more beams pass than end: people, doors that moved, glimpses.
"""

from __future__ import annotations

import sys

import numpy as np
from bench_logs import DATA, name
from rich.console import Console
from rich.table import Table

from rgcore.config import Config
from rgcore.geometry.grid import reach
from rgcore.lines.accuracy import predict
from rgcore.pipeline import Run, run
from rgcore.places.freespace import tips_of
from rgcore.scans.read import read_log
from rgviz.demo import LOG

C = Config()
SHARES = (0.25, 0.5, 1.0)
FEW = 20
GOAL = 0.2
HEADS = (
    *("log", "lines", "factor", "worst acc(R)", "over 200 mm", "median", "in 5 cm", "in 10 cm", "missed"),
    *("seen through", "cells", "in 10 cm", "missed"),
)


def main(wanted: list[str]) -> None:
    logs = [LOG, *sorted(DATA.glob("logs/*.gz")), *sorted(DATA.glob("runs/*.log.gz"))]
    table = Table(title="the lines | of what they miss | a grid of 5 cm", title_justify="left")
    for head in HEADS:
        table.add_column(head, justify="left" if head == "log" else "right")
    for path in logs:
        if not wanted or name(path) in wanted:
            table.add_row(name(path), *row(run(read_log(path))))
    Console(width=180).print(table)


def row(mapped: Run) -> list[str]:
    log, where = mapped.log, mapped.trajectory.map_from_laser
    usable = log.usable(C.accuracy.max_range)
    lines = off(mapped, predict(mapped.lines.ends, where, log.bearings, C.accuracy.max_range + 1.0), usable)
    far = lines > 0.1
    tips = tips_of(where, log.bearings, np.where(usable, log.ranges, 0.0))[usable]
    hits, passes = (mapped.free.grid(v).at(tips) for v in (mapped.free.hits, mapped.free.passes))
    ranges, cells = best_grid(mapped, usable)
    worst, over, regions = by_region(mapped)
    return [
        str(len(mapped.lines)),
        f"{len(mapped.segments) / max(1, len(mapped.lines)):.1f}",
        f"{1000 * worst:.0f} mm",
        f"{over} of {regions}",
        f"{1000 * np.median(lines):.0f} mm",
        *(f"{(lines <= d).mean():.1%}" for d in (0.05, 0.1)),
        f"{(lines > 1.0).mean():.1%}",
        f"{(passes > hits)[far].mean():.0%}",
        f"{cells:,}",
        f"{(ranges <= 0.1).mean():.1%}",
        f"{(ranges > 1.0).mean():.1%}",
    ]


def off(mapped: Run, predicted: np.ndarray, usable: np.ndarray) -> np.ndarray:
    """(K,) [m] how far the usable readings are off; inf where nothing is predicted."""
    return np.asarray(np.abs(predicted[usable] - mapped.log.ranges[usable]))


def best_grid(mapped: Run, usable: np.ndarray) -> tuple[np.ndarray, int]:
    """How far readings are off the grid that explains most, and the number of its occupied cells."""
    free, poses = mapped.free, mapped.trajectory.map_from_laser
    turn = poses[:, 2:] + mapped.log.bearings
    ahead = np.stack([np.cos(turn), np.sin(turn)], -1).reshape(-1, 2)
    starts = np.repeat((poses[:, :2] - free.origin) / free.resolution, turn.shape[1], 0)
    limit = (C.accuracy.max_range + 1.0) / free.resolution
    found = []
    for share in SHARES:
        occupied = free.hits > share * free.passes
        cells = reach(~occupied, starts, ahead, limit)
        ranges = np.where(cells <= limit, (cells + 0.25) * free.resolution, np.inf)  # steps of half a cell
        found.append((off(mapped, ranges.reshape(turn.shape), usable), int(occupied.sum())))
    return max(found, key=lambda f: float((f[0] <= 0.1).mean()))


def by_region(mapped: Run) -> tuple[float, int, int]:
    """The worst acc(R) [m] of the regions with enough scans, how many of them exceed the goal, how many they are."""
    where = mapped.places.labels.at(mapped.trajectory.map_from_base[:, :2], outside=-1)
    here = [where == k for k in range(len(mapped.places.regions)) if (where == k).sum() >= FEW]
    found = [a for a in map(mapped.accuracy.of, here) if a is not None]
    return max(found, default=0.0), sum(a > GOAL for a in found), len(found)


if __name__ == "__main__":
    main(sys.argv[1:])
