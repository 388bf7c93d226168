"""CARMEN logs: text, one message a line; FLASER, ROBOTLASER1 and RAWLASER1 carry the scans of the front laser.

FLASER n r1..rn x y theta odom_x odom_y odom_theta ipc_timestamp ipc_hostname logger_timestamp
ROBOTLASER1 type start_angle fov step max_range accuracy remission_mode n r1..rn [m e1..em] laser pose, robot pose, tv rv
    forward_safety_dist side_safety_dist [turn_axis] ipc_timestamp ipc_hostname logger_timestamp
RAWLASER1 type start_angle fov step max_range accuracy remission_mode n r1..rn [m e1..em] ipc_timestamp ...
ODOM x y theta tv rv accel ipc_timestamp ipc_hostname logger_timestamp
PARAM name value ipc_hostname ipc_timestamp
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import NamedTuple

import numpy as np

from rgcore.geometry import se2
from rgcore.scans.beams import Fan, one_table, usual_fan
from rgcore.scans.echoes import mark_echoes
from rgcore.scans.log import ScanLog
from rgcore.scans.mounting import interpolate, mounting, moves
from rgcore.scans.source import Source

_WORDS = frozenset(
    "PARAM SYNC ODOM TRUEPOS FLASER RLASER LASER3 LASER4 ROBOTLASER1 ROBOTLASER2 RAWLASER1 RAWLASER2 RAWLASER3 RAWLASER4 "
    "NEFF VERTEX2 EDGE2 NMEAGGA NMEARMC SONAR BUMPER MARKER".split()
)

Lines = list[tuple[int, str]]
"""Line number and text."""


class Scan(NamedTuple):
    """One laser line, as written."""

    fan: Fan
    ranges: np.ndarray
    stamp: float
    laser: tuple[float, ...]  # pose of the laser; empty where the line has none
    robot: tuple[float, ...]
    max_range: float  # 0 where the line names none
    tail: int  # number of fields after the readings


def sniff(source: Source) -> bool:
    """Whether one of the first hundred lines begins with the name of a CARMEN message."""
    return any(line.split(None, 1)[:1] and line.split(None, 1)[0] in _WORDS for line in source.lines[:100])


def read(source: Source) -> ScanLog:
    """The front laser's scans of a CARMEN log. Raises InputError for a log without them and for a damaged line."""
    lines = _by_word(source)
    notes: list[str] = []
    kind = _laser_lines(source, lines)
    scans = _parse(source, lines.pop(kind), _PARSERS[kind], notes)
    if not scans:
        raise source.error(f"the only {kind} line is cut off; record again")
    params = _params(lines.pop("PARAM", []))
    readings, bearings, moved = one_table([s.ranges for s in scans], [s.fan for s in scans])
    if moved:
        notes.append(f"{moved} scans of another number of beams moved to the {len(bearings)} of the others")
    declared = max(s.max_range for s in scans) or params.get("robot_front_laser_max")
    ranges, max_range, found = mark_echoes(readings, declared)
    odom, base_from_laser = _poses(source, scans, lines, params, notes)
    stamps = np.array([s.stamp for s in scans])
    if (backwards := int((np.diff(stamps) < 0).sum())) > 0:
        notes.append(f"stamps run backwards {backwards} times; the file's order is kept")
    return ScanLog(
        stamps=stamps,
        ranges=ranges,
        odom_from_base=odom,
        bearings=bearings,
        base_from_laser=base_from_laser,
        max_range=max_range,
        has_odometry=moves(odom),
        source=source.path.name,
        sha256=source.sha256,
        format="carmen",
        notes="\n".join([*found, *notes, *_unused(lines)]),
    )


def _by_word(source: Source) -> dict[str, Lines]:
    """The lines by their first word."""
    out: dict[str, Lines] = {}
    for number, line in enumerate(source.lines, 1):
        head = line.split(None, 1)
        if head:
            out.setdefault("#" if head[0][0] == "#" else head[0], []).append((number, line))
    return out


def _laser_lines(source: Source, lines: dict[str, Lines]) -> str:
    """The message to read: loggers may write the same scan as several, of which the first here tells most."""
    most = max(len(lines.get(kind, [])) for kind in _PARSERS)
    if not most:
        seen = ", ".join(sorted(lines)[:8])
        raise source.error(f"holds no laser lines ({', '.join(_PARSERS)}), only: {seen}; nothing can be mapped from it")
    return next(kind for kind in _PARSERS if 2 * len(lines.get(kind, [])) >= most)


def _parse(source: Source, lines: Lines, parser: Callable[[list[str]], Scan], notes: list[str]) -> list[Scan]:
    """All scans; a last line that was cut off when the recording ended is left out."""
    scans: list[Scan] = []
    for number, line in lines:
        last = number == source.last_line
        try:
            scan = parser(line.split())
            if last and source.ends_open and scans and scan.tail < scans[0].tail:
                raise ValueError("it is cut off")
        except ValueError as e:
            if not last:
                raise source.error(f"damaged laser line: {e}; repair or delete the line", number) from e
            notes.append(f"the last line ({number}) is cut off and left out: {e}")
        else:
            scans.append(scan)
    return scans


def _flaser(words: list[str]) -> Scan:
    count = _count(words, 1)
    end = 2 + count
    tail = len(words) - end
    if not 7 <= tail <= 9:
        raise ValueError(f"it announces {count} readings, so {end + 9} fields, and has {len(words)}")
    pose = _numbers(words[end : end + 7])
    return Scan(usual_fan(count), _readings(words[2:end]), pose[6], pose[:3], pose[3:6], 0.0, tail)


def _robotlaser(words: list[str]) -> Scan:
    fan, max_range, ranges, rest = _laser_message(words, (13, 14))
    pose = _numbers(rest[:6])
    (stamp,) = _numbers(rest[-3:-2])
    return Scan(fan, ranges, stamp, pose[:3], pose[3:6], max_range, len(rest))


def _rawlaser(words: list[str]) -> Scan:
    fan, max_range, ranges, rest = _laser_message(words, (3,))
    (stamp,) = _numbers(rest[:1])
    return Scan(fan, ranges, stamp, (), (), max_range, len(rest))


_PARSERS: dict[str, Callable[[list[str]], Scan]] = {
    "ROBOTLASER1": _robotlaser,
    "FLASER": _flaser,
    "RAWLASER1": _rawlaser,
}
"""The message that tells most about the laser first."""


def _laser_message(words: list[str], tails: tuple[int, ...]) -> tuple[Fan, float, np.ndarray, list[str]]:
    """Fan, maximum range, readings and what follows the remissions; old loggers wrote neither remissions nor turn axis."""
    count = _count(words, 8)
    end = 9 + count
    rest = words[end:]
    if len(rest) not in tails:
        remissions = _count(words, end)
        rest = rest[1 + remissions :]
    if len(rest) not in tails:
        raise ValueError(f"it announces {count} readings and has {len(words)} fields, which do not add up")
    start, fov, step, max_range = _numbers(words[2:6])
    return _fan(count, start, fov, step), max_range, _readings(words[9:end]), rest


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


def _numbers(words: list[str]) -> tuple[float, ...]:
    out = tuple(map(float, words))
    if not all(abs(v) < 1e12 for v in out):
        raise ValueError("a pose, time stamp or angle is not a usable number")
    return out


def _params(lines: Lines) -> dict[str, float]:
    """PARAM values that are numbers; of a repeated one the last."""
    out = {}
    for _, line in lines:
        words = line.split()
        try:
            out[words[1]] = _numbers(words[2:3])[0]
        except (ValueError, IndexError):
            continue
    return out


def _poses(
    source: Source, scans: list[Scan], lines: dict[str, Lines], params: dict[str, float], notes: list[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Raw odometry of the robot's centre at each scan (N, 3) and ``base_from_laser (3,)``."""
    names = ("robot_frontlaser_offset", "robot_frontlaser_side_offset", "robot_frontlaser_angular_offset")
    by_params = np.array([params.get(name, 0.0) for name in names])
    if scans[0].robot:
        laser, robot = np.array([s.laser for s in scans]), np.array([s.robot for s in scans])
        found = mounting(robot, laser)
        if found is not None and moves(robot):
            return _wrapped(robot), found
        if moves(robot):
            notes.append("the laser poses are corrected ones; the raw odometry beside them is used")
            return _wrapped(robot), by_params
        if moves(laser):
            notes.append("the robot's poses never change; those of the laser are used as odometry")
            return se2.compose(laser, se2.invert(by_params)), by_params
        by_params = by_params if found is None else found
    odometry = _odometry(source, scans, lines.pop("ODOM", []))
    if odometry is None:
        notes.append("the log has no odometry")
        return np.zeros((len(scans), 3)), by_params
    return odometry, by_params


def _odometry(source: Source, scans: list[Scan], lines: Lines) -> np.ndarray | None:
    """Robot poses at the scans out of the ODOM lines, by time stamp; None where there are none."""
    rows = []
    for number, line in lines:
        words = line.split()
        try:
            if len(words) < 8:
                raise ValueError(f"it ends after {len(words)} fields")
            rows.append((*_numbers(words[1:4]), *_numbers(words[7:8])))
        except ValueError as e:
            if number != source.last_line:
                raise source.error(f"damaged ODOM line: {e}; repair or delete the line", number) from e
    if not rows:
        return None
    table = np.array(rows)
    return interpolate(np.array([s.stamp for s in scans]), table[:, 3], table[:, :3])


def _wrapped(poses: np.ndarray) -> np.ndarray:
    return np.column_stack([poses[:, :2], se2.wrap(poses[:, 2])])


def _unused(lines: dict[str, Lines]) -> list[str]:
    """One note that counts the lines that were not used, the most frequent first."""
    counts = sorted(((len(v), k[:20]) for k, v in lines.items() if k != "#"), key=lambda c: (-c[0], c[1]))
    more = [(sum(n for n, _ in counts[6:]), "other")] if len(counts) > 6 else []
    text = ", ".join(f"{n} {word}" for n, word in counts[:6] + more)
    return [f"{text} lines not used"] if text else []
