"""Does the cost of a scan stay the same while the log grows? Poses only, one process each.

    python tests/bench/bench_growth.py [NAME ...]

CPU time of the calling thread, kernels compiled before. First and last: milliseconds a scan, over the first and the
last thousand; by lap: over each quarter. NAME-x4 is the log driven to and fro, twice: forward, then the same scans
backward, so that the robot comes back to all places three times and nothing is new; apart: how far the poses of one
scan in the laps lie from those in the first. Memory: the most that the process took.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

DATA = Path(__file__).parents[2] / "../shared/data"
LOGS = ("intel-dense", "fr079", "intel-dense-x4", "fr079-x4")
THOUSAND = 1000


def main(wanted: list[str]) -> None:
    from rgviz.demo import LOG

    names = [n for n in LOGS if path_of(n).exists()] or [f"{LOG}-x4"]
    table = Table(title="growth: ms a scan (CPU) while the log grows", title_justify="left")
    heads = (
        "log",
        "scans",
        "keyframes",
        "first 1000",
        "last",
        "by lap",
        "median",
        "p99",
        "max",
        "finish s",
        "MB",
        "apart mm",
    )
    for head in heads:
        table.add_column(head, justify="left" if head == "log" else "right")
    for name in names:
        if wanted and name not in wanted:
            continue
        command = [sys.executable, __file__, "--one", name]
        r = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        table.add_row(
            Path(name).name,
            *(str(r[k]) for k in ("scans", "keyframes")),
            *(f"{r[k]:.2f}" for k in ("first", "last")),
            " ".join(f"{v:.2f}" for v in r["laps"]),
            *(f"{r[k]:.2f}" for k in ("median", "p99")),
            f"{r['max']:.0f}",
            f"{r['finish']:.1f} ({100 * r['finish'] / r['all']:.0f} %)",
            f"{r['memory']:.0f}",
            f"{1000 * r['apart']:.1f}" if name.endswith("-x4") else "-",
        )
    Console(width=180).print(table)


def path_of(name: str) -> Path:
    name = name.removesuffix("-x4")
    return Path(name) if name.endswith(".gz") else DATA / "logs" / f"{name}.log.gz"


def one(name: str) -> dict[str, Any]:
    """Estimate the poses of one log in this process."""
    from rgcore.config import Config
    from rgcore.scans.read import read_log
    from rgcore.slam.lrgc import Lrgc, lrgc

    log = read_log(path_of(name))
    lrgc(log[:300], Config().slam)  # compiles
    there = np.arange(len(log))
    order = np.concatenate([there, there[::-1]] * 2) if name.endswith("-x4") else there
    ranges, odometry = log.ranges, log.odom_from_laser
    mapper, seconds = Lrgc(log.bearings, Config().slam, log.has_odometry), np.zeros(len(order))
    for i, k in enumerate(order):
        began = time.thread_time()
        mapper.add(ranges[k], odometry[k])
        seconds[i] = time.thread_time() - began
    began = time.thread_time()
    poses = mapper.finish()
    finish = time.thread_time() - began
    laps = poses.reshape(-1, len(log), 3)[:, :, :2]
    laps[1::2] = laps[1::2, ::-1].copy()  # those driven backward
    ms = 1000 * seconds
    return {
        "scans": len(order),
        "keyframes": len(mapper.keyframes),
        "first": ms[:THOUSAND].mean(),
        "last": ms[-THOUSAND:].mean(),
        "laps": [part.mean() for part in np.array_split(ms, 4)],
        "median": float(np.median(ms)),
        "p99": float(np.quantile(ms, 0.99)),
        "max": ms.max(),
        "finish": finish,
        "all": seconds.sum() + finish,
        "apart": float(np.hypot(*(laps[1:] - laps[0]).reshape(-1, 2).T).mean()) if len(laps) > 1 else 0.0,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(one(sys.argv[2])))
    else:
        main(sys.argv[1:])
