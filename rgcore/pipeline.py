"""The whole way on one page: from a log to the map, a line a stage (paper, section III)."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from rgcore.cache import Cache
from rgcore.config import Config, Slam
from rgcore.config import Lines as LineSettings
from rgcore.errors import InputError
from rgcore.lines.accuracy import Accuracy, measure_accuracy
from rgcore.lines.adapt import adapt
from rgcore.lines.adaptation import Adaptation
from rgcore.lines.complete import complete_lines
from rgcore.lines.merge import Lines, merge_lines
from rgcore.model.assemble import assemble
from rgcore.model.records import RGMap
from rgcore.places.classify import Classes, classify
from rgcore.places.freespace import FreeSpace, free_space
from rgcore.places.gateways import snap_posts
from rgcore.places.objects import FoundObject, find_objects
from rgcore.places.places import Places
from rgcore.places.regions import find_places, region_of_segments
from rgcore.progress import Progress, Watcher, silent
from rgcore.scans.extract import Segments, extract
from rgcore.scans.log import ScanLog
from rgcore.slam.lrgc import lrgc
from rgcore.slam.trajectory import Trajectory

T = TypeVar("T")

STAGES = ("extract", "slam", "freespace", "places", "adapt", "lines", "accuracy", "classes", "objects")
"""The stages in their order, as they are named in progress, cache and timings."""


@dataclass(frozen=True)
class Run:
    """Everything that a run made: the evidence of each stage and the map that they give."""

    log: ScanLog
    config: Config
    segments: Segments
    trajectory: Trajectory
    free: FreeSpace
    places: Places
    adaptation: Adaptation | None
    lines: Lines
    line_of: np.ndarray
    accuracy: Accuracy
    classes: Classes
    objects: tuple[FoundObject, ...]
    map: RGMap
    seconds: dict[str, float] = field(default_factory=dict)


def run(
    log: ScanLog,
    config: Config | None = None,
    cache: Cache | None = None,
    watch: Watcher = silent,
    known: Trajectory | None = None,
) -> Run:
    """Map a log. With a cache, a stage whose settings and inputs are unchanged is read instead of computed.

    ``known``: the final poses of this log under these settings, where they have been estimated scan by scan
    already (:class:`rgcore.online.Mapper`).

    Raises InputError for a log without a single usable echo, RgError for a map too large for its raster.
    """
    c = config or Config()
    if not log.usable(c.slam.max_range).any():
        nothing = f"none of its {len(log)} scans holds an echo nearer than slam.max_range={c.slam.max_range:g} m"
        raise InputError(log.source or "the log", f"{nothing}; check the unit of its readings (metres)")
    stages = _Stages(log, c, cache or Cache(None), watch)

    segments = stages("extract", lambda: extract(log, c.extract), c.extract)
    trajectory = stages("slam", lambda: trajectory_of(log, c.slam, watch) if known is None else known, c.slam)
    free = stages("freespace", lambda: free_space(log, trajectory, c.places), c.places, "slam")
    found = stages("places", lambda: find_places(free, log, trajectory, segments, c.places), "freespace", "extract")
    regions = region_of_segments(segments, trajectory, found)

    def region_at(points: np.ndarray) -> np.ndarray:
        return found.labels.at(points, outside=-1)

    fitted = stages(
        "adapt",
        lambda: adapt(log, segments, trajectory, regions, len(found.regions), region_at, c.lines, c.accuracy, c.adapt),
        *(c.lines, c.accuracy, c.adapt, "places"),
    )
    by_region = fitted.settings(c.lines) if fitted else ()
    lines, line_of = stages(
        "lines",
        lambda: _lines(log, segments, trajectory, regions, region_at, c.lines, by_region),
        *(c.lines, "adapt"),
    )
    places = snap_posts(found, lines, c.places)
    accuracy = stages(
        "accuracy", lambda: measure_accuracy(log, trajectory, lines.ends, c.accuracy), c.accuracy, "lines"
    )
    classes = stages("classes", lambda: classify(lines, places, free, c.classes), c.classes, "lines")
    objects = stages("objects", lambda: find_objects(lines, places, free, c.objects), c.objects, "lines")

    scan_regions = places.labels.at(trajectory.map_from_base[:, :2], outside=-1)
    map_ = assemble(log, c, segments, places, lines, line_of, accuracy, classes, objects, scan_regions)
    return Run(
        log,
        c,
        segments,
        trajectory,
        free,
        places,
        fitted,
        lines,
        line_of,
        accuracy,
        classes,
        objects,
        map_,
        stages.seconds,
    )


def trajectory_of(log: ScanLog, settings: Slam, watch: Watcher = silent) -> Trajectory:
    """The poses of a log: estimated, or those that it has been surveyed with."""
    if log.surveyed:
        return Trajectory(log.stamps, log.odom_from_base, log.base_from_laser)
    return lrgc(log, settings, watch)


def _lines(
    log: ScanLog,
    segments: Segments,
    trajectory: Trajectory,
    regions: np.ndarray,
    region_at: Callable[[np.ndarray], np.ndarray],
    settings: LineSettings,
    by_region: tuple[LineSettings, ...],
) -> tuple[Lines, np.ndarray]:
    """The lines of the map, and the line of each segment."""
    lines, line_of = merge_lines(segments, trajectory, regions, settings, by_region)
    return complete_lines(lines, line_of, log, segments, trajectory, region_at, settings, by_region)


class _Stages:
    """Runs one stage after the other: cached, timed and told to the watcher."""

    def __init__(self, log: ScanLog, config: Config, cache: Cache, watch: Watcher) -> None:
        self.log, self.config, self.cache, self.watch = log, config, cache, watch
        self.keys: dict[str, str] = {}
        self.seconds: dict[str, float] = {}

    def __call__(self, stage: str, compute: Callable[[], T], *depends: object) -> T:
        """``depends``: the settings of the stage, and the names of the stages that it takes (the log always counts)."""
        self.watch(Progress(stage, 0, 1))
        inputs = [self.keys[d] if isinstance(d, str) else d for d in depends]
        self.keys[stage] = self.cache.key(stage, self.log.sha256, *inputs)
        began = time.perf_counter()
        value = self.cache.get(stage, self.keys[stage], compute)
        self.seconds[stage] = time.perf_counter() - began
        self.watch(Progress(stage, 1, 1, value))
        return value
