"""Mapping a log scan by scan in a process of its own, no further than it is told to, so that it can be played."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from rgcore.config import Config
from rgcore.errors import InputError
from rgcore.online import GatewaySoFar, Mapper, RegionSoFar, Snapshot, Step
from rgcore.scans.bags import USUAL, Topics
from rgcore.scans.log import ScanLog
from rgviz.jobs import Finished, Job, Report, Reporter, end_this_process

BATCH = 0.1
"""s between two messages with steps at most"""
PICTURE_SCANS, PICTURE_TIME = 10, 0.5
"""A picture comes after so many scans, and not before so many seconds ..."""
PICTURES = 64
"""... but at least so many of them come in a whole log, however fast it is mapped"""
SETTLED = 0.3
"""s without a new scan after which the picture is brought up to the last one"""
MOST_POINTS, MOST_PATH, MOST_BEAMS = 12_000, 1000, 200
"""of a picture, and of a scan: what a person can tell apart on the screen, and a browser can take each second"""
NONE = np.uint16(65535)
"""no echo; the others are ranges in centimetres"""


@dataclass(frozen=True)
class Opening:
    """The log is read: ``stamps`` (N,) [s] of its scans, ``bearings`` (B,) [rad] of the beams that are shown."""

    source: str
    stamps: np.ndarray
    bearings: np.ndarray
    base_from_laser: np.ndarray
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Mapped:
    """The next scans are mapped: ``steps`` from ``first`` on, and what the laser saw, ``ranges`` (n, B) uint16 [cm]."""

    first: int
    steps: tuple[Step, ...]
    ranges: np.ndarray


@dataclass(frozen=True)
class Picture:
    """The map when scan ``scan`` had come in: ``points`` (P, 2), ``path`` (N, 2) of all scans so far, thinned [m].

    ``regions`` and ``gateways`` are None where they are those of the picture before (they are sent once).
    """

    scan: int
    survey: int
    points: np.ndarray
    path: np.ndarray
    regions: tuple[RegionSoFar, ...] | None = None
    gateways: tuple[GatewaySoFar, ...] | None = None


Message = Opening | Mapped | Picture | Report | Finished


class PlayJob(Job):
    """Maps a log up to the scan that it is allowed; after the last one it makes ``project``, if it was given one."""

    def __init__(
        self,
        log: Path,
        project: Path | None,
        config: Config,
        tell: Callable[[Message], None],
        topics: Topics = USUAL,
        sha256: str | None = None,
    ) -> None:
        """``sha256``: what the log must be, where it is that of a project."""
        super().__init__(log, project, tell, _play, project, config, topics, sha256)
        self._allowed = 0

    def allow(self, scans: int) -> None:
        """Let it map the first ``scans`` scans, and stop there. It may have gone further already."""
        if scans != self._allowed:
            self._allowed = scans
            try:
                self._pipe.send(scans)
            except OSError:  # it has ended; its last words are on the way
                return


def _play(
    path: Path, project: Path | None, config: Config, topics: Topics, sha256: str | None, pipe: Connection
) -> None:
    """In the child: read, map as far as is allowed, finish."""
    leash = _Leash(pipe)
    from rgcore.cache import Cache
    from rgcore.scans.read import read_log
    from rgviz.mapping import create

    pipe.send(Report("read", 0, 1))
    log = read_log(path, topics)
    if sha256 is not None and log.sha256 != sha256:
        raise InputError(path, "not the log that the project was made from; give that one with `rgviz play LOG`")
    mapper = Mapper.of(log, config)
    teller = _Teller(log, mapper, pipe)
    for k in range(len(log)):
        if not leash.free(k, 0.0):
            teller.tell()
            if not leash.free(k, SETTLED):
                teller.draw()
                leash.free(k, None)
        teller.hear(mapper.add(log.ranges[k], log.odom_from_base[k] if log.has_odometry else None, log.stamps[k]))
    teller.tell()
    teller.draw()
    if project is not None:
        watch = Reporter(log, config, pipe)
        create(project, mapper.finish(log, Cache(project / "cache"), watch), watch).close()


class _Leash:
    """How far the child may go: the parent says so, whenever it likes. Ends the process when the parent is gone."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe, self._allowed, self._changed = pipe, 0, threading.Condition()
        threading.Thread(target=self._listen, daemon=True).start()

    def free(self, scan: int, timeout: float | None) -> bool:
        """Whether ``scan`` may be mapped; waits for it up to ``timeout`` [s], for ever with None."""
        with self._changed:
            return self._changed.wait_for(lambda: scan < self._allowed, timeout)

    def _listen(self) -> None:
        try:
            while True:
                allowed = self._pipe.recv()
                with self._changed:
                    self._allowed = allowed
                    self._changed.notify()
        except (EOFError, OSError):
            end_this_process()


@dataclass
class _Teller:
    """Gathers steps into messages, and draws a picture where one is due."""

    log: ScanLog
    mapper: Mapper
    pipe: Connection
    steps: list[Step] = field(default_factory=list)
    sent: float = 0.0
    drawn: tuple[int, float] = (-1, 0.0)
    last: Snapshot | None = None

    def __post_init__(self) -> None:
        self.beams = slice(None, None, -(-len(self.log.bearings) // MOST_BEAMS))
        self.often = max(PICTURE_SCANS, len(self.log) // PICTURES)
        notes = tuple(self.log.notes.splitlines())
        bearings = self.log.bearings[self.beams]
        self.pipe.send(Opening(self.log.source, self.log.stamps, bearings, self.log.base_from_laser, notes))

    def hear(self, step: Step) -> None:
        """One more scan is mapped."""
        self.steps.append(step)
        now, (scan, at) = time.monotonic(), self.drawn
        if now - self.sent > BATCH:
            self.tell()
        since = step.scan - scan
        if since >= self.often or (since >= PICTURE_SCANS and now - at > PICTURE_TIME):
            self.draw()

    def tell(self) -> None:
        if self.steps:
            first = self.steps[0].scan
            ranges = centimetres(self.log, slice(first, first + len(self.steps)))[:, self.beams]
            self.pipe.send(Mapped(first, tuple(self.steps), ranges))
            self.steps, self.sent = [], time.monotonic()

    def draw(self) -> None:
        if len(self.mapper) - 1 == self.drawn[0]:
            return
        self.tell()
        snapshot = self.mapper.snapshot()
        before, self.last = self.last, snapshot
        picture = Picture(
            snapshot.scan,
            snapshot.survey,
            thinned(snapshot.points, MOST_POINTS),
            thinned(snapshot.poses[:, :2], MOST_PATH),
            snapshot.regions,
            snapshot.gateways,
        )
        if before is not None and before.regions == snapshot.regions and before.gateways == snapshot.gateways:
            picture = replace(picture, regions=None, gateways=None)
        self.pipe.send(picture)
        self.drawn = (snapshot.scan, time.monotonic())


def centimetres(log: ScanLog, scans: slice) -> np.ndarray:
    """(n, B) uint16 ranges of some scans [cm]; ``NONE`` where there is no echo."""
    ranges = log.ranges[scans]
    ok = np.isfinite(ranges) & (ranges > 0) & (ranges < min(log.max_range, 655.0))
    return np.where(ok, np.round(100 * np.where(ok, ranges, 0.0)), NONE).astype(np.uint16)


def thinned(points: np.ndarray, most: int) -> np.ndarray:
    """At most ``most`` rows of (N, 2): every second, fourth, eighth ..., so that most stay while there come more."""
    step = 1
    while -(-len(points) // step) > most:
        step *= 2
    return points[::step]
