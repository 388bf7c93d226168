"""CARMEN logs: text, one message a line; FLASER, ROBOTLASER1 and RAWLASER1 carry the scans of the front laser.

ODOM x y theta tv rv accel ipc_timestamp ipc_hostname logger_timestamp
PARAM name value ipc_hostname ipc_timestamp
The laser messages are described in ``carmen_messages``.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice

import numpy as np

from rgcore.geometry import se2
from rgcore.scans.beams import one_table
from rgcore.scans.carmen_messages import LASER_MESSAGES, Scan, numbers
from rgcore.scans.echoes import mark_echoes
from rgcore.scans.log import ScanLog
from rgcore.scans.mounting import interpolate, mounting, moves
from rgcore.scans.source import Source

_OTHER_MESSAGES = (
    *("PARAM", "SYNC", "ODOM", "TRUEPOS", "RLASER", "LASER3", "LASER4", "ROBOTLASER2", "RAWLASER2", "RAWLASER3"),
    *("RAWLASER4", "NEFF", "VERTEX2", "EDGE2", "NMEAGGA", "NMEARMC", "SONAR", "BUMPER", "MARKER"),
)
_MOUNTING = ("robot_frontlaser_offset", "robot_frontlaser_side_offset", "robot_frontlaser_angular_offset")
_LONGEST_RANGE = "robot_front_laser_max"

Lines = list[tuple[int, str]]
"""Line number and text."""


def sniff(source: Source) -> bool:
    """Whether one of the first hundred lines begins with the name of a CARMEN message."""
    heads = (line.split(None, 1)[0] for line in source.lines if line.strip() and not line.startswith("#"))
    return any(head in LASER_MESSAGES or head in _OTHER_MESSAGES for head in islice(heads, 100))


def read(source: Source) -> ScanLog:
    """The front laser's scans of a CARMEN log. Raises InputError for a log without them and for a damaged line."""
    lines = _by_word(source)
    notes: list[str] = []
    kind = _laser_lines(source, lines)
    scans = _parse(source, lines.pop(kind), LASER_MESSAGES[kind], notes)
    if not scans:
        raise source.error(f"the only {kind} line is cut off; record again")
    params = _params(lines.pop("PARAM", []))
    readings, bearings, moved = one_table([s.ranges for s in scans], [s.fan for s in scans])
    if not len(bearings):
        raise source.error(f"its {kind} lines hold no readings; nothing to map")
    if moved:
        notes.append(f"{moved} scans of another number of beams moved to the {len(bearings)} of the others")
    declared = max(s.max_range for s in scans) or params.get(_LONGEST_RANGE)
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
    most = max(len(lines.get(kind, [])) for kind in LASER_MESSAGES)
    if not most:
        seen = ", ".join(sorted(lines)[:8])
        raise source.error(
            f"holds no laser lines ({', '.join(LASER_MESSAGES)}), only: {seen}; nothing can be mapped from it"
        )
    return next(kind for kind in LASER_MESSAGES if 2 * len(lines.get(kind, [])) >= most)


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
            scans.append(scan._replace(line=number))
    return scans


def _params(lines: Lines) -> dict[str, float]:
    """PARAM values that are numbers; of a repeated one the last."""
    out = {}
    for _, line in lines:
        words = line.split()
        try:
            out[words[1]] = numbers(words[2:3])[0]
        except (ValueError, IndexError):
            continue
    return out


def _poses(
    source: Source, scans: list[Scan], lines: dict[str, Lines], params: dict[str, float], notes: list[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Raw odometry of the robot's centre at each scan (N, 3) and ``base_from_laser (3,)``."""
    by_params = np.array([params.get(name, 0.0) for name in _MOUNTING])
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
    """Robot poses at the scans out of the ODOM lines, None where there are none.

    By time stamp; by the order of the lines where the two kinds of stamps have no time in common.
    """
    rows = []
    for number, line in lines:
        words = line.split()
        try:
            if len(words) < 8:
                raise ValueError(f"it ends after {len(words)} fields")
            rows.append((*numbers(words[1:4]), *numbers(words[7:8]), number))
        except ValueError as e:
            if number != source.last_line:
                raise source.error(f"damaged ODOM line: {e}; repair or delete the line", number) from e
    if not rows:
        return None
    table, stamps = np.array(rows), np.array([s.stamp for s in scans])
    by_time = table[:, 3].min() <= np.median(stamps) <= table[:, 3].max() and np.ptp(table[:, 3]) > 0
    times, known = (stamps, table[:, 3]) if by_time else (np.array([s.line for s in scans], float), table[:, 4])
    return interpolate(times, known, table[:, :3])


def _wrapped(poses: np.ndarray) -> np.ndarray:
    return np.column_stack([poses[:, :2], se2.wrap(poses[:, 2])])


def _unused(lines: dict[str, Lines]) -> list[str]:
    """One note that counts the lines that were not used, the most frequent first."""
    counts = sorted(((len(v), k[:20]) for k, v in lines.items() if k != "#"), key=lambda c: (-c[0], c[1]))
    more = [(sum(n for n, _ in counts[6:]), "other")] if len(counts) > 6 else []
    text = ", ".join(f"{n} {word}" for n, word in counts[:6] + more)
    return [f"{text} lines not used"] if text else []
