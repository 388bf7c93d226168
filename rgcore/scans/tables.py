"""Scans as tables: CSV, and NPZ of arrays, for logs of one's own.

CSV: a line a scan under one heading, ``stamp,x,y,theta,range_0,range_1,...`` (s, m, rad; x y theta: raw odometry of the
robot's centre; all but the ranges may be absent; an empty cell is no information, ``inf`` is no echo). Lines ``# name
= value`` before the heading tell ``angle_min``, ``angle_increment`` [rad], ``max_range`` [m] and the laser's place
``laser_x``, ``laser_y``, ``laser_theta``; without angles, 180 degrees straight ahead.

NPZ: the fields of :class:`~rgcore.scans.log.ScanLog` under their names: ``ranges`` (N, B) and ``bearings`` (B,), and if
there are any ``stamps`` (N,), ``odom_from_base`` (N, 3), ``base_from_laser`` (3,), ``max_range``.
"""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Mapping
from itertools import count, takewhile

import numpy as np

from rgcore.errors import InputError
from rgcore.geometry import se2
from rgcore.scans.beams import Fan, usual_fan
from rgcore.scans.echoes import mark_echoes
from rgcore.scans.log import ScanLog
from rgcore.scans.mounting import moves
from rgcore.scans.source import LARGEST, Source

_ZIP = b"PK\x03\x04"
_POSE = ("x", "y", "theta")
_SETTINGS = ("angle_min", "angle_increment", "max_range", "laser_x", "laser_y", "laser_theta")


def sniff_npz(source: Source) -> bool:
    """Whether a file is a ZIP archive of arrays."""
    return source.data.startswith(_ZIP)


def sniff_csv(source: Source) -> bool:
    """Whether the first line that is no remark is a heading with ranges."""
    heading = next((line for line in source.lines[:200] if line.strip() and not line.startswith("#")), "")
    return "range_0" in [w.strip().strip('"') for w in heading.split(",")]


def read_csv(source: Source) -> ScanLog:
    """The scans of a CSV file. Raises InputError with the line that is wrong."""
    settings = _settings(source)
    start = next(i for i, line in enumerate(source.lines) if line.strip() and not line.startswith("#"))
    try:
        names = [n.strip() for n in next(csv.reader([source.lines[start]]))]
    except csv.Error as e:
        raise source.error(f"damaged heading: {e}", start + 1) from e
    beams = sum(1 for _ in takewhile(lambda k: f"range_{k}" in names, count()))
    known = {"stamp", *_POSE, *(f"range_{k}" for k in range(beams))}
    if set(names) != known & set(names) or len(set(names)) < len(names):
        odd = next(n for i, n in enumerate(names) if n not in known or n in names[:i])
        raise source.error(
            f"column '{odd[:30]}' is not known or there twice; known are stamp x y theta range_0 ...", start + 1
        )
    rows = _rows(source, start, len(names))
    column = {name: rows[:, i] for i, name in enumerate(names)}
    readings = np.stack([column[f"range_{k}"] for k in range(beams)], 1)
    has_angles = {"angle_min", "angle_increment"} <= set(settings)
    fan = Fan(beams, settings["angle_min"], settings["angle_increment"]) if has_angles else usual_fan(beams)
    pose = np.stack([column[n] for n in _POSE], 1) if set(_POSE) <= set(names) else None
    stamps = column.get("stamp")
    laser = np.array([settings.get(f"laser_{n}", 0.0) for n in _POSE])
    return _as_log(source, "csv", readings, fan.bearings, pose, stamps, laser, settings.get("max_range"))


def read_npz(source: Source) -> ScanLog:
    """The scans of an NPZ file. Raises InputError that names the array that is wrong."""
    arrays = _arrays(source)
    for name in ("ranges", "bearings"):
        if name not in arrays:
            raise source.error(f"holds no array '{name}', only: {', '.join(sorted(arrays)[:8]) or 'nothing'}")
    ranges, bearings = arrays["ranges"], arrays["bearings"]
    if ranges.ndim != 2:
        raise source.error(f"ranges must be (scans, beams), not {ranges.shape}")
    n, beams = ranges.shape
    shapes = {"bearings": (beams,), "stamps": (n,), "odom_from_base": (n, 3), "base_from_laser": (3,), "max_range": ()}
    for name, shape in shapes.items():
        if name in arrays and arrays[name].shape != shape:
            raise source.error(f"{name} must have the shape {shape}, not {arrays[name].shape}")
    if not np.isfinite(bearings).all():
        raise source.error("bearings must be finite numbers [rad]")
    laser = arrays.get("base_from_laser", np.zeros(3))
    limit = float(arrays["max_range"]) if "max_range" in arrays else None
    pose, stamps = arrays.get("odom_from_base"), arrays.get("stamps")
    return _as_log(source, "npz", ranges, bearings, pose, stamps, laser, limit)


def _as_log(
    source: Source,
    format_: str,
    readings: np.ndarray,
    bearings: np.ndarray,
    pose: np.ndarray | None,
    stamps: np.ndarray | None,
    base_from_laser: np.ndarray,
    max_range: float | None,
) -> ScanLog:
    if not readings.size:
        raise source.error("holds no readings; nothing to map")
    for name, values in (("odometry", pose), ("stamps", stamps), ("the laser's place", base_from_laser)):
        if values is not None and not np.isfinite(values).all():
            where = np.flatnonzero(~np.isfinite(values).reshape(len(values), -1).all(1))[0]
            raise source.error(f"{name}: row {where} is not finite; leave the scan out or repair it")
    if len(bearings) > 1 and bearings[-1] < bearings[0]:  # a laser that turns clockwise
        readings, bearings = readings[:, ::-1], bearings[::-1]
    marked = np.isinf(readings).any()  # then the top value is an echo, not a code
    ranges, longest, notes = mark_echoes(readings, None if marked else max_range)
    if pose is None or not moves(pose):
        notes.append("the log has no odometry")
        pose = np.zeros((len(ranges), 3))
    return ScanLog(
        stamps=np.arange(len(ranges), dtype=float) if stamps is None else stamps,
        ranges=ranges,
        odom_from_base=np.column_stack([pose[:, :2], se2.wrap(pose[:, 2])]),
        bearings=np.ascontiguousarray(bearings),
        base_from_laser=base_from_laser,
        max_range=longest,
        has_odometry=moves(pose),
        source=source.path.name,
        sha256=source.sha256,
        format=format_,
        notes="\n".join(notes),
    )


def _settings(source: Source) -> dict[str, float]:
    """The ``# name = value`` lines before the heading."""
    out = {}
    for number, line in enumerate(takewhile(lambda x: x.startswith("#") or not x.strip(), source.lines), 1):
        name, equals, value = line.lstrip("#").partition("=")
        if equals and name.strip() in _SETTINGS:
            try:
                out[name.strip()] = float(value)
            except ValueError as e:
                raise source.error(f"{name.strip()} must be a number, not '{value.strip()[:20]}'", number) from e
            if not np.isfinite(out[name.strip()]):
                raise source.error(f"{name.strip()} must be finite", number)
    return out


def _rows(source: Source, start: int, width: int) -> np.ndarray:
    """The lines under the heading as numbers (N, width); empty cells are nan."""
    rows = []
    for number, line in enumerate(source.lines[start + 1 :], start + 2):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            cells = next(csv.reader([line]))
            if len(cells) != width:
                raise ValueError(f"it has {len(cells)} cells, the heading {width}")
            rows.append([float(c) if c.strip() else np.nan for c in cells])
        except (ValueError, csv.Error) as e:
            if number == source.last_line and source.ends_open and rows:
                break  # cut off while it was written
            raise source.error(f"damaged line: {e}; repair or delete it", number) from e
    if not rows:
        raise source.error("holds a heading and no scans; nothing to map")
    return np.array(rows)


def _arrays(source: Source) -> Mapping[str, np.ndarray]:
    """The arrays of numbers in an archive; others (the name of a source) are passed over."""
    try:
        with zipfile.ZipFile(io.BytesIO(source.data)) as z:
            size = sum(i.file_size for i in z.infolist())
        if size > LARGEST:
            raise source.error(f"unpacks to {size / 2**30:.0f} GB; that is no log of scans")
        with np.load(io.BytesIO(source.data), allow_pickle=False) as data:
            found = {name: data[name] for name in data.files}
    except InputError:
        raise
    except Exception as e:  # zipfile, zlib, struct and NumPy each have their own
        reason = (str(e).splitlines() or [type(e).__name__])[0]
        raise source.error(f"the archive cannot be read: {reason}; write it with numpy.savez_compressed") from e
    return {name: a.astype(float) for name, a in found.items() if isinstance(a, np.ndarray) and a.dtype.kind in "fiub"}
