"""Random furnished floors with the things that stand in them, to train the object network on: never a test's building.

The floors are those of :mod:`rgcore.places.floors` without their furniture. Cabinets, shelves and sofas stand at walls
and in corners, side by side as well; desks, boxes and pillars anywhere; tables are four legs. What looks like a
thing and is none stands there too: jogs and pilasters, ends of walls, screens, niches, radiators, chairs, clutter.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rgcore.config import Config
from rgcore.geometry import polygons
from rgcore.geometry.grid import clearance
from rgcore.geometry.raycast import cast
from rgcore.lines.merge import Lines, merge_lines
from rgcore.places.floor_scans import raster
from rgcore.places.floors import RASTER, Floor, Rect, leaves, random_floor
from rgcore.places.freespace import FreeSpace, free_space
from rgcore.places.places import Places
from rgcore.places.regions import find_places, region_of_segments
from rgcore.scans.extract import extract
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

KINDS = ("cabinet", "box", "table", "pillar")
"""Cabinets stand at a wall, boxes free; tables are legs; pillars are square or round and as deep as wide."""


@dataclass(frozen=True)
class Thing:
    """What stands there: ``corners`` (4, 2) of its box [m], counter-clockwise."""

    kind: str
    corners: np.ndarray


@dataclass
class Furnished:
    """A floor and what stands in it, in the map frame once it is surveyed."""

    floor: Floor
    things: list[Thing] = field(default_factory=list)
    taken: list[np.ndarray] = field(default_factory=list)

    def add(self, kind: str, box: np.ndarray, draw: bool = True) -> bool:
        """Put a thing there, its box drawn or not, if nothing stands there and no door is in the way."""
        if not self.block(box, draw):
            return False
        self.things.append(Thing(kind, box))
        return True

    def block(self, box: np.ndarray, draw: bool = True) -> bool:
        """The same for what is no thing."""
        if not self.fits(box):
            return False
        self.taken.append(box)
        if draw:
            self.floor.blocked.append(box)
        return True

    def fits(self, box: np.ndarray) -> bool:
        """Whether nothing is there and no door is near."""
        middle, radius = box.mean(0), np.hypot(*(box[2] - box[0])) / 2
        for a, b, _ in self.floor.gateways:
            if np.hypot(*((a + b) / 2 - middle)) < radius + 0.2 + 0.4 * np.hypot(*(b - a)):
                return False
        return not any(_meet(box, other) for other in self.taken)


@dataclass(frozen=True)
class Survey:
    """What the stages before the objects make of a floor."""

    lines: Lines
    places: Places
    free: FreeSpace


def furnished_floor(rng: np.random.Generator) -> Furnished:
    """One floor; some are bare, some crowded."""
    f = Furnished(random_floor(rng))
    f.floor.blocked.clear()
    if rng.random() < 0.5:
        leaves(f.floor, rng)
    crowd = float(rng.choice([0.3, 1.0, 2.0]))
    for room in list(f.floor.rooms):
        _building(f, rng, room)
        w, h = room[2] - room[0], room[3] - room[1]
        hall = max(w, h) > 2.5 * min(w, h) and min(w, h) < 3.2
        if not hall or rng.random() < 0.25:
            _furnish(f, rng, room, crowd * (0.3 if hall else 1.0))
    return f


def _furnish(f: Furnished, rng: np.random.Generator, room: Rect, crowd: float) -> None:
    x0, y0, x1, y1 = room
    w, h = x1 - x0, y1 - y0
    area = min(w * h, 60.0)

    def anywhere(long: float, deep: float, turn: float) -> np.ndarray:
        return _box(rng.uniform(x0 + 0.3, x1 - 0.3), rng.uniform(y0 + 0.3, y1 - 0.3), long, deep, turn)

    for _ in range(rng.poisson(crowd * min(0.2 * (w + h), 6))):
        row = 1 if rng.random() < 0.8 else 2
        at, wall = None, int(rng.integers(4))
        for _ in range(row):
            long, deep = (1.4, 0.7) if rng.random() < 0.15 else (0.4, 0.25)
            long, deep = rng.uniform(long, 2.1), rng.uniform(deep, 0.95 if deep > 0.5 else 0.7)
            at = _at_wall(f, rng, room, wall, (long, deep), at)
    for _ in range(rng.poisson(crowd * 0.03 * area)):
        f.add("box", anywhere(rng.uniform(0.4, 2.2), rng.uniform(0.35, 1.0), _turn(rng)))
    for _ in range(rng.poisson(crowd * 0.04 * area)):
        _table(f, rng, anywhere(rng.uniform(0.6, 2.0), rng.uniform(0.5, 1.0), _turn(rng)), rng.uniform(0.04, 0.09))
    for _ in range(rng.poisson(crowd * 0.05 * area)):
        _legs(f, anywhere(rng.uniform(0.33, 0.46), rng.uniform(0.33, 0.46), rng.uniform(0, np.pi)), 0.035)
    for _ in range(rng.poisson(crowd * 0.04 * area)):
        size = rng.uniform(0.06, 0.3)
        f.block(anywhere(size, size * rng.uniform(0.5, 1), rng.uniform(0, np.pi)))
    if rng.random() < 0.15 * crowd:
        f.block(anywhere(rng.uniform(0.6, 2.5), rng.uniform(0.04, 0.1), _turn(rng)))
    if rng.random() < 0.12 and area > 20:
        size = float(rng.uniform(0.3, 0.8))
        square = anywhere(size, size, 0.0)
        if f.add("pillar", square, draw=False):
            f.floor.blocked.append(square if rng.random() < 0.5 else _round(square.mean(0), size / 2))


def _building(f: Furnished, rng: np.random.Generator, room: Rect) -> None:
    """Jogs, pilasters, radiators, ends of walls: parts of the building that look like things."""
    x0, y0, x1, y1 = room
    w, h = x1 - x0, y1 - y0
    for _ in range(rng.poisson(0.4)):
        long, deep = rng.uniform(0.15, 0.8), rng.uniform(0.06, 0.19)
        _at_wall(f, rng, room, int(rng.integers(4)), (long, deep), None, thing=False)
    if rng.random() < 0.2:  # a radiator or a window sill
        _at_wall(
            f, rng, room, int(rng.integers(4)), (rng.uniform(0.6, 2.5), rng.uniform(0.08, 0.18)), None, thing=False
        )
    if rng.random() < 0.15 and min(w, h) > 2.5:  # the room is no rectangle
        long, deep = rng.uniform(1.3, 0.5 * max(w, 2.7)), rng.uniform(1.25, 0.5 * max(h, 2.6))
        f.block(_corner(room, int(rng.integers(4)), long, deep))
    if rng.random() < 0.1:  # a shaft
        f.block(_corner(room, int(rng.integers(4)), rng.uniform(0.25, 1.0), rng.uniform(0.25, 1.0)))
    if rng.random() < 0.12 and min(w, h) > 2.2:  # a wall that ends in the room
        wall, long, t = int(rng.integers(4)), rng.uniform(0.5, 2.0), rng.uniform(0.06, 0.25)
        _at_wall(f, rng, room, wall, (t, long), None, thing=False)
    if rng.random() < 0.12 and w > 1.5:  # a niche in the wall away from the hallway
        x, wide, deep = rng.uniform(x0 + 0.2, x1 - 0.7), rng.uniform(0.4, 1.5), rng.uniform(0.15, 0.6)
        y = y1 if y0 > 0 else y0
        f.floor.spaces.append(_rect(x, y - deep, min(x + wide, x1 - 0.1), y + deep))


def _at_wall(
    f: Furnished,
    rng: np.random.Generator,
    room: Rect,
    wall: int,
    size: tuple[float, float],
    after: float | None,
    thing: bool = True,
) -> float | None:
    """A box along a wall (0 low y, 1 high y, 2 low x, 3 high x), behind ``after``; where it ends if it fits."""
    x0, y0, x1, y1 = room
    along = x1 - x0 if wall < 2 else y1 - y0
    long, deep = size
    if long > along:
        return None
    if after is None:
        ends = (rng.uniform(0, along - long), 0.0, along - long)
        at = float(rng.choice(ends, p=[0.7, 0.15, 0.15] if thing else [0.8, 0.1, 0.1]))
    else:
        at = after + float(rng.choice([0.0, rng.uniform(0.02, 0.4)]))
    off = 0.0 if rng.random() < 0.8 or not thing else float(rng.uniform(0.01, 0.08))
    if at + long > along:
        return None
    low, high = {0: (y0 + off, y0 + off + deep), 1: (y1 - off - deep, y1 - off)}.get(wall, (0.0, 0.0))
    if wall < 2:
        box = _rect(x0 + at, low, x0 + at + long, high)
    else:
        low, high = (x0 + off, x0 + off + deep) if wall == 2 else (x1 - off - deep, x1 - off)
        box = _rect(low, y0 + at, high, y0 + at + long)
    placed = f.add("cabinet", box) if thing else f.block(box)
    return at + long if placed else None


def _table(f: Furnished, rng: np.random.Generator, box: np.ndarray, leg: float) -> None:
    if f.add("table", box, draw=False):
        _posts(f, box, leg, rng.uniform(0, 0.06))


def _legs(f: Furnished, box: np.ndarray, leg: float) -> None:
    """Four legs of a chair, which is no thing of its own."""
    if f.fits(box):
        _posts(f, box, leg, 0.0)


def _posts(f: Furnished, box: np.ndarray, leg: float, inset: float) -> None:
    middle = box.mean(0)
    for corner in box:
        inward = (middle - corner) / np.hypot(*(middle - corner))
        x, y = corner + inward * (inset + leg / 2)
        f.floor.blocked.append(_box(x, y, leg, leg, _yaw(box)))


def _turn(rng: np.random.Generator) -> float:
    """Most things stand along the walls."""
    return float(rng.choice([0.0, np.pi / 2, rng.uniform(0, np.pi)], p=[0.3, 0.3, 0.4]))


def _yaw(box: np.ndarray) -> float:
    return float(np.arctan2(*(box[1] - box[0])[::-1]))


def _rect(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])


def _corner(room: Rect, k: int, w: float, h: float) -> np.ndarray:
    """A box of a size in a corner of the room."""
    x = room[0] if k % 2 == 0 else room[2] - w
    y = room[1] if k < 2 else room[3] - h
    return _rect(x, y, x + w, y + h)


def _box(x: float, y: float, w: float, h: float, turn: float) -> np.ndarray:
    c, s = np.cos(turn), np.sin(turn)
    return np.array([x, y]) + _rect(-w / 2, -h / 2, w / 2, h / 2) @ np.array([[c, s], [-s, c]])


def _round(middle: np.ndarray, radius: float) -> np.ndarray:
    a = np.arange(16) * np.pi / 8
    return middle + radius * np.stack([np.cos(a), np.sin(a)], 1)


def _meet(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two convex quadrilaterals overlap (separating axes); those that only touch do not."""
    for box in (a, b):
        d = np.roll(box, -1, axis=0) - box
        n = np.stack([-d[:, 1], d[:, 0]], 1) / np.hypot(*d.T)[:, None]
        p, q = a @ n.T, b @ n.T
        if np.any((p.max(0) < q.min(0) + 1e-6) | (q.max(0) < p.min(0) + 1e-6)):
            return False
    return True


def survey(f: Furnished, rng: np.random.Generator, config: Config) -> Survey:
    """Drive through all rooms; what the stages before the objects make of it, some lines missing as those of black and
    glass fronts do. Turns the things into the map frame.
    """
    truth, place = raster(f.floor)
    f.things[:] = [Thing(t.kind, place(t.corners)) for t in f.things]
    floor = f.floor
    rects = [*(_rect(*r) for r in [*floor.rooms, *floor.doors]), *floor.spaces]
    walls = polygons.walls_of([place(r) for r in rects], [place(b) for b in floor.blocked])
    poses = _way(f, clearance(truth)[0] * RASTER, place, rng)
    narrow = rng.random() < 0.7
    bearings = np.radians(np.arange(-90, 91, 1.0) if narrow else np.arange(-180, 180, 1.0))
    ranges = cast(walls, poses, bearings, 30.0)[0]
    ranges = ranges + rng.normal(0, 0.012, ranges.shape)
    wave = np.sin(np.arange(len(poses))[:, None] / rng.uniform(5, 30, 3) + rng.uniform(0, 6, 3))
    off = rng.uniform(0, 0.03) * wave + rng.normal(0, rng.uniform(0, 0.01), poses.shape)
    zero, stamps = np.zeros(3), np.arange(len(poses), dtype=float)
    seen = poses + off * [1, 1, 0.3]
    log, trajectory = ScanLog(stamps, ranges, seen, bearings, zero, 30.0), Trajectory(stamps, seen, zero)
    segments = extract(log, config.extract)
    free = free_space(log, trajectory, config.places)
    places = find_places(free, log, trajectory, segments, config.places)
    lines, _ = merge_lines(segments, trajectory, region_of_segments(segments, trajectory, places), config.lines)
    missed = rng.random(len(lines)) < rng.choice([0.0, 0.1, 0.2])
    return Survey(lines[~missed], places, free)


def _way(
    f: Furnished, room: np.ndarray, place: Callable[[np.ndarray], np.ndarray], rng: np.random.Generator
) -> np.ndarray:
    """(N, 3) poses on straight ways between random spots of each room, none nearer to a wall than a robot is wide."""
    parts = []
    for x0, y0, x1, y1 in f.floor.rooms:
        if rng.random() < 0.07:
            continue
        n = int(rng.integers(3, 5 + min(int((x1 - x0) * (y1 - y0) / 8), 8)))
        spots = np.stack([rng.uniform(x0, x1, n), rng.uniform(y0, y1, n)], 1)
        doors = [(a + b) / 2 for a, b, _ in f.floor.gateways if x0 - 1 < (a + b)[0] / 2 < x1 + 1]
        near = [d for d in doors if y0 - 0.6 < d[1] < y1 + 0.6 and x0 - 0.6 < d[0] < x1 + 0.6]
        stops = place(np.concatenate([np.array(near).reshape(-1, 2), spots]))
        for a, b in itertools.pairwise(stops):
            way = a + np.arange(0, 1, 0.15 / max(np.hypot(*(b - a)), 0.15))[:, None] * (b - a)
            heading = np.arctan2(*(b - a)[::-1]) + rng.normal(0, 0.15, len(way))
            parts += [np.c_[way, heading], np.c_[np.repeat(a[None], 3, 0), heading[0] + rng.uniform(-2, 2, 3)]]
    poses = np.concatenate(parts)
    cells = np.clip(np.floor(poses[:, :2] / RASTER).astype(int), 0, np.array(room.shape[::-1]) - 1)
    return poses[room[cells[:, 1], cells[:, 0]] > 0.22]
