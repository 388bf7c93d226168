"""The laser messages of a CARMEN log: what the fields of a line say.

FLASER n r1..rn x y theta odom_x odom_y odom_theta ipc_timestamp ipc_hostname logger_timestamp
ROBOTLASER1 type start_angle fov step max_range accuracy remission_mode n r1..rn [m e1..em] laser pose, robot pose, tv
    rv forward_safety_dist side_safety_dist [turn_axis] ipc_timestamp ipc_hostname logger_timestamp
RAWLASER1 type start_angle fov step max_range accuracy remission_mode n r1..rn [m e1..em] ipc_timestamp ipc_hostname
    logger_timestamp
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import NamedTuple

import numpy as np

from rgcore.scans.beams import Fan, usual_fan


class Scan(NamedTuple):
    """One laser line, as written."""

    fan: Fan
    ranges: np.ndarray
    stamp: float
    laser: tuple[float, ...]  # pose of the laser; empty where the line has none
    robot: tuple[float, ...]
    max_range: float  # 0 where the line names none
    tail: int  # number of fields after the readings
    line: int = 0  # its number in the file


def _flaser(words: list[str]) -> Scan:
    count = _count(words, 1)
    end = 2 + count
    tail = len(words) - end
    if not 7 <= tail <= 9:
        raise ValueError(f"it announces {count} readings, so {end + 9} fields, and has {len(words)}")
    pose = numbers(words[end : end + 7])
    return Scan(usual_fan(count), _readings(words[2:end]), pose[6], pose[:3], pose[3:6], 0.0, tail)


def _robotlaser(words: list[str]) -> Scan:
    fan, max_range, ranges, rest = _laser_message(words, (13, 14))
    pose = numbers(rest[:6])
    (stamp,) = numbers(rest[-3:-2])
    return Scan(fan, ranges, stamp, pose[:3], pose[3:6], max_range, len(rest))


def _rawlaser(words: list[str]) -> Scan:
    fan, max_range, ranges, rest = _laser_message(words, (3,))
    (stamp,) = numbers(rest[:1])
    return Scan(fan, ranges, stamp, (), (), max_range, len(rest))


LASER_MESSAGES: dict[str, Callable[[list[str]], Scan]] = {
    "ROBOTLASER1": _robotlaser,
    "FLASER": _flaser,
    "RAWLASER1": _rawlaser,
}
"""A parser each, that raises ValueError for a damaged line; the message that tells most about the laser first."""


def _laser_message(words: list[str], tails: tuple[int, ...]) -> tuple[Fan, float, np.ndarray, list[str]]:
    """Fan, maximum range, readings and what follows; old loggers wrote neither remissions nor the turn axis."""
    count = _count(words, 8)
    end = 9 + count
    rest = words[end:]
    if len(rest) not in tails:
        remissions = _count(words, end)
        rest = rest[1 + remissions :]
    if len(rest) not in tails:
        raise ValueError(f"it announces {count} readings and has {len(words)} fields, which do not add up")
    start, fov, step, max_range = numbers(words[2:6])
    readings = _readings(words[9:end])
    if step < 0:  # a laser mounted upside down counts clockwise
        start, step, readings = start + step * (count - 1), -step, readings[::-1]
    return _fan(count, start, fov, step), max_range, readings, rest


def _fan(count: int, start: float, fov: float, step: float) -> Fan:
    """The fan by the line's own numbers, or the usual one where they make no sense."""
    widest = 2 * pi + 0.01
    if count > 1 and 0 < step * (count - 1) <= widest:
        return Fan(count, start, step)
    if count > 1 and 0 < fov <= widest:
        return Fan(count, start, fov / (count - 1))
    return usual_fan(count)


def _count(words: list[str], at: int) -> int:
    if len(words) <= at:
        raise ValueError(f"it ends after {len(words)} fields")
    if not words[at].isdecimal():
        raise ValueError(f"the number of readings is {words[at]!r:.20}")
    return int(words[at][:9])


def _readings(words: list[str]) -> np.ndarray:
    return np.fromiter(map(float, words), float, len(words))


def numbers(words: list[str]) -> tuple[float, ...]:
    """Fields that must be finite numbers. Raises ValueError."""
    out = tuple(map(float, words))
    if not all(abs(v) < 1e12 for v in out):
        raise ValueError("a pose, time stamp or angle is not a usable number")
    return out
