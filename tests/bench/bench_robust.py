"""How the poses stand up to worse logs: scans left out, and the odometry's own errors a second time.

    python tests/bench/bench_robust.py [NAME ...]

The truth is the true poses where there are any, else the poses of the log as it is. Worst: the largest distance to it
after the best rigid motion of each part between breaks. Bent: the largest change of a distance of up to 5 m between two
scans, those at breaks aside. A closure is wrong when the truth says otherwise by more than 0.5 m or 0.2 rad.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log
from rgcore.slam.lrgc import Lrgc
from rgcore.slam.posegraph import Links

DATA = Path(__file__).parents[2] / "../shared/data"
WRONG = (0.5, 0.2)
"""[m, rad] a closure may differ from the truth."""
SEEDS = 2


class Watched(Lrgc):
    """Keeps the closures that were believed, as numbers of scans and relative poses."""

    def __init__(self, log: ScanLog) -> None:
        super().__init__(log.bearings, Slam(), log.has_odometry)
        self.believed: list[Links] = []

    def _close(self, closures: Links) -> None:
        before = self.loops.accepted
        super()._close(closures)
        if self.loops.accepted > before:
            self.believed.append(closures)

    def wrong(self, true: np.ndarray) -> int:
        """How many of the closures contradict the true poses (N, 3) of the laser."""
        return sum(self._off(c, true) for c in self.believed)

    def _off(self, links: Links, true: np.ndarray) -> bool:
        scans = np.array(self.keyframes.scans)
        off = se2.relative(links.a_from_b, se2.relative(true[scans[links.a]], true[scans[links.b]]))
        return bool(np.median(np.hypot(off[:, 0], off[:, 1])) > WRONG[0] or np.median(np.abs(off[:, 2])) > WRONG[1])


def main(wanted: list[str]) -> None:
    from rgviz.demo import LOG

    logs = [LOG, *sorted(DATA.glob("logs/*.gz")), *sorted(DATA.glob("runs/*.log.gz"))]
    print(f"{'log':34}{'variant':>8}{'RMSE m':>8}{'worst m':>8}{'bent m':>8}{'breaks':>7}{'healed':>7}", end="")
    print(f"{'closures':>9}{'wrong':>6}{'s':>7}")
    for path in logs:
        name = path.name.split(".")[0]
        if name == "aces-gfs" or (wanted and name not in wanted):
            continue
        log = read_log(path)
        true = true_poses(path)
        for variant, worse, kept in variants(log):
            began = time.process_time()
            mapper = Watched(worse)
            for k in range(len(worse)):
                mapper.add(worse.ranges[k], worse.odom_from_laser[k])
            poses = mapper.finish()
            seconds = time.process_time() - began
            if true is None:
                true = poses
            print(f"{name:34}{variant:>8}{row(mapper, poses, true[kept])}{seconds:7.1f}", flush=True)


def true_poses(log: Path) -> np.ndarray | None:
    """(N, 3) of the laser, where they are known."""
    file = log.with_name(f"{log.name.split('.')[0]}.poses.tum")
    if not file.exists():
        return None
    t = np.loadtxt(file)
    base = np.column_stack([t[:, 1:3], 2.0 * np.arctan2(t[:, 6], t[:, 7])])
    out: np.ndarray = se2.compose(base, read_log(log).base_from_laser)
    return out


def variants(log: ScanLog) -> Iterator[tuple[str, ScanLog, np.ndarray]]:
    """Name, log and which of its scans are left: as it is, thinned, and with noisier odometry."""
    every = np.arange(len(log))
    yield "as is", log, every
    for stride in (2, 3):
        yield f"1 in {stride}", log[::stride], every[::stride]
    for seed in range(SEEDS):
        yield f"noise {seed + 1}", noisier(log, seed), every


def noisier(log: ScanLog, seed: int) -> ScanLog:
    """Odometry whose increments err by a tenth of the way and of the turn more, slowly changing."""
    chance = np.random.default_rng(seed)
    moved = se2.relative(log.odom_from_base[:-1], log.odom_from_base[1:])
    way, turn = np.hypot(moved[:, 0], moved[:, 1]), np.abs(moved[:, 2])
    slow = np.repeat(chance.normal(size=(len(moved) // 20 + 1, 3)), 20, 0)[: len(moved)]
    error = 0.7 * (slow + chance.normal(size=moved.shape))
    moved = moved + error * np.column_stack([0.1 * way, 0.05 * way, 0.1 * turn + 0.03 * way])
    odometry = [log.odom_from_base[0]]
    for m in moved:
        odometry.append(se2.compose(odometry[-1], m))
    return replace(log, odom_from_base=np.array(odometry))


def row(mapper: Watched, poses: np.ndarray, true: np.ndarray) -> str:
    parts = np.zeros(len(poses), int)
    parts[mapper.breaks] = 1
    parts = np.cumsum(parts)
    off = np.concatenate([aligned(poses[parts == p], true[parts == p]) for p in range(parts[-1] + 1)])
    healed = len(getattr(mapper, "healed", ()))
    figures = f"{np.sqrt((off**2).mean()):8.3f}{off.max():8.2f}{bent(poses, true, parts):8.2f}"
    return f"{figures}{len(mapper.breaks):7d}{healed:7d}{mapper.loops.accepted:9d}{mapper.wrong(true):6d}"


def aligned(poses: np.ndarray, true: np.ndarray) -> np.ndarray:
    """(N,) distances after the best rigid motion."""
    a, b = poses[:, :2] - poses[:, :2].mean(0), true[:, :2] - true[:, :2].mean(0)
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    out: np.ndarray = np.hypot(*(a @ turn.T - b).T)
    return out


def bent(poses: np.ndarray, true: np.ndarray, parts: np.ndarray) -> float:
    """Largest change of a relative position within some scans of the same part, up to 5 m apart."""
    worst = 0.0
    for gap in (1, 3, 10, 30):
        same = np.flatnonzero(parts[gap:] == parts[:-gap])
        now, then = (se2.relative(p[same], p[same + gap])[:, :2] for p in (poses, true))
        near = np.hypot(then[:, 0], then[:, 1]) < 5.0
        worst = max(worst, float(np.hypot(*(now - then)[near].T).max(initial=0.0)))
    return worst


if __name__ == "__main__":
    main(sys.argv[1:])
