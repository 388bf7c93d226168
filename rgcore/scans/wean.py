"""Wean Hall logs (Carnegie Mellon): ``L`` lines with a scan, ``O`` lines with odometry only; centimetres and radians.

O x y theta ts
L x y theta xl yl thetal r1 ... r180 ts          robot pose, laser pose, readings counter-clockwise from the right
"""

from __future__ import annotations

import numpy as np

from rgcore.geometry import se2
from rgcore.scans.beams import usual_fan
from rgcore.scans.echoes import mark_echoes
from rgcore.scans.log import ScanLog
from rgcore.scans.mounting import mounting, moves
from rgcore.scans.source import Source

_CENTIMETRE = 0.01
_AHEAD = np.array([0.25, 0.0, 0.0])  # m, where the laser sits by the format's description


def sniff(source: Source) -> bool:
    """Whether one of the first lines is an ``L`` or ``O`` line of numbers."""
    return any(_looks_right(line.split()) for line in source.lines[:20])


def read(source: Source) -> ScanLog:
    """The scans of a Wean Hall log. Raises InputError for a log without them and for a damaged line."""
    rows: list[np.ndarray] = []
    notes: list[str] = []
    odometry_lines = others = 0
    for number, line in enumerate(source.lines, 1):
        words = line.split()
        if words[:1] != ["L"]:
            odometry_lines += words[:1] == ["O"]
            others += words[:1] not in ([], ["O"]) and not line.startswith("#")
            continue
        try:
            row = _row(words)
            if rows and len(row) != len(rows[0]):
                raise ValueError(f"it has {len(words)} fields, the lines before {len(rows[0]) + 1}")
        except ValueError as e:
            if number != source.last_line:
                raise source.error(f"damaged laser line: {e}; repair or delete the line", number) from e
            notes.append(f"the last line ({number}) is cut off and left out: {e}")
        else:
            rows.append(row)
    if not rows:
        raise source.error("holds no whole laser line (`L ...`); nothing to map")
    if odometry_lines or others:
        notes.append(f"{odometry_lines} O and {others} other lines not used")
    return _log(source, rows, notes)


def _log(source: Source, rows: list[np.ndarray], notes: list[str]) -> ScanLog:
    table = np.array(rows)
    ranges, max_range, found = mark_echoes(table[:, 6:-1] * _CENTIMETRE)
    poses = table[:, :6] * [_CENTIMETRE, _CENTIMETRE, 1, _CENTIMETRE, _CENTIMETRE, 1]
    robot, laser = poses[:, :3], poses[:, 3:]
    place = mounting(robot, laser)
    return ScanLog(
        stamps=table[:, -1],
        ranges=ranges,
        odom_from_base=np.column_stack([robot[:, :2], se2.wrap(robot[:, 2])]),
        bearings=usual_fan(ranges.shape[1]).bearings,
        base_from_laser=_AHEAD if place is None else place,
        max_range=max_range,
        has_odometry=moves(robot),
        source=source.path.name,
        sha256=source.sha256,
        format="wean",
        notes="\n".join([*found, *notes]),
    )


def _looks_right(words: list[str]) -> bool:
    if words[:1] not in (["L"], ["O"]) or (words[0] == "O") != (len(words) == 5):
        return False
    try:
        return len([float(w) for w in words[1:]]) >= 4
    except ValueError:
        return False


def _row(words: list[str]) -> np.ndarray:
    """x y theta xl yl thetal r1 ... rn ts."""
    if len(words) < 9:
        raise ValueError(f"it ends after {len(words)} fields")
    row = np.fromiter(map(float, words[1:]), float, len(words) - 1)
    if not np.isfinite(row[[0, 1, 2, 3, 4, 5, -1]]).all():
        raise ValueError("a pose or time stamp is not a usable number")
    return row
