"""A small building that is known: a hallway, a room that is entered, one that is only looked into, and a cabinet."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from rgcore.config import Config
from rgcore.geometry import se2
from rgcore.geometry.raycast import cast
from rgcore.lines.merge import Lines, merge_lines
from rgcore.places.freespace import FreeSpace, free_space
from rgcore.places.gateways import snap_posts
from rgcore.places.places import Places
from rgcore.places.regions import find_places, region_of_segments
from rgcore.scans.extract import Segments, extract
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

BEARINGS = np.deg2rad(np.arange(-180.0, 180.0))
WALL = 0.12
HALL = (0.0, 0.0, 14.0, 2.0)
LEFT = (0.0, 2.0 + WALL, 5.0, 7.0)
RIGHT = (5.0 + WALL, 2.0 + WALL, 10.0, 7.0)
DOORS = ((3.5, 4.4), (7.0, 7.9))
"""x of the posts of the doors from the hallway into the left and into the right room"""
CABINET = (4.5, 4.0, 5.0, 5.2)
"""stands at the right wall of the left room"""
BEFORE = (0.0, 4.2, 0.5, 5.4)
"""stands opposite, so that there is a gap between two cabinets"""


def chain(*points: tuple[float, float]) -> list[list[tuple[float, float]]]:
    return [[a, b] for a, b in itertools.pairwise(points)]


def room(box: tuple[float, float, float, float], door: tuple[float, float]) -> list[list[tuple[float, float]]]:
    """The walls of a room with a door in its lower wall, jambs and all."""
    x0, y0, x1, y1 = box
    a, b = door
    return chain((a, y0 - WALL), (a, y0), (x0, y0), (x0, y1), (x1, y1), (x1, y0), (b, y0), (b, y0 - WALL))


def block(x0: float, y0: float, x1: float, y1: float) -> list[list[tuple[float, float]]]:
    return chain((x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0))


def world() -> np.ndarray:
    """(L, 2, 2) walls and furniture."""
    x0, y0, x1, y1 = HALL
    (a, b), (c, d) = DOORS
    hall = [*chain((a, y1), (x0, y1), (x0, y0), (x1, y0), (x1, y1), (d, y1)), [(b, y1), (c, y1)]]
    return np.array(hall + room(LEFT, DOORS[0]) + room(RIGHT, DOORS[1]) + block(*CABINET) + block(*BEFORE), float)


def way() -> np.ndarray:
    """(N, 3) poses: along the hallway, through the left door, around the left room, and back."""
    there = (1, 1), (13, 1), (3.95, 1), (3.95, 3), (1.5, 3.2), (2.5, 6), (3.8, 6.2)
    return along(*there, (2.5, 3), (3.95, 3), (3.95, 1))


def along(*stops: tuple[float, float]) -> np.ndarray:
    """(N, 3) poses every 30 cm from stop to stop, turning all the time."""
    legs = []
    for a, b in zip(np.array(stops, float), np.array(stops[1:], float), strict=False):
        n = int(np.hypot(*(b - a)) / 0.3) + 1
        legs.append(a + np.arange(n)[:, None] / n * (b - a))
    at = np.concatenate(legs)
    return np.c_[at, 0.7 * np.arange(len(at)) % 6]


@dataclass
class Building:
    """What the stages make of the building; ``map_from_plan`` is where it stands."""

    log: ScanLog
    trajectory: Trajectory
    segments: Segments
    free: FreeSpace
    found: Places
    lines: Lines
    places: Places
    map_from_plan: np.ndarray

    def at(self, x: float, y: float) -> int:
        """The region at a point of the plan."""
        return int(self.places.labels.at(se2.transform(self.map_from_plan, np.array([x, y])), outside=-1))


def survey(
    map_from_plan: tuple[float, float, float] = (0.0, 0.0, 0.0),
    config: Config | None = None,
    walls: np.ndarray | None = None,
    poses: np.ndarray | None = None,
) -> Building:
    """Drive through the building (or other walls, another way) with perfect poses and 12 mm of range noise."""
    c = config or Config()
    frame = np.array(map_from_plan, float)
    poses = way() if poses is None else poses
    ranges = cast(world() if walls is None else walls, poses, BEARINGS, 30.0)[0]
    ranges = ranges + np.random.default_rng(3).normal(0, 0.012, ranges.shape)
    stamps = np.arange(len(poses), dtype=float)
    log = ScanLog(stamps, ranges, poses, BEARINGS, np.zeros(3), 30.0)
    trajectory = Trajectory(stamps, se2.compose(frame, poses), np.zeros(3))
    segments = extract(log, c.extract)
    free = free_space(log, trajectory, c.places)
    found = find_places(free, log, trajectory, segments, c.places)
    lines, _ = merge_lines(segments, trajectory, region_of_segments(segments, trajectory, found), c.lines)
    places = snap_posts(found, lines, c.places)
    return Building(log, trajectory, segments, free, found, lines, places, frame)
