"""Speed of the line stages on one core: ``python tests/bench/bench_lines.py [LOG [TRAJECTORY.tum]]``.

Without a log a simulated robot drives through a grid of rooms. Prints CPU times (compiling not counted), the figures of
the map, how merging grows to a million segments (the building copied side by side), how the lines of a furnished
floor stand up to its true walls, with true poses and with those of the mapper, and how sure they are of themselves.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np

from rgcore.config import Config
from rgcore.geometry.raycast import cast
from rgcore.lines.accuracy import measure_accuracy
from rgcore.lines.complete import complete_lines
from rgcore.lines.merge import Lines, merge_lines
from rgcore.scans.extract import Segments, extract
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log
from rgcore.slam.lrgc import lrgc
from rgcore.slam.trajectory import Trajectory

sys.path.insert(0, str(Path(__file__).parents[1] / "lines"))
from walls import driven, judge, normalized

T = TypeVar("T")
DEFAULT = Config()


def rooms(columns: int = 10, size: float = 5.0, door: float = 0.9) -> np.ndarray:
    """Two rows of rooms along a hallway of 2 m, each with a door to it."""
    out = []
    for side in (-1, 1):
        for k in range(columns):
            x, y = k * size, side * 1.0
            far, mid = y + side * size, x + size / 2
            out += [[[x, y], [mid - door / 2, y]], [[mid + door / 2, y], [x + size, y]], [[x, far], [x + size, far]]]
            out += [[[x + 0.05, y], [x + 0.05, far]], [[x + size - 0.05, y], [x + size - 0.05, far]]]
    return np.array(out)


def simulated() -> tuple[ScanLog, Trajectory]:
    rng, bearings = np.random.default_rng(0), np.deg2rad(np.arange(-90.0, 91.0))
    stops = [(2.5 + 5 * k, side * y) for k in range(10) for side in (1, -1) for y in (0.0, 3.5, 5.0, 0.0)]
    path = np.concatenate([np.linspace(a, b, 25) for a, b in pairwise(stops)])
    poses = np.column_stack([path, np.arange(len(path)) * 0.4])
    ranges = cast(rooms(), poses, bearings, 30.0)[0]
    n, zero = len(poses), np.zeros(3)
    log = ScanLog(np.arange(n), ranges + rng.normal(0, 0.012, ranges.shape), np.zeros((n, 3)), bearings, zero, 30.0)
    return log, Trajectory(log.stamps, poses + rng.normal(0, 1, poses.shape) * [0.01, 0.01, 0.002], zero)


def given(log_path: str, tum_path: str | None = None) -> tuple[ScanLog, Trajectory]:
    log = read_log(log_path)
    if tum_path is None:
        return log, Trajectory(log.stamps, log.odom_from_base, log.base_from_laser)
    t = np.loadtxt(tum_path)
    poses = np.stack([t[:, 1], t[:, 2], 2 * np.arctan2(t[:, 6], t[:, 7])], 1)
    return log, Trajectory(log.stamps, poses, log.base_from_laser)


def timed(compute: Callable[[], T]) -> tuple[T, float]:
    """Result and CPU time [s] of the second call: the first compiles."""
    compute()
    began = time.process_time()
    return compute(), time.process_time() - began


def copies(s: Segments, trajectory: Trajectory, times: int) -> tuple[Segments, Trajectory]:
    """The building ``times`` times side by side, each seen by scans of its own."""
    n, pitch = len(trajectory), 2 * np.abs(trajectory.map_from_base[:, :2]).max() + 60
    shift = np.repeat(np.arange(times), n)[:, None] * [pitch, 0, 0]
    many = Trajectory(
        np.tile(trajectory.stamps, times),
        np.tile(trajectory.map_from_base, (times, 1)) + shift,
        trajectory.base_from_laser,
    )
    k = np.tile(np.arange(len(s)), times)
    scan = s.scan[k] + np.repeat(np.arange(times), len(s)) * n
    return Segments(s.ends[k], scan, s.beams[k], s.points[k], s.rms[k], s.covariance[k]), many


def main() -> None:
    log, trajectory = given(*sys.argv[1:]) if len(sys.argv) > 1 else simulated()
    print(f"{log.source or 'simulated rooms'}: {log.ranges.shape[0]} scans x {log.ranges.shape[1]} beams")
    s, seconds = timed(lambda: extract(log, DEFAULT.extract))
    print(f"extract   {seconds:7.3f} s  {len(log) / seconds:10,.0f} scans/s     {len(s)} segments")
    region = np.zeros(len(s), np.int64)
    (lines, _), seconds = timed(lambda: merge_lines(s, trajectory, region, DEFAULT.lines))
    factor = len(s) / max(1, len(lines))
    print(f"merge     {seconds:7.3f} s  {len(s) / seconds:10,.0f} segments/s  {len(lines)} lines, factor {factor:.1f}")
    lines, seconds = timed(lambda: completed(log, s, trajectory))
    factor = len(s) / max(1, len(lines))
    print(
        f"complete  {seconds:7.3f} s  {len(log) / seconds:10,.0f} scans/s     {len(lines)} lines, factor {factor:.1f}"
    )
    a, seconds = timed(lambda: measure_accuracy(log, trajectory, lines.ends, DEFAULT.accuracy))
    missed = a.missed.sum() / max(1, a.readings.sum())
    acc = a.of(np.ones(len(log), bool))
    print(f"accuracy  {seconds:7.3f} s  {len(log) / seconds:10,.0f} scans/s     acc {acc:.3f} m, missed {missed:.1%}")
    sizes = []
    for size in (10_000, 100_000, 1_000_000):
        if size < len(s):
            continue
        many, way = copies(s, trajectory, round(size / len(s)))
        region = np.zeros(len(many), np.int64)
        began = time.process_time()
        merge_lines(many, way, region, DEFAULT.lines)
        seconds = time.process_time() - began
        sizes.append((len(many), seconds))
        print(f"merge {len(many):9,d} segments: {seconds:7.2f} s  {len(many) / seconds:10,.0f} segments/s")
    if len(sizes) > 1:
        print(f"merge grows with the segments to the power of {np.polyfit(*np.log(sizes).T, 1)[0]:.2f}")
    truth()
    calibration()


def calibration() -> None:
    """Errors of lines by what their covariance says, with the poses of the mapper: root mean squares, one is right."""
    for noise in (0.005, 0.012, 0.03):
        found = []
        for seed in range(4):
            drive = driven(seed, noise)
            way, s = lrgc(drive.log, DEFAULT.slam), extract(drive.log, DEFAULT.extract)
            found.append(normalized(drive, completed(drive.log, s, way), way))
        across, turn = np.sqrt((np.concatenate(found) ** 2).mean(0))
        print(f"noise {1000 * noise:3.0f} mm: normalised error across {across:.2f}, of the direction {turn:.2f}")


def truth() -> None:
    """The lines of a simulated robot on a floor whose walls are known."""
    drive = driven()
    for name, trajectory in (
        ("true poses", Trajectory(drive.log.stamps, drive.map_from_base, drive.log.base_from_laser)),
        ("mapped", lrgc(drive.log, DEFAULT.slam)),
    ):
        s = extract(drive.log, DEFAULT.extract)
        w = judge(completed(drive.log, s, trajectory).ends, drive)
        print(
            f"{name:10s} {w.walls} true walls over 0.5 m seen: {w.present:.1%} within 2 cm and 0.5 degrees (median"
            f" {1000 * w.offset:.1f} mm, {np.degrees(w.turn):.2f} degrees); false lines {w.false:.1%}"
        )


def completed(log: ScanLog, s: Segments, trajectory: Trajectory) -> Lines:
    """The lines of all segments as of one region."""
    merged = merge_lines(s, trajectory, np.zeros(len(s), np.int64), DEFAULT.lines)
    return complete_lines(*merged, log, s, trajectory, lambda at: np.zeros(len(at), np.int64), DEFAULT.lines)[0]


if __name__ == "__main__":
    main()
