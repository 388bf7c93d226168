"""Mapping online: one scan at a time, with the place that the robot is in (paper, sections III and IV-D)."""

from __future__ import annotations

import msgspec
import numpy as np

from rgcore import pipeline
from rgcore.cache import Cache
from rgcore.config import Config
from rgcore.geometry import se2
from rgcore.model.records import RGMap, replace
from rgcore.places.automaton import AnyEvent, Event, Pose, State
from rgcore.places.following import Follower, Outlines
from rgcore.progress import Watcher, silent
from rgcore.scans.log import ScanLog
from rgcore.slam.local import covariance
from rgcore.slam.lrgc import Lrgc
from rgcore.slam.trajectory import Trajectory


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
    holes: tuple[tuple[tuple[float, float], ...], ...] = ()
    visited: bool
    """whether the robot has been in it; False: it only looked in"""


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
    survey  another number means other regions and gateways
    """

    scan: int
    poses: np.ndarray
    points: np.ndarray
    survey: int
    regions: tuple[RegionSoFar, ...]
    gateways: tuple[GatewaySoFar, ...]


class Mapper:
    """Maps while the scans come in: ``add`` each, look at ``snapshot`` or ``map`` when wanted, ``finish`` at the end.

    The same log gives the same steps, however fast it is fed. ``finish`` gives what :func:`rgcore.pipeline.run` gives
    for the same scans; ``final`` is then the region of that map for each region id of the steps.
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
        self.config, self.has_odometry, self.max_range = config or Config(), has_odometry, max_range
        self.bearings, self.base_from_laser = np.array(bearings, float), np.array(base_from_laser, float)
        self.final: dict[str, str] = {}
        self._laser_from_base = se2.invert(self.base_from_laser)
        self._lrgc = Lrgc(self.bearings, self.config.slam, has_odometry)
        self._keyframes = np.zeros((0, 3))  # where they stood after the last scan
        self._ranges: list[np.ndarray] = []
        self._odometry: list[np.ndarray] = []
        self._stamps: list[float] = []
        self._follower: Follower | None = None
        if places:
            self._follower = Follower(self.bearings, self.base_from_laser, max_range, self.config)
        self._outlines: tuple[int, Outlines] = (-1, {})

    @classmethod
    def of(cls, log: ScanLog, config: Config | None = None, places: bool = True) -> Mapper:
        """A mapper for the laser of a log, still without scans."""
        return cls(log.bearings, log.base_from_laser, config, log.has_odometry, log.max_range, places)

    def __len__(self) -> int:
        return len(self._stamps)

    def add(self, ranges: np.ndarray, odom_from_base: np.ndarray | None, stamp: float) -> Step:
        """The next scan: ``ranges`` (B,) [m] (``inf`` no echo, ``nan`` no information), and where odometry says the
        robot is (3,); None without odometry. Takes a millisecond or two.
        """
        ranges = np.array(ranges, float)
        odometry = np.zeros(3) if odom_from_base is None else np.array(odom_from_base, float)
        self._ranges.append(ranges)
        self._odometry.append(odometry)
        self._stamps.append(float(stamp))
        laser = self._lrgc.add(ranges, se2.compose(odometry, self.base_from_laser))
        pose = se2.compose(laser, self._laser_from_base)
        keyframes = self._lrgc.keyframes.poses
        new = len(keyframes) > len(self._keyframes)
        bent = new and not np.array_equal(keyframes[: len(self._keyframes)], self._keyframes)
        if new:
            self._keyframes = keyframes.copy()
        k = len(self) - 1
        at = (float(pose[0]), float(pose[1]), float(pose[2]))
        if self._follower is None:
            return Step(scan=k, stamp=float(stamp), pose=at, deviation=self._deviation(), state="in-unclassified")
        events: list[Event] = self._follower.bend(self.poses()[:-1], float(stamp)) if bent else []
        events += self._follower.add(ranges, pose, float(stamp), new)
        now = self._follower.automaton
        return Step(
            scan=k,
            stamp=float(stamp),
            pose=at,
            deviation=self._deviation(),
            state=now.state,
            region=now.region,
            class_=now.class_,
            events=tuple(events),  # type: ignore[arg-type]
        )

    def poses(self) -> np.ndarray:
        """(N, 3) map_from_base of the scans so far, as they stand now."""
        poses: np.ndarray = se2.compose(self._lrgc.poses(), self._laser_from_base)
        return poses

    def _deviation(self) -> tuple[float, float, float] | None:
        """How far off the last scan may be on the local map: much where it does not see, as along a hallway."""
        match = self._lrgc.match
        if match is None:
            return None
        x, y, t = np.sqrt(np.diag(covariance(match)))
        return float(x), float(y), float(t)

    def settled(self) -> tuple[str | None, ...]:
        """The region that each scan so far was taken in, as the map so far sees it now; None outside all."""
        if self._follower is None:
            return (None,) * len(self)
        at = self._follower.places.labels.at(self._follower.poses[: len(self), :2], outside=-1)
        return tuple(f"r{i}" if i >= 0 else None for i in at.tolist())

    def snapshot(self) -> Snapshot:
        """What the map so far looks like. Takes some milliseconds, and some more for regions that have changed."""
        frames = self._lrgc.keyframes
        surfaces, start = frames.surfaces, np.asarray(frames.surfaces.start)
        of = np.repeat(np.arange(len(frames)), np.diff(start))
        return Snapshot(
            scan=len(self) - 1,
            poses=self.poses().astype(np.float32),
            points=se2.transform(frames.poses[of], surfaces.points).astype(np.float32),
            survey=self._follower.places.scans if self._follower else 0,
            regions=self.regions(),
            gateways=self.gateways(),
        )

    def regions(self) -> tuple[RegionSoFar, ...]:
        """The regions of the map so far, in the order of their ids."""
        if self._follower is None:
            return ()
        places, automaton = self._follower.places, self._follower.automaton
        if self._outlines[0] != places.scans:
            self._outlines = (places.scans, self._follower.outlines(self._outlines[1]))
        return tuple(
            RegionSoFar(
                id=f"r{i}",
                class_=automaton.classes.get(f"r{i}"),
                boundary=found.boundary,
                holes=found.holes,
                visited=f"r{i}" in automaton.known,
            )
            for i, (_, found) in sorted(self._outlines[1].items())
        )

    def gateways(self) -> tuple[GatewaySoFar, ...]:
        """The gateways of the map so far, in the order of their ids."""
        if self._follower is None:
            return ()
        poses = self._follower.poses
        return tuple(
            GatewaySoFar(
                id=f"g{g.number}",
                regions=tuple(f"r{r}" for r in g.found.regions),
                posts=_points(g.posts(poses)),
                passed=g.found.passed,
            )
            for g in sorted(self._follower.places.gateways, key=lambda g: g.number)
            if g.found is not None
        )

    def map(self) -> RGMap:
        """The RG map so far: with lines, classes and objects, as the batch makes it of the scans and poses so far.

        Region ids are those of the steps; regions that no step has told of yet come after them. Takes up to seconds.
        Raises what :func:`rgcore.pipeline.run` raises.
        """
        log = self.log()
        run = pipeline.run(log, self.config, known=Trajectory(log.stamps, self.poses(), self.base_from_laser))
        if self._follower is None:
            return run.map
        mine = {r: id_ for id_, r in sorted(_counterparts(self._follower, run).items(), reverse=True)}
        number = self._follower.places.next_region
        for r in run.map.regions:
            if r not in mine:
                mine[r], number = f"r{number}", number + 1
        return _renamed(run.map, mine)

    def finish(self, log: ScanLog | None = None, cache: Cache | None = None, watch: Watcher = silent) -> pipeline.Run:
        """The final optimisation, and everything that the batch makes of it; no more scans after it.

        ``log``: the log that was fed, so that the map names it (source, format); otherwise one is made of the scans.
        Raises what :func:`rgcore.pipeline.run` raises.
        """
        log = log or self.log()
        poses = se2.compose(self._lrgc.finish(), self._laser_from_base)
        breaks = np.array(self._lrgc.breaks, np.int64)
        run = pipeline.run(log, self.config, cache, watch, Trajectory(log.stamps, poses, self.base_from_laser, breaks))
        if self._follower is not None:
            self._follower.bend(poses, 0.0)
            self._follower.settle()
            self.final = _counterparts(self._follower, run)
        return run

    def log(self) -> ScanLog:
        """The scans so far."""
        width = len(self.bearings)
        return ScanLog(
            np.array(self._stamps),
            np.array(self._ranges).reshape(-1, width),
            np.array(self._odometry).reshape(-1, 3),
            self.bearings,
            self.base_from_laser,
            self.max_range,
            self.has_odometry,
        )


def _points(posts: np.ndarray) -> tuple[tuple[float, float], tuple[float, float]]:
    (a, b), (c, d) = posts.tolist()
    return (a, b), (c, d)


def _counterparts(follower: Follower, run: pipeline.Run) -> dict[str, str]:
    """The region of a run's map that most of what was seen to be free in each region so far lies in."""
    points, number = follower.witnesses(run.trajectory.map_from_base)
    at = run.places.labels.at(points, outside=-1)
    out: dict[str, str] = {}
    for n in range(1, follower.places.next_region):
        there = at[(number == follower.places.now(n)) & (at >= 0)]
        if len(there):
            out[f"r{n}"] = f"r{int(np.bincount(there).argmax()) + 1}"
    return out


def _renamed(map_: RGMap, names: dict[str, str]) -> RGMap:
    """The map with other ids of regions."""
    return replace(
        map_,
        regions={names[k]: replace(r, id=names[k]) for k, r in map_.regions.items()},
        lines={k: replace(v, regions=tuple(names[r] for r in v.regions)) for k, v in map_.lines.items()},
        gateways={k: replace(v, regions=tuple(names[r] for r in v.regions)) for k, v in map_.gateways.items()},
        objects={k: replace(v, region=names.get(v.region or "")) for k, v in map_.objects.items()},
    )
