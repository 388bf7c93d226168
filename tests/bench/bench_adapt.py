"""What adaptation gains: ``python tests/bench/bench_adapt.py [NAME ...]``, all logs that are there, in turn.

For each log lines and acc of the merged map, as configured, with the best single setting of all that are tried, and
adapted region by region; then the same of the finished map, for which settings are chosen: regions that miss the goal
of accuracy take more lines there. CPU time.
"""

from __future__ import annotations

import sys
import time

import msgspec
import numpy as np
from bench_logs import DATA, name
from rich.console import Console
from rich.table import Table

from rgcore import pipeline
from rgcore.config import Config
from rgcore.lines.accuracy import measure_accuracy
from rgcore.lines.complete import complete_lines
from rgcore.lines.merge import merge_lines
from rgcore.places.regions import region_of_segments
from rgcore.scans.read import read_log
from rgviz.demo import LOG

C = Config()


def main(wanted: list[str]) -> None:
    logs = [LOG, *sorted(DATA.glob("logs/*.gz")), *sorted(DATA.glob("runs/*.log.gz"))]
    pipeline.run(read_log(LOG)[:200])  # compiles
    table = Table(title="lines / acc(R) in mm: merged | finished", title_justify="left")
    heads = ("configured", "best single", "adapted")
    for head in ("log", "regions", *heads, *heads, "time of adapting / run"):
        table.add_column(head, justify="left" if head == "log" else "right")
    for path in logs:
        if not wanted or name(path) in wanted:
            table.add_row(name(path), *row(path))
    Console(width=170).print(table)


def row(path: object) -> list[str]:
    """The cells of one log."""
    log = read_log(path)  # type: ignore[arg-type]
    seconds, began = {}, {}

    def watch(p: object) -> None:
        began.setdefault(p.stage, time.process_time())  # type: ignore[attr-defined]
        seconds[p.stage] = time.process_time() - began[p.stage]  # type: ignore[attr-defined]

    run = pipeline.run(log, C, watch=watch)
    fitted, s, t, labels = run.adaptation, run.segments, run.trajectory, run.places.labels
    region = region_of_segments(s, t, run.places)
    single = msgspec.structs.replace(C.lines, **fitted.tried[fitted.map.chosen])
    merged, finished = [], []
    for by_region in ((), (single,) * len(fitted.regions), fitted.settings(C.lines)):
        lines, line_of = merge_lines(s, t, region, C.lines, by_region)
        merged.append(outcome(log, t, lines.ends))
        at = lambda points: labels.at(points, outside=-1)  # noqa: E731
        finished.append(outcome(log, t, complete_lines(lines, line_of, log, s, t, at, C.lines, by_region)[0].ends))
    rest = sum(v for k, v in seconds.items() if k != "adapt")
    return [str(len(run.places.regions)), *merged, *finished, f"{seconds['adapt']:.1f} / {rest:.1f} s"]


def outcome(log: object, trajectory: object, ends: np.ndarray) -> str:
    a = measure_accuracy(log, trajectory, ends, C.accuracy)  # type: ignore[arg-type]
    return f"{len(ends)} / {1000 * a.of(np.arange(len(a.scan))):.1f}"  # type: ignore[operator]


if __name__ == "__main__":
    main(sys.argv[1:])
