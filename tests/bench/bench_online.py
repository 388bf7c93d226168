"""Mapping online against the batch: milliseconds a scan, and how far what it told is what the finished map says.

    python tests/bench/bench_online.py [NAME ...]

CPU time of the calling thread for ``add`` alone; surveys run beside it and count in the last column. Told: share of the
scans for which the region told at once is the region of the batch, with classes, and without the scans at which nothing
was told because the robot was entering an unknown region. Settled: the same for the last map so far, told afterwards.
Back: share of the returns to a region that were recognised with the right one.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

DATA = Path(__file__).parents[2] / "../shared/data"
COLUMNS = {
    "scans": "{}",
    "median": "{:.2f}",
    "p99": "{:.1f}",
    "max": "{:.0f}",
    "all": "{:.2f}",
    "told": "{:.3f}",
    "known": "{:.3f}",
    "settled": "{:.3f}",
    "class": "{:.3f}",
    "back": "{}",
    "regions": "{}",
}


def main(wanted: list[str]) -> None:
    from rgviz.demo import LOG

    real = [DATA / "logs" / f"{name}.log.gz" for name in ("intel", "intel-dense", "fr079")]
    logs = [LOG, *(p for p in real if p.exists()), *sorted(DATA.glob("runs/*.log.gz"))]
    table = Table(title="online: ms a scan (CPU), and agreement with the batch", title_justify="left")
    for head in ("log", *COLUMNS):
        table.add_column(head, justify="left" if head == "log" else "right")
    for log in logs:
        name = log.name.split(".")[0]
        if not wanted or name in wanted:
            command = [sys.executable, __file__, "--one", str(log)]
            r = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
            table.add_row(name, *(form.format(r[key]) for key, form in COLUMNS.items()))
    Console(width=160).print(table)


def one(path: Path) -> dict[str, Any]:
    """Map one log online and in batch, in this process."""
    from rgcore.online import Mapper
    from rgcore.places.automaton import RegionRecognised
    from rgcore.scans.read import read_log

    log = read_log(path)
    feed(Mapper.of(log[:60]), log[:60])  # compiles
    mapper = Mapper.of(log)
    began = time.process_time()
    steps, seconds = feed(mapper, log)
    cpu = time.process_time() - began
    run = mapper.finish(log)
    batch = run.places.labels.at(run.trajectory.map_from_base[:, :2], outside=-1)
    inside = np.flatnonzero(batch >= 0)
    regions = [f"r{i + 1}" for i in batch]
    told = [mapper.final.get(s.region or "") for s in steps]
    settled = [mapper.final.get(r or "") for r in mapper.settled()]
    known = [k for k in inside if steps[k].region is not None]
    returns = [e for s in steps for e in s.events if isinstance(e, RegionRecognised)]
    right = sum(mapper.final.get(e.region) == regions[e.scan] for e in returns)
    ms = 1000 * np.array(seconds)
    return {
        "scans": len(log),
        "median": float(np.median(ms)),
        "p99": float(np.quantile(ms, 0.99)),
        "max": float(ms.max()),
        "all": 1000 * cpu / len(log),
        "told": share(told[k] == regions[k] for k in inside),
        "known": share(told[k] == regions[k] for k in known),
        "settled": share(settled[k] == regions[k] for k in inside),
        "class": share(steps[k].class_ == run.map.regions[regions[k]].class_ for k in inside),
        "back": f"{right}/{len(returns)}",
        "regions": f"{len(set(mapper.settled()) - {None})}/{len(set(batch[inside].tolist()))}",
    }


def feed(mapper: Any, log: Any) -> tuple[list[Any], list[float]]:
    """The steps of all scans, and the seconds of this thread that each took."""
    steps, seconds = [], []
    for k in range(len(log)):
        began = time.thread_time()
        steps.append(mapper.add(log.ranges[k], log.odom_from_base[k], log.stamps[k]))
        seconds.append(time.thread_time() - began)
    return steps, seconds


def share(hits: Any) -> float:
    values = list(hits)
    return sum(values) / max(len(values), 1)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(one(Path(sys.argv[2]))))
    else:
        main(sys.argv[1:])
