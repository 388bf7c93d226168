"""Robots that are carried away, and odometry that jumps: what is told, and is the rest of the drive found again?

    python tests/bench/bench_kidnap.py [-v] [--seed=7] [--kidnaps=20] [NAME ...]

The robot drives, is carried to any other place of its log, and drives on; its odometry knows nothing of that. Told: a
break within 2 m of way; known: most of what follows had been driven before. Right, wrong: the part after it was joined
to the map within 0.5 m and 0.2 rad of the truth, or elsewhere. Silent: nothing was told, and the poses say that it
stands where it does not. False: breaks told elsewhere.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log
from rgcore.slam.lrgc import Lrgc

DATA = Path(__file__).parents[2] / "../shared/data"
RUNS = ("office", "lab-f-scan-plain", "school-Sabadell1-furnished")
SEED, KIDNAPS = 7, 20
BEFORE, AFTER = 500, 200
WRONG = (0.5, 0.2)


def main(wanted: list[str], seed: int, kidnaps: int) -> None:
    from rgviz.demo import LOG

    print(
        f"{'log':34}{'kidnaps':>8}{'told':>6}{'known':>6}{'right':>6}{'wrong':>6}{'unmoved':>8}{'silent':>7}{'false':>6}{'s':>7}"
    )
    for path in [LOG, *sorted(DATA.glob("runs/*.log.gz"))]:
        name = path.name.split(".")[0]
        if name not in (wanted or RUNS):
            continue
        log = read_log(path)
        t = np.loadtxt(path.with_name(f"{name}.poses.tum"))
        true = np.column_stack([t[:, 1:3], 2.0 * np.arctan2(t[:, 6], t[:, 7])])
        began, chance, counts = time.process_time(), np.random.default_rng(seed), dict.fromkeys(NAMES, 0)
        for _ in range(kidnaps):
            start, goal = int(chance.integers(BEFORE, len(log))), int(chance.integers(0, len(log) - AFTER))
            for outcome in kidnap(log, true, start, goal):
                counts[outcome] += 1
        figures = "".join(f"{counts[n]:{w}d}" for n, w in zip(NAMES, (6, 6, 6, 6, 8, 7, 6), strict=True))
        print(f"{name:34}{kidnaps:8d}{figures}{time.process_time() - began:7.1f}", flush=True)


NAMES = ("told", "known", "right", "wrong", "unmoved", "silent", "false")


def kidnap(log: ScanLog, true: np.ndarray, start: int, goal: int) -> list[str]:
    """What became of one carried from scan ``start`` to scan ``goal``."""
    part, odometry = np.r_[start - BEFORE : start, goal : goal + AFTER], log.odom_from_base
    elsewhere = se2.compose(odometry[start - 1], se2.relative(odometry[goal], odometry[goal : goal + AFTER]))
    carried = replace(log[part], odom_from_base=np.concatenate([odometry[start - BEFORE : start], elsewhere]))
    mapper = Lrgc(log.bearings, Slam())
    for k in range(len(carried)):
        mapper.add(carried.ranges[k], carried.odom_from_laser[k])
    base = se2.compose(mapper.finish(), se2.invert(log.base_from_laser))
    near = BEFORE + np.searchsorted(np.hypot(*np.diff(true[goal : goal + AFTER, :2], axis=0).T).cumsum(), 2.0)
    told = [b for b in mapper.breaks + mapper.healed if BEFORE <= b <= near]
    out = ["false"] * (len(mapper.breaks + mapper.healed) - len(told))
    off = se2.relative(se2.relative(base[0], base[-1]), se2.relative(true[part[0]], true[part[-1]]))
    stands = bool(np.hypot(off[0], off[1]) < WRONG[0] and abs(off[2]) < WRONG[1])
    if told:
        out += ["told"] + ["known"] * known(true[part[:BEFORE]], true[part[BEFORE:]])
        if not any(b in mapper.breaks for b in told):
            out.append("right" if stands else "wrong")
    elif stands:
        out.append("unmoved")
    else:
        out.append("silent")
    if "-v" in sys.argv:
        print(start, goal, out, mapper.breaks, mapper.healed, off.round(2))
    return out


def known(before: np.ndarray, after: np.ndarray) -> bool:
    """Whether most of the way after had been driven before, in about the same direction."""
    off = se2.relative(after[:, None], before[None])
    same = (np.hypot(off[..., 0], off[..., 1]) < 1.0) & (np.abs(off[..., 2]) < 0.8)
    return bool(same.any(1).mean() > 0.5)


if __name__ == "__main__":
    given = {"seed": SEED, "kidnaps": KIDNAPS}
    given |= {k: int(v) for k, v in (a[2:].split("=") for a in sys.argv[1:] if a.startswith("--"))}
    main([a for a in sys.argv[1:] if not a.startswith("-")], **given)
