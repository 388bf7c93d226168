"""What lies where in a project's folder, and how it is read and written."""

from __future__ import annotations

import hashlib
import io
import re
import shutil
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import msgspec
import numpy as np

from rgcore import __version__
from rgcore.errors import ProjectError
from rgcore.evidence import Evidence
from rgcore.geometry.segments import transformed
from rgcore.lines.adaptation import Adaptation
from rgcore.model.base import decode_map, encode_map
from rgcore.model.cloud import thinned
from rgcore.model.disk import replace_file, sync_folder, write_file
from rgcore.model.history import AnyEntry
from rgcore.model.journal import encode_journal
from rgcore.model.outcome import Outcome
from rgcore.model.records import RGMap
from rgcore.slam.trajectory import Trajectory

if TYPE_CHECKING:
    from rgcore.pipeline import Run

T = TypeVar("T")
VERSION = 1
SAMPLE = 1000
"""Scans that are kept in a run to measure a corrected map by."""
AGAIN = "map the log again with `rgviz run LOG -o PROJECT.rg`"


class LogInfo(msgspec.Struct, frozen=True):
    path: str
    sha256: str


class ProjectInfo(msgspec.Struct, frozen=True, kw_only=True):
    """project.toml"""

    version: int
    name: str
    log: LogInfo


class RunInfo(msgspec.Struct, frozen=True, kw_only=True):
    """run.json: what a run was made from and how long each stage took [s]."""

    log: str
    sha256: str
    format: str
    notes: tuple[str, ...]
    """what the reader met in the log, and where its scans could not be joined"""
    scans: int
    beams: int
    points: int
    """valid readings used"""
    has_odometry: bool
    settings: dict[str, Any]
    """only those that differ from the defaults, as {"stage.name": value}"""
    config: dict[str, dict[str, Any]]
    """all settings, by stage"""
    seconds: dict[str, float]
    software: str


def check(path: Path) -> ProjectInfo:
    """What project.toml says. Raises ProjectError if ``path`` is no project, or one of a newer version."""
    if path.is_file():
        raise ProjectError(f"{path}: a file, not a project; {AGAIN}")
    if not path.is_dir():
        raise ProjectError(f"{path}: there is no such project; {AGAIN}")
    file = path / "project.toml"
    if not file.exists():
        raise ProjectError(f"{path}: not a project: it holds no project.toml; {AGAIN}")
    try:
        version = msgspec.toml.decode(file.read_bytes()).get("version")
        if isinstance(version, int) and version > VERSION:
            raise ProjectError(
                f"{path}: made by a newer rgviz (project version {version}, this one reads up to {VERSION});"
                " upgrade with `pip install -U rgviz`"
            )
        return msgspec.toml.decode(file.read_bytes(), type=ProjectInfo)
    except (OSError, msgspec.DecodeError, ValueError) as e:
        raise ProjectError(f"{file}: damaged: {e}; restore it from a copy") from e


def current(path: Path) -> str:
    """The name of the current run. Raises ProjectError."""
    runs = sorted(p.name for p in (path / "runs").glob("[0-9]*") if p.is_dir())
    try:
        name = (path / "current").read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError):
        name = ""
    if name in runs:
        return name
    if not runs:
        raise ProjectError(f"{path}: holds no finished run; {AGAIN}")
    remedy = f"write one of {', '.join(runs)} into that file"
    raise ProjectError(f"{path / 'current'}: names no run of this project; {remedy}")


def claim(path: Path) -> bool:
    """Make the folder that a new project goes into; False if it is there and holds nothing but remains of one.

    Raises ProjectError if it holds anything else.
    """
    if path.exists() and (not path.is_dir() or (path / "current").exists() or not _unfinished(path)):
        raise ProjectError(f"{path}: there is something already; choose another name, or remove it")
    try:
        made = not path.exists()
        path.mkdir(parents=True, exist_ok=True)
        return made
    except OSError as e:
        raise unwritable(path, e) from e


def create(path: Path, run: Run) -> None:
    """A new project with its first run in a claimed folder. Raises ProjectError; the folder is then without one."""
    info = ProjectInfo(version=VERSION, name=path.stem, log=LogInfo(run.log.source, run.log.sha256))
    try:
        shutil.rmtree(path / "runs", ignore_errors=True)
        replace_file(path / "project.toml", msgspec.toml.encode(info))
        _write_run(path, "0001", run, (), ())
    except BaseException as e:
        shutil.rmtree(path / "runs", ignore_errors=True)
        for name in ("current", "project.toml"):
            (path / name).unlink(missing_ok=True)
        if isinstance(e, OSError):
            raise unwritable(path, e) from e
        raise


def _unfinished(path: Path) -> bool:
    """Whether a folder holds nothing but what an unfinished ``create`` or the stage cache may have left."""
    return all(re.fullmatch(r"project\.toml|runs|cache|lock|\..*\.tmp", p.name) for p in path.iterdir())


def add_run(path: Path, run: Run, entries: Sequence[AnyEntry], conflicts: Sequence[Outcome]) -> None:
    """One more run, which becomes the current one. Raises ProjectError; the project is then as it was."""
    try:
        _write_run(path, next_name(path), run, entries, conflicts)
    except OSError as e:
        raise unwritable(path, e) from e


def next_name(path: Path) -> str:
    """What the next run of a project is called."""
    last = max((int(p.name) for p in (path / "runs").iterdir() if p.name.isdigit()), default=0)
    return f"{last + 1:04d}"


def _write_run(path: Path, name: str, run: Run, entries: Sequence[AnyEntry], conflicts: Sequence[Outcome]) -> None:
    """Write a run's folder whole under another name, then give it its own and make it the current one."""
    new = path / "runs" / f".{name}.tmp"
    shutil.rmtree(new, ignore_errors=True)
    try:
        new.mkdir(parents=True)
        write_evidence(new, run)
        write_edits(new, entries, conflicts)
        sync_folder(new)
        make_current(path, new, name)
    except BaseException:
        shutil.rmtree(new, ignore_errors=True)
        raise


def make_current(path: Path, new: Path, name: str) -> None:
    """Give the folder of a run that is written whole its name, and make it the current one. Raises OSError."""
    new.rename(path / "runs" / name)
    sync_folder(path / "runs")
    replace_file(path / "current", f"{name}\n".encode())


def write_evidence(new: Path, run: Run) -> None:
    """All that a run's folder holds but for the edits. Raises OSError."""
    points, scans = thinned(run.log, run.trajectory, run.config.slam.max_range)
    write_file(new / "run.json", _json(_info(run)))
    write_file(new / "trajectory.npz", _saved(run.trajectory))
    write_file(new / "points.npz", _npz(points=points, scans=scans))
    if run.segments is not None:
        write_file(new / "segments.npz", _npz(**_segments(run)))
    write_file(new / "base.json", encode_map(run.map))
    if run.adaptation is not None:
        write_file(new / "adapt.json", msgspec.json.encode(run.adaptation, order="sorted"))


def write_edits(new: Path, entries: Sequence[AnyEntry], conflicts: Sequence[Outcome]) -> None:
    """The edits on a run, and those that are not made on it. Raises OSError."""
    write_file(new / "edits.jsonl", encode_journal(entries))
    write_file(new / "conflicts.json", _json(list(conflicts)))


def _segments(run: Run) -> dict[str, np.ndarray]:
    """Lines of all scans before merging, readings used of each scan, and the size of the bare scans: for a report."""
    s, log = run.segments, run.log
    ends = transformed(run.trajectory.map_from_laser[s.scan], s.ends)
    usable = log.usable(run.config.slam.max_range)
    millimetres = np.clip(1000.0 * np.where(usable, log.ranges, 0.0), 0, 65535).round().astype(np.uint16)
    sample = np.arange(0, len(log), max(1, -(-len(log) // SAMPLE)))
    return {
        "ends": ends.astype(np.float32),
        "scan": s.scan.astype(np.int32),
        "readings": usable.sum(1).astype(np.int32),
        "deflated": np.array(len(zlib.compress((millimetres // 10).tobytes()))),
        "sample": sample.astype(np.int32),
        "ranges": millimetres[sample],
        "bearings": log.bearings,
    }


def _info(run: Run) -> RunInfo:
    log, source = run.log, run.map.source
    return RunInfo(
        log=log.source,
        sha256=log.sha256,
        format=log.format,
        notes=(*log.notes.splitlines(), *run.trajectory.notes),
        scans=len(log),
        beams=log.ranges.shape[1],
        points=run.map.stats.points,
        has_odometry=bool(log.has_odometry),
        settings=source.settings,
        config=msgspec.to_builtins(run.config),
        seconds={k: round(v, 3) for k, v in run.seconds.items()},
        software=f"rgviz {__version__}",
    )


def read_info(where: Path) -> RunInfo:
    return _read(where / "run.json", lambda data: msgspec.json.decode(data, type=RunInfo))


def read_base(where: Path) -> RGMap:
    return _read(where / "base.json", decode_map)


class KeptSegments(NamedTuple):
    """``ends`` (M, 2, 2) m, map frame, of all scans, and the ``scan`` (M,) of each; ``readings`` used by scan (N,);
    ``deflated``: bytes of the bare scans, two a reading (centimetres), compressed by zlib. ``sample`` (S,): scans whose
    ``ranges`` (S, B) [m], 0 = none, at ``bearings`` (B,) are kept, so that a corrected map can be measured.
    """

    ends: np.ndarray
    scan: np.ndarray
    readings: np.ndarray
    deflated: int
    sample: np.ndarray
    ranges: np.ndarray
    bearings: np.ndarray


def read_segments(where: Path) -> KeptSegments | None:
    """The segments of a run; None in one of an older version, which kept none."""

    def segments(data: bytes) -> KeptSegments:
        with np.load(io.BytesIO(data), allow_pickle=False) as a:
            ranges = a["ranges"].astype(float) / 1000.0
            own = a["ends"], a["scan"], a["readings"], int(a["deflated"]), a["sample"], ranges, a["bearings"]
            return KeptSegments(*own)

    file = where / "segments.npz"
    return _read(file, segments) if file.exists() else None


def read_adaptation(where: Path) -> Adaptation | None:
    """What the parameters adapted to; None in a run without it, of an older version or with it switched off."""
    file = where / "adapt.json"
    return _read(file, lambda data: msgspec.json.decode(data, type=Adaptation)) if file.exists() else None


def read_conflicts(where: Path) -> tuple[Outcome, ...]:
    """Edits that are not in the journal of a run: they wait, or there was nothing left to do."""
    file = where / "conflicts.json"
    return _read(file, lambda data: msgspec.json.decode(data, type=tuple[Outcome, ...])) if file.exists() else ()


def read_trajectory(where: Path) -> Trajectory:
    return _read(where / "trajectory.npz", lambda data: Trajectory.load(io.BytesIO(data)))  # type: ignore[arg-type]


def read_points(where: Path) -> tuple[np.ndarray, np.ndarray]:
    def points(data: bytes) -> tuple[np.ndarray, np.ndarray]:
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            return arrays["points"], arrays["scans"]

    return _read(where / "points.npz", points)


def keep_backdrop(path: Path, sha256: str, data: bytes) -> None:
    """Keep the file of a floor plan, once, under its checksum. Raises ProjectError."""
    file = path / "backdrops" / sha256
    try:
        if not file.exists():
            file.parent.mkdir(exist_ok=True)
            replace_file(file, data)
    except OSError as e:
        raise unwritable(path, e) from e


def read_backdrop(path: Path, sha256: str) -> bytes:
    """The file of a floor plan. Raises ProjectError if it is not there, or not what was put there."""
    file = path / "backdrops" / re.sub(r"[^0-9a-f]", "", sha256)
    try:
        data = file.read_bytes()
    except OSError as e:
        raise ProjectError(f"{file}: cannot be read: {e.strerror}; lay the plan under the map again") from e
    if hashlib.sha256(data).hexdigest() != sha256:
        raise ProjectError(f"{file}: is not the plan that was laid under the map; lay it there again")
    return data


def _read(file: Path, parse: Callable[[bytes], T]) -> T:
    """What ``parse`` makes of a file. Raises ProjectError if the file is absent or damaged."""
    try:
        return parse(file.read_bytes())
    except OSError as e:
        raise ProjectError(f"{file}: cannot be read: {e.strerror}; restore it from a copy, or {AGAIN}") from e
    except Exception as e:  # a damaged zip or JSON fails in a dozen ways, and the remedy is one
        raise ProjectError(f"{file}: damaged: {e}; restore it from a copy, or {AGAIN}") from e


def _npz(**arrays: np.ndarray) -> bytes:
    out = io.BytesIO()
    np.savez_compressed(out, **arrays)  # type: ignore[arg-type]
    return out.getvalue()


def _saved(evidence: Evidence) -> bytes:
    out = io.BytesIO()
    evidence.save(out)  # type: ignore[arg-type]
    return out.getvalue()


def _json(value: Any) -> bytes:
    return msgspec.json.format(msgspec.json.encode(value, order="sorted"), indent=1) + b"\n"


def unwritable(path: Path, e: OSError) -> ProjectError:
    """What to raise where the disk refused."""
    return ProjectError(f"{path}: cannot be written: {e.strerror}; make room or choose another place")
