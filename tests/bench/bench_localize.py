"""Localization on finished line maps: the paper's table II, global search, and what disturbs a robot.

    python tests/bench/bench_localize.py [NAME ...]

The robot is driven along each log and localized on the lines made of it. Table II: estimated less aligned poses, in the
frame of the aligned scan (the paper: standard deviations of 24.4 and 11.3 mm at GI Demo, 83.2 and 88.9 mm at TUM IX).
Global: windows of 20 scans anywhere, placed within 0.25 m and 5 degrees. Disturbed: root mean square error while not
lost / share of scans lost, where 30 % of the beams hit people, 30 % give no answer, odometry counts 30 % too much.
CPU time.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from rgcore.config import Localize
from rgcore.geometry import se2
from rgcore.pipeline import Run, run
from rgcore.robot.localize import Localizer
from rgcore.robot.table import follow, localization_table
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log

DATA = Path(__file__).parents[2] / "../shared/data"
NOT_MAPPED = ("aces-gfs", "intel-dense")
"""The same buildings as aces and intel."""
WINDOWS = 40
DISTURBED = 1500
"""Scans of a log that are driven along disturbed."""


def main(wanted: list[str]) -> None:
    from rgviz.demo import LOG

    logs = [LOG, *sorted(DATA.glob("runs/*.log.gz")), *sorted(DATA.glob("logs/*.gz"))]
    logs = [p for p in logs if (name(p) in wanted if wanted else name(p) not in NOT_MAPPED)]
    columns = f"{'dx [mm]':>16}{'dy [mm]':>16}{'dalpha [rad]':>18}{'d_min':>7}{'d_max':>7}{'lost':>6}{'ms/scan':>9}"
    print(f"{'table II':36}{columns}")
    maps = []
    for path in logs:
        mapped = run(read_log(path))
        maps.append(mapped)
        print(f"{name(path):36}{table_two(mapped)}", flush=True)
    print(f"\n{'global':36}{'right':>8}{'sure':>8}{'sure and wrong':>16}{'s/search':>10}")
    for mapped in maps:
        print(f"{name(Path(mapped.log.source)):36}{search(mapped)}", flush=True)
    print(f"\n{'disturbed [mm / share lost]':36}{'people':>14}{'no answer':>14}{'odometry':>14}")
    for mapped in maps:
        print(f"{name(Path(mapped.log.source)):36}{disturb(mapped)}", flush=True)


def name(log: Path) -> str:
    return log.name.split(".")[0]


def table_two(mapped: Run) -> str:
    log, poses = mapped.log, mapped.trajectory.map_from_laser
    Localizer(mapped.map, log.bearings).find(log.ranges[:2], None)  # loads what is compiled
    began = time.process_time()
    row = localization_table(log, poses, mapped.map)
    spent = 1e3 * (time.process_time() - began) / len(log)
    pairs = "".join(f"{1e3 * mean:7.1f} +- {1e3 * sd:5.1f}" for mean, sd in (row.dx, row.dy))
    turn = f"{row.dalpha[0]:8.4f} +- {row.dalpha[1]:.4f}"
    return f"{pairs}{turn:>18}{1e3 * row.d_min:7.1f}{1e3 * row.d_max:7.0f}{row.lost:6}{spent:9.2f}"


def search(mapped: Run) -> str:
    log, poses = mapped.log, mapped.trajectory.map_from_laser
    k = Localize().window
    robot = Localizer(mapped.map, log.bearings)
    odometry = log.odom_from_laser if log.has_odometry else None
    first = np.random.default_rng(0).choice(len(log) - k, min(WINDOWS, len(log) - k), replace=False)
    robot.find(log.ranges[:k], None if odometry is None else odometry[:k])
    right, sure = np.zeros(len(first), bool), np.zeros(len(first), bool)
    began = time.process_time()
    for i, f in enumerate(first):
        found = robot.find(log.ranges[f : f + k], None if odometry is None else odometry[f : f + k])
        if len(found.poses):
            off = se2.relative(poses[f + k - 1], found.poses[0])
            right[i] = np.hypot(off[0], off[1]) < 0.25 and abs(off[2]) < np.deg2rad(5)
        sure[i] = found.sure
    spent = (time.process_time() - began) / len(first)
    return f"{right.mean():8.1%}{sure.mean():8.1%}{int((sure & ~right).sum()):16}{spent:10.2f}"


def disturb(mapped: Run) -> str:
    log = mapped.log[: min(DISTURBED, len(mapped.log))]
    chance = np.random.default_rng(0)
    hit = chance.random(log.ranges.shape) < 0.3
    people = np.where(hit, log.ranges * chance.uniform(0.2, 0.9, hit.shape), log.ranges)
    moved = se2.relative(log.odom_from_laser[:-1], log.odom_from_laser[1:]) * np.array([1.3, 1.3, 1.0])
    way = [log.odom_from_laser[0]]
    for m in moved:
        way.append(se2.compose(way[-1], m))
    odometry = se2.compose(np.array(way), se2.invert(log.base_from_laser))
    trials = (
        (people, log.odom_from_base),
        (np.where(hit, np.nan, log.ranges), log.odom_from_base),
        (log.ranges, odometry),
    )
    return "".join(f"{off_by(mapped, with_(log, *trial)):>14}" for trial in trials)


def with_(log: ScanLog, ranges: np.ndarray, odom_from_base: np.ndarray) -> ScanLog:
    return ScanLog(
        log.stamps, ranges, odom_from_base, log.bearings, log.base_from_laser, log.max_range, log.has_odometry
    )


def off_by(mapped: Run, log: ScanLog) -> str:
    true = mapped.trajectory.map_from_laser[: len(log)]
    poses, lost = follow(log, true[0], mapped.map)
    off = (poses - true)[~lost, :2]
    return f"{1e3 * np.sqrt((off**2).sum(1).mean()):.0f} / {lost.mean():.2f}"


if __name__ == "__main__":
    main(sys.argv[1:])
