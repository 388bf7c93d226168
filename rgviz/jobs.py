"""Mapping a log in a process of its own, so that the page stays alive, can show how it goes, and can stop it."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import shutil
import signal
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rgcore.config import Config
from rgcore.errors import RgError, one_line
from rgcore.model.records import Box2, Line, Region, RGMap
from rgcore.progress import Progress
from rgcore.scans.bags import USUAL, Topics

if TYPE_CHECKING:
    from rgcore.scans.log import ScanLog

EVERY = 0.25
"""s between two reports at most"""
MOST_POINTS = 40_000
"""points of a picture of the growing map"""


@dataclass(frozen=True)
class Report:
    """How far it is. ``points`` (K, 2) and ``path`` (N, 2) float32 [m], ``map`` where there is something new to see."""

    stage: str
    done: int
    total: int
    scans: int = 0
    points: np.ndarray | None = None
    path: np.ndarray | None = None
    map: RGMap | None = None


@dataclass(frozen=True)
class Finished:
    """The project is made, or ``error`` says in a line why not."""

    error: str | None = None


class Job:
    """Work in a process of its own. ``tell`` is called, on a thread of the job's own, with all that the child sends.

    The child calls ``work(*args, pipe)``. Where it fails and was to make a new ``project``, nothing of that stays.
    """

    def __init__(
        self,
        log: Path,
        project: Path | None,
        tell: Callable[[Any], None],
        work: Callable[..., None],
        *args: Any,
    ) -> None:
        self.log, self.project = log, project
        self._tell = tell
        self._was_there = project is not None and project.exists()
        self._cancelled = False
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe(duplex=True)
        self._child = context.Process(target=_work, args=(log, work, args, theirs), name="rgviz mapping", daemon=True)
        self._child.start()
        theirs.close()
        self._thread = threading.Thread(target=self._listen, name="rgviz mapping reports", daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """Stop it and leave nothing half made. Returns when the process is gone."""
        self._cancelled = True
        if self._child.is_alive():
            self._child.terminate()
            self._child.join(timeout=5)
        if self._child.is_alive():
            self._child.kill()
            self._child.join()
        self._thread.join(timeout=5)

    def _listen(self) -> None:
        ending = Finished("the mapping process ended without a word; map with `rgviz run --debug` to see why")
        with contextlib.suppress(EOFError, OSError):
            while True:
                message = self._pipe.recv()
                if isinstance(message, Finished):
                    ending = message
                    break
                self._tell(message)
        self._child.join()
        self._pipe.close()
        if ending.error is not None:
            self._clean()
        if not self._cancelled:
            self._tell(ending)

    def _clean(self) -> None:
        if self.project is not None and not self._was_there and not (self.project / "current").exists():
            shutil.rmtree(self.project, ignore_errors=True)


class MappingJob(Job):
    """``log`` becomes the project ``project``, as fast as it goes: reports, then how it ended."""

    project: Path

    def __init__(
        self,
        log: Path,
        project: Path,
        config: Config,
        tell: Callable[[Report | Finished], None],
        topics: Topics = USUAL,
    ) -> None:
        super().__init__(log, project, tell, self._does(), project, config, topics)

    @staticmethod
    def _does() -> Callable[..., None]:
        """What the child does, called with log, project, settings, topics and its end of the pipe."""
        return _map


class RerunJob(MappingJob):
    """``log`` is mapped for a project that is there and stays open; the new run waits in its folder then."""

    @staticmethod
    def _does() -> Callable[..., None]:
        return _map_again


def _work(log: Path, work: Callable[..., None], args: tuple[Any, ...], pipe: Connection) -> None:
    """In the child: do it, and say how it ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C reaches the whole group; the parent decides
    try:
        work(log, *args, pipe)
        pipe.send(Finished())
    except (RgError, OSError) as e:
        pipe.send(Finished(one_line(e)))
    except Exception as e:
        import traceback

        traceback.print_exc()
        pipe.send(Finished(f"mapping {log.name} failed: {type(e).__name__}: {one_line(e)}"))


def _end_with_parent(pipe: Connection) -> None:
    """The parent never sends; its end of the pipe closes when it is gone, however it went."""
    with contextlib.suppress(EOFError, OSError):
        pipe.poll(None)
        pipe.recv()
    end_this_process()


def end_this_process() -> None:
    """In the child: end as ``Job.cancel`` ends it."""
    os.kill(os.getpid(), signal.SIGTERM)


def _map(log_path: Path, project: Path, config: Config, topics: Topics, pipe: Connection) -> None:
    log = _read(log_path, topics, pipe)
    from rgviz.mapping import map_into

    map_into(project, log, config, Reporter(log, config, pipe)).close()


def _map_again(log_path: Path, project: Path, config: Config, topics: Topics, pipe: Connection) -> None:
    log = _read(log_path, topics, pipe)
    from rgviz.mapping import map_beside

    map_beside(project, log, config, Reporter(log, config, pipe, pictures=False))


def _read(path: Path, topics: Topics, pipe: Connection) -> ScanLog:
    threading.Thread(target=_end_with_parent, args=(pipe,), daemon=True).start()
    from rgcore.scans.read import read_log

    pipe.send(Report("read", 0, 1))
    return read_log(path, topics)


class Reporter:
    """Turns the progress of a mapping into reports, a few a second, with ``pictures`` of the growing map."""

    def __init__(self, log: Any, config: Config, pipe: Connection, pictures: bool = True) -> None:
        self.log, self.pipe, self.pictures = log, pipe, pictures
        self.max_range = min(config.extract.max_range, config.slam.max_range)
        self.last = ("", 0.0)
        self.map = RGMap()

    def __call__(self, p: Progress) -> None:
        if p.stage == "save":
            # Until here only the stage cache was written and a signal ends the child at once. From here on it is an
            # exception, so that what is half made is taken back.
            signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
        now = time.monotonic()
        ended = p.done >= p.total
        if not ended and self.last[0] == p.stage and now - self.last[1] < EVERY:
            return
        self.last = (p.stage, now)
        points, path, map_ = self._picture(p) if self.pictures else (None, None, None)
        self.pipe.send(Report(p.stage, p.done, p.total, len(self.log), points, path, map_))

    def _picture(self, p: Progress) -> tuple[np.ndarray | None, np.ndarray | None, RGMap | None]:
        if p.stage == "slam" and p.partial is not None:
            poses = np.asarray(getattr(p.partial, "map_from_laser", p.partial))
            return echoes(self.log, poses, self.max_range), poses[:, :2].astype(np.float32), None
        if p.stage == "places" and p.partial is not None and p.done >= p.total:
            self.map = RGMap(regions=_regions(p.partial))
            return None, None, self.map
        if p.stage == "lines" and p.partial is not None and p.done >= p.total:
            lines = p.partial[0] if isinstance(p.partial, tuple) else p.partial
            self.map = RGMap(regions=self.map.regions, lines=_lines(lines))
            return None, None, self.map
        return None, None, None


def echoes(log: Any, map_from_laser: np.ndarray, max_range: float) -> np.ndarray:
    """(K, 2) float32 [m] echoes of the first scans of a log, seen from their poses (N, 3), thinned to be quick."""
    n = min(len(map_from_laser), len(log))
    beams = log.ranges.shape[1]
    step = max(1, int(np.ceil(np.sqrt(n * beams / MOST_POINTS))))
    ranges, poses = log.ranges[:n:step, ::step], map_from_laser[:n:step]
    bearings = poses[:, 2:] + log.bearings[None, ::step]
    ok = np.isfinite(ranges) & (ranges > 0) & (ranges < max_range)
    r = np.where(ok, ranges, 0.0)
    x, y = poses[:, :1] + r * np.cos(bearings), poses[:, 1:2] + r * np.sin(bearings)
    return np.stack([x[ok], y[ok]], 1).astype(np.float32)


def _regions(places: Any) -> dict[str, Region]:
    out = {}
    for n, r in enumerate(places.regions, 1):
        box = Box2(center=r.box_center, size=r.box_size, yaw=r.box_yaw)
        out[f"r{n}"] = Region(id=f"r{n}", name=f"r{n}", class_="", boundary=r.boundary, holes=r.holes, box=box)
    return out


def _lines(lines: Any) -> dict[str, Line]:
    out = {}
    for n, (ends, region) in enumerate(zip(lines.ends.tolist(), lines.region.tolist(), strict=True), 1):
        regions = (f"r{region + 1}",) if region >= 0 else ()
        out[f"l{n}"] = Line(id=f"l{n}", start=tuple(ends[0]), end=tuple(ends[1]), regions=regions)
    return out
