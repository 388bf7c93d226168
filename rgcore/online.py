"""Mapping online: one scan at a time, with the place that the robot is in (paper, sections III and IV-D)."""

from __future__ import annotations

import msgspec
import numpy as np

from rgcore import pipeline
from rgcore.config import Config
from rgcore.model.records import RGMap
from rgcore.places.automaton import AnyEvent, Pose, State
from rgcore.scans.log import ScanLog


class Step(msgspec.Struct, frozen=True, kw_only=True):
    """What is known when a scan has come in.

    ``pose`` is map_from_base in the map so far; ``deviation`` its standard deviations [m, m, rad] against the local map
    (None where nothing was registered, as for the first scan). ``region`` and ``class_`` are None while the robot is
    entering an unknown region; ``class_`` also while the region is unclassified.
    """

    scan: int
    stamp: float
    pose: Pose
    deviation: tuple[float, float, float] | None = None
    state: State
    region: str | None = None
    class_: str | None = msgspec.field(default=None, name="class")
    events: tuple[AnyEvent, ...] = ()


class RegionSoFar(msgspec.Struct, frozen=True, kw_only=True):
    """A region of the map so far; its id stays while it is the same place. Ring counter-clockwise, map frame [m]."""

    id: str
    class_: str | None = msgspec.field(name="class")
    boundary: tuple[tuple[float, float], ...]
    visited: bool


class GatewaySoFar(msgspec.Struct, frozen=True, kw_only=True):
    """A gateway of the map so far."""

    id: str
    regions: tuple[str, ...]
    posts: tuple[tuple[float, float], tuple[float, float]]
    passed: bool


class Snapshot(msgspec.Struct, frozen=True, kw_only=True):
    """A picture of the map so far, cheap enough to be drawn a few times a second.

    poses   (N, 3) float32, map_from_base of all scans so far, as they stand now
    points  (P, 2) float32, surface points of the keyframes, map frame [m]
    """

    scan: int
    poses: np.ndarray
    points: np.ndarray
    regions: tuple[RegionSoFar, ...]
    gateways: tuple[GatewaySoFar, ...]


class Mapper:
    """Maps while the scans come in: ``add`` each, look at ``snapshot`` or ``map`` when wanted, ``finish`` at the end.

    The same log gives the same steps, however fast it is fed. ``finish`` gives what :func:`rgcore.pipeline.run` gives
    for the same scans.
    """

    def __init__(
        self,
        bearings: np.ndarray,
        base_from_laser: np.ndarray,
        config: Config | None = None,
        has_odometry: bool = True,
        max_range: float = np.inf,
        places: bool = True,
    ) -> None:
        """``bearings`` (B,) [rad] of the beams, ``base_from_laser`` (3,) the laser's mounting, ``max_range`` [m] the
        longest range that it reports as an echo. Without ``places`` there are only poses, and no regions and events.
        """
        raise NotImplementedError

    @classmethod
    def of(cls, log: ScanLog, config: Config | None = None, places: bool = True) -> Mapper:
        """A mapper for the laser of a log, still without scans."""
        raise NotImplementedError

    def add(self, ranges: np.ndarray, odom_from_base: np.ndarray | None, stamp: float) -> Step:
        """The next scan: ``ranges`` (B,) [m] (``inf`` no echo, ``nan`` no information), and where odometry says the
        robot is (3,); None without odometry. Takes a millisecond or two.
        """
        raise NotImplementedError

    def snapshot(self) -> Snapshot:
        """What the map so far looks like. Takes some milliseconds."""
        raise NotImplementedError

    def regions(self) -> tuple[RegionSoFar, ...]:
        """The regions of the map so far, in the order of their ids."""
        raise NotImplementedError

    def map(self) -> RGMap:
        """The RG map so far, with lines, classes and objects, ids as in the steps. Takes up to seconds."""
        raise NotImplementedError

    def finish(self, log: ScanLog | None = None) -> pipeline.Run:
        """The final optimisation, and everything that the batch makes of it.

        ``log``: the log that was fed, so that the map names it (source, format); otherwise one is made of the scans.
        Sets ``final``: id of the steps -> id in the final map, for regions.
        """
        raise NotImplementedError
