"""A simulated robot: it drives through a floor with a laser and a drifting odometry, and logs what a real one would."""

from __future__ import annotations

import gzip
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Annotated

import numpy as np

from rgcore.config import Settings, setting
from rgcore.errors import InputError
from rgcore.geometry import se2
from rgcore.geometry.raycast import cast
from rgcore.scans.drive import Driving, drive
from rgcore.scans.floor import Floor, build_floor
from rgcore.scans.log import ScanLog
from rgcore.scans.plan import read_plan
from rgcore.scans.plan_image import is_image, read_floor_image
from rgcore.scans.truth import write_truth

NO_RETURN = 81.91
"""m, what a SICK LMS reports where nothing came back."""


class Laser(Settings, frozen=True):
    """The laser: by default a SICK LMS 200 facing forward."""

    beams: Annotated[int, setting("beams", "one a degree", ge=2, le=3600)] = 181
    fov: Annotated[float, setting("rad", "half a turn", gt=0, le=6.2831)] = float(np.pi)
    noise: Annotated[float, setting("m", "standard deviation of a range", ge=0, le=1)] = 0.012
    max_range: Annotated[float, setting("m", "farther walls do not answer", gt=0, lt=80)] = 30.0
    drop_out: Annotated[
        float, setting("1", "share of beams that get no answer: dark or shiny surfaces", ge=0, le=1)
    ] = 0.002
    mixed: Annotated[
        float, setting("1", "share of depth edges where a beam hits both sides and measures between", ge=0, le=1)
    ] = 0.08
    edge: Annotated[float, setting("m", "neighbouring beams differ by this at a depth edge", gt=0, le=10)] = 0.3
    forward: Annotated[float, setting("m", "how far the laser sits before the robot's centre", ge=-2, le=2)] = 0.0


class Odometry(Settings, frozen=True):
    """Odometry motion model (Thrun, Burgard, Fox: Probabilistic Robotics, 2005, section 5.4) with biases."""

    rotation_by_turn: Annotated[float, setting("rad/rad", "alpha 1: noise of a rotation by its size", ge=0, le=1)] = (
        0.05
    )
    rotation_by_way: Annotated[float, setting("rad/m", "alpha 2: noise of a rotation by the way", ge=0, le=1)] = 0.015
    way_by_way: Annotated[float, setting("m/m", "alpha 3: noise of the way by its length", ge=0, le=1)] = 0.05
    way_by_turn: Annotated[float, setting("m/rad", "alpha 4: noise of the way by the rotation", ge=0, le=1)] = 0.01
    turn_bias: Annotated[
        float, setting("rad/rad", "rotations are over-counted: a wrong wheel base", ge=-0.5, le=0.5)
    ] = 0.004
    way_bias: Annotated[float, setting("m/m", "ways are over-counted: worn tyres", ge=-0.5, le=0.5)] = 0.01
    curve_bias: Annotated[
        float, setting("rad/m", "straight ways are counted as curves: unequal wheels", ge=-0.5, le=0.5)
    ] = 0.001


class Simulation(Settings, frozen=True):
    """All of a simulated robot."""

    seed: Annotated[int, setting("1", "of all noise", ge=0)] = 0
    driving: Driving = Driving()
    laser: Laser = Laser()
    odometry: Odometry = Odometry()


@dataclass(frozen=True, eq=False)
class Simulated:
    """A log and what is true of it: the floor and ``map_from_base`` (N, 3), the true pose at each scan."""

    log: ScanLog
    floor: Floor
    map_from_base: np.ndarray

    @property
    def map_from_laser(self) -> np.ndarray:
        return se2.compose(self.map_from_base, self.log.base_from_laser)


def simulate(floor: Floor, settings: Simulation | None = None) -> Simulated:
    """Drive through a floor and scan: same floor and settings, same log. Raises InputError as :func:`drive` does."""
    s = settings or Simulation()
    way = drive(floor, s.driving)
    chance = np.random.default_rng(s.seed)
    odom = measure_odometry(way.poses, s.odometry, chance)
    bearings = np.linspace(-s.laser.fov / 2, s.laser.fov / 2, s.laser.beams)
    base_from_laser = np.array([s.laser.forward, 0.0, 0.0])
    exact, _ = cast(floor.segments, se2.compose(way.poses, base_from_laser), bearings, s.laser.max_range)
    ranges = measure_ranges(exact, s.laser, chance)
    odom = np.column_stack([np.round(odom[:, :2], 4), np.round(odom[:, 2], 5)])
    log = ScanLog(
        stamps=np.round(way.stamps, 3),
        ranges=ranges,
        odom_from_base=odom,
        bearings=bearings,
        base_from_laser=base_from_laser,
        max_range=s.laser.max_range,
        source=f"{floor.name}.log",
        sha256=sha256(ranges.tobytes() + odom.tobytes()).hexdigest(),
        format="carmen",
    )
    return Simulated(log, floor, way.poses)


def measure_ranges(exact: np.ndarray, laser: Laser, chance: np.random.Generator) -> np.ndarray:
    """(N, B) ranges as a laser reports them, to the centimetre: mixed pixels, noise, drop-outs; inf = no answer."""
    out = exact.copy()
    near, far = exact[:, :-1], exact[:, 1:]
    jump = np.isfinite(near) & np.isfinite(far)
    jump[jump] = np.abs(near[jump] - far[jump]) > laser.edge
    row, beam = np.nonzero(jump & (chance.random(jump.shape) < laser.mixed))
    share = chance.random(len(row))
    out[row, beam + chance.integers(0, 2, len(row))] = share * exact[row, beam] + (1 - share) * exact[row, beam + 1]
    out += chance.normal(0, laser.noise, out.shape)
    out[chance.random(out.shape) < laser.drop_out] = np.inf
    return np.round(np.maximum(out, 0.01), 2)


def measure_odometry(poses: np.ndarray, odometry: Odometry, chance: np.random.Generator) -> np.ndarray:
    """(N, 3) poses as odometry counts them: begins at the true pose and drifts.

    Each step is taken apart into a rotation, a way and a second rotation, as in the book; a way
    that points backwards is driven in reverse.
    """
    o = odometry
    step = se2.relative(poses[:-1], poses[1:])
    way = np.hypot(step[:, 0], step[:, 1])
    first = np.where(way > 1e-6, np.arctan2(step[:, 1], step[:, 0]), 0.0)
    reverse = np.abs(first) > np.pi / 2
    first = np.where(reverse, se2.wrap(first + np.pi), first)
    second = se2.wrap(step[:, 2] - first)

    def turned(angle: np.ndarray) -> np.ndarray:
        sd = np.hypot(o.rotation_by_turn * angle, o.rotation_by_way * way)
        return angle * (1 + o.turn_bias) + o.curve_bias * way / 2 + chance.normal(0, 1, len(angle)) * sd

    sd = np.hypot(o.way_by_way * way, o.way_by_turn * np.hypot(first, second))
    counted = np.where(reverse, -1, 1) * way * (1 + o.way_bias) + chance.normal(0, 1, len(way)) * sd
    first, second = turned(first), turned(second)
    out = [poses[0]]
    for a, d, b in zip(first, counted, second, strict=True):
        out.append(se2.compose(out[-1], np.array([d * np.cos(a), d * np.sin(a), a + b])))
    return np.array(out)


def write_carmen(log: ScanLog, path: str | Path) -> None:
    """Write a CARMEN log of FLASER lines, gzipped if the name ends in ``.gz``; no echo is written as 81.91 m.

    FLASER carries no angles: 181 and 361 beams over half a turn (180 and 360 without the end) are what readers take.
    Raises OSError.
    """
    lines = [
        "# message formats defined: FLASER",
        "# FLASER num_readings [range_readings] x y theta odom_x odom_y odom_theta"
        " ipc_timestamp ipc_hostname logger_timestamp",
    ]
    ranges = np.where(np.isfinite(log.ranges), log.ranges, NO_RETURN)
    for r, laser, robot, t in zip(ranges, log.odom_from_laser, log.odom_from_base, log.stamps, strict=True):
        poses = " ".join(f"{x:.4f} {y:.4f} {theta:.5f}" for x, y, theta in (laser, robot))
        lines.append(f"FLASER {len(r)} {' '.join(f'{v:.2f}' for v in r)} {poses} {t:.3f} sim {t:.3f}")
    data = ("\n".join(lines) + "\n").encode()
    Path(path).write_bytes(gzip.compress(data, 9, mtime=0) if str(path).endswith(".gz") else data)


def simulate_to_files(
    plan: str | Path,
    log: str | Path,
    *,
    resolution: float | None = None,
    seed: int = 0,
    settings: Simulation | None = None,
) -> Simulated:
    """Simulate a floor plan, JSON or an image of ``resolution`` [m a pixel]; write the log, and the truth beside it."""
    s = settings or Simulation(seed=seed)
    simulated = simulate(read_floor(plan, resolution), s)
    write_carmen(simulated.log, log)
    write_truth(simulated, log)
    return simulated


def read_floor(plan: str | Path, resolution: float | None = None) -> Floor:
    """The floor of a plan in a file, JSON or image; the content decides. Raises InputError."""
    if is_image(plan):
        if resolution is None:
            raise InputError(plan, "an image needs the size of its pixels; give it with --resolution, e.g. 0.05")
        return read_floor_image(plan, resolution)
    return build_floor(read_plan(plan), plan)
