"""Random office floors with their true gateways, to train the gateway network on: never a building of a test.

A hallway with a branch, rooms along both, closets, lobbies, doors of many widths at any place of a wall (beside corners
too), and what makes doors hard to tell: cabinets at walls, desks, screens, table legs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rgcore.config import Places as Settings
from rgcore.geometry.grid import fill_polygons, reach
from rgcore.places.freespace import FreeSpace, free_space
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

Rect = tuple[float, float, float, float]
"""x0, y0, x1, y1 [m]"""

RASTER = 0.025
"""m: cell of the raster that floors are scanned in."""


@dataclass
class Floor:
    """Free rectangles, blocked quadrilaterals (4, 2) and gateways (post, post, kind), in metres; ``turn`` in rad."""

    thickness: float
    turn: float
    rooms: list[Rect] = field(default_factory=list)
    doors: list[Rect] = field(default_factory=list)
    blocked: list[np.ndarray] = field(default_factory=list)
    gateways: list[tuple[np.ndarray, np.ndarray, str]] = field(default_factory=list)

    def door(self, a: tuple[float, float], b: tuple[float, float], kind: str = "door") -> None:
        """A gap in a wall that runs along x or y; a and b are its posts in the middle of the wall."""
        h = self.thickness / 2 + RASTER
        (ax, ay), (bx, by) = a, b
        self.doors.append((ax, ay - h, bx, by + h) if ay == by else (ax - h, ay, bx + h, by))
        self.gateways.append((np.array(a, float), np.array(b, float), kind))

    def transition(self, a: tuple[float, float], b: tuple[float, float], kind: str) -> None:
        """A gateway where nothing is to be cut through."""
        self.gateways.append((np.array(a, float), np.array(b, float), kind))


def random_floor(rng: np.random.Generator) -> Floor:
    """One floor; all its doors are as wide as one of a few sizes."""
    t = float(rng.choice([0.06, 0.1, 0.15, 0.25, 0.35]))
    f = Floor(t, float(rng.uniform(0, np.pi / 2)) if rng.random() < 0.7 else 0.0)
    wide = float(rng.uniform(1.2, 3.0))
    length = float(rng.uniform(12, 30))
    f.rooms.append((0.0, 0.0, length, wide))
    branch = _branch(f, rng, length, wide)
    alike = not any(b[4] < 0 for b in branch) and rng.random() < 0.4
    since = len(f.rooms), len(f.doors), len(f.gateways)
    for side in (1,) if alike else (1, -1):
        edge = wide + t if side > 0 else -t
        taken = [(b[0] - t, b[2] + t) for b in branch if b[4] == side]
        start = 0.0
        for x0, x1 in [*sorted(taken), (length, length)]:
            _row(f, rng, start, x0, edge, side)
            start = x1
    if alike:
        _mirror(f, rng, wide, since)
    for at, sign in ((0.0, -1), (length, 1)):
        _end(f, rng, at, sign, wide)
    for room in list(f.rooms):
        _furnish(f, rng, room)
    return f


def _branch(
    f: Floor, rng: np.random.Generator, length: float, wide: float
) -> list[tuple[float, float, float, float, int]]:
    """Up to one more hallway that leaves the first: a T, an L or an X."""
    if rng.random() < 0.3:
        return []
    w = wide * float(rng.uniform(0.7, 1.3))
    x = float(rng.choice([0.0, rng.uniform(3, length - w - 3)], p=[0.25, 0.75]))
    out = []
    for side in (1, -1) if rng.random() < 0.3 else (1,):
        reach_ = float(rng.uniform(5, 14))
        y0, y1 = (wide, wide + reach_) if side > 0 else (-reach_, 0.0)
        f.rooms.append((x, y0 - 0.05, x + w, y1 + 0.05))
        edge = wide if side > 0 else 0.0
        f.transition((x, edge), (x + w, edge), "junction")
        out.append((x, y0, x + w, y1, side))
    for at in (x, x + w):
        if 1.5 < at < length - 1.5:
            f.transition((at, 0.0), (at, wide), "junction")
    return out


def _door_width(rng: np.random.Generator, room: float) -> float:
    usual = rng.uniform(0.65, 1.15) if rng.random() < 0.7 else rng.uniform(1.15, 2.4)
    return float(min(usual, 0.8 * room))


def _row(f: Floor, rng: np.random.Generator, x0: float, x1: float, edge: float, side: int) -> None:
    """Rooms side by side along the hallway, from x0 to x1, and the doors to it or to a neighbour."""
    t, depth, x = f.thickness, float(rng.uniform(2.5, 7)), x0
    before = False
    while x1 - x > 1.6:
        w = float(min(rng.uniform(0.95, 2) if rng.random() < 0.2 else rng.uniform(1.6, 7), x1 - x))
        if x1 - x - w < 1.6 + t:
            w = x1 - x
        d = depth if rng.random() < 0.7 else float(rng.uniform(1.2, 7))
        y0, y1 = sorted((edge, edge + side * d))
        f.rooms.append((x, y0, x + w, y1))
        wall = edge - side * t / 2
        for _ in range(2 if w > 4 and rng.random() < 0.25 else 1):
            if w > 4.5 and d > 3.5 and rng.random() < 0.15:
                gap = float(rng.uniform(2.4, min(4.9, 0.8 * w)))
                at = x + float(rng.uniform(0.2, w - gap - 0.2))
                f.door((at, wall), (at + gap, wall))
            elif rng.random() < 0.88:
                gap = _door_width(rng, w)
                corner = float(rng.uniform(0, 0.3))
                at = x + float(rng.choice([rng.uniform(0, w - gap), corner, w - gap - corner], p=[0.5, 0.25, 0.25]))
                at = min(max(at, x), x + w - gap)
                f.door((at, wall), (at + gap, wall))
        if before and rng.random() < 0.25:
            gap = _door_width(rng, min(2.0, d))
            at = float(rng.uniform(0, min(2.0, d) - gap))
            y = edge + side * at if side > 0 else edge - at - gap
            f.door((x - t / 2, y), (x - t / 2, y + gap))
        if d > 3 and w > 1.2 and rng.random() < 0.2:
            _closet(f, rng, (x, y0, x + w, y1), side)
        before = True
        x += w + t
    _thin_out(f)


def _closet(f: Floor, rng: np.random.Generator, room: Rect, side: int) -> None:
    """The far end of the last room becomes a room of its own, with a door between them."""
    t = f.thickness
    x0, y0, x1, y1 = f.rooms.pop()
    deep = float(rng.uniform(0.9, 0.5 * (y1 - y0)))
    wall = y1 - deep if side > 0 else y0 + deep
    f.rooms.append((x0, y0, x1, wall - t / 2) if side > 0 else (x0, wall + t / 2, x1, y1))
    f.rooms.append((x0, wall + t / 2, x1, y1) if side > 0 else (x0, y0, x1, wall - t / 2))
    gap = _door_width(rng, x1 - x0)
    at = float(rng.uniform(x0, x1 - gap))
    f.door((at, wall), (at + gap, wall))


def _mirror(f: Floor, rng: np.random.Generator, wide: float, since: tuple[int, int, int]) -> None:
    """The rooms and doors of one side of the hallway on its other side too, as buildings often have it."""
    rooms, doors, gateways = since
    shift = float(rng.choice([0.0, rng.normal(0, 0.3)]))
    f.rooms += [(x0, wide - y1, x1, wide - y0) for x0, y0, x1, y1 in f.rooms[rooms:]]
    f.doors += [(x0 + shift, wide - y1, x1 + shift, wide - y0) for x0, y0, x1, y1 in f.doors[doors:]]
    move, flip = np.array([shift, wide]), np.array([1, -1])
    f.gateways += [(move + flip * a, move + flip * b, kind) for a, b, kind in f.gateways[gateways:]]


def _thin_out(f: Floor) -> None:
    """Drop doors that overlap another one: what is left of the wall between them would be no wall."""
    kept: list[int] = []
    for i, (a, b, _) in enumerate(f.gateways):
        clash = any(
            np.hypot(*((a + b) / 2 - (p + q) / 2)) < 0.25 + 0.5 * (np.hypot(*(b - a)) + np.hypot(*(q - p)))
            and abs((b - a) @ (q - p)) > 0
            for p, q, _ in (f.gateways[j] for j in kept)
        )
        if not clash:
            kept.append(i)
    doors = [i for i, g in enumerate(f.gateways) if g[2] in ("door", "opening")]
    f.doors = [d for i, d in zip(doors, f.doors, strict=True) if i in kept]
    f.gateways = [f.gateways[i] for i in kept]


def _end(f: Floor, rng: np.random.Generator, at: float, sign: int, wide: float) -> None:
    """What the hallway ends in: a wall, a door, or a lobby as wide as it likes."""
    what = rng.choice(["wall", "door", "lobby", "lobby"])
    if what == "wall":
        return
    t = f.thickness
    y0, y1 = -float(rng.uniform(0.2, 4)), wide + float(rng.uniform(0.2, 4))
    deep = float(rng.uniform(3, 9))
    near, far = at + sign * t, at + sign * (t + deep)
    wall = at + sign * t / 2
    f.rooms.append((min(near, far), y0, max(near, far), y1))
    if what == "lobby" and y1 - y0 > 1.7 * wide and deep > 1.7 * wide:
        f.door((wall, 0.0), (wall, wide), "opening")
        return
    gap = min(_door_width(rng, wide), wide - 0.3)
    low = float(rng.uniform(0.1, wide - gap - 0.1))
    f.door((wall, low), (wall, low + gap))


def _furnish(f: Floor, rng: np.random.Generator, room: Rect) -> None:
    """Cabinets at walls, desks, screens and table legs, none in the way of a door."""
    x0, y0, x1, y1 = room
    w, h = x1 - x0, y1 - y0
    hall = max(w, h) > 2.5 * min(w, h) and min(w, h) < 3.2
    if rng.random() < (0.75 if hall else 0.25):
        return
    area = w * h
    for _ in range(rng.poisson(min(0.12 * area, 6))):
        long, deep = rng.uniform(0.4, 2.0), rng.uniform(0.3, 0.7)
        wall = rng.integers(4)
        along = w if wall < 2 else h
        at = rng.choice([rng.uniform(0, max(along - long, 0.01)), 0.0, max(along - long, 0.0)], p=[0.7, 0.15, 0.15])
        x, y = [(at, 0), (at, h - deep), (0, at), (w - deep, at)][wall]
        size = (long, deep) if wall < 2 else (deep, long)
        _block(f, x0 + x, y0 + y, *size, 0.0)
    if hall:
        return
    messy = rng.random() < 0.3
    for _ in range(rng.poisson((0.15 if messy else 0.05) * area)):
        turn = rng.uniform(0, np.pi) if messy else rng.normal(0, 0.1)
        long, deep = rng.uniform(0.4, 2.4), rng.uniform(0.4, 0.9)
        _block(f, rng.uniform(x0, x1), rng.uniform(y0, y1), long, deep, turn)
    for _ in range(rng.poisson(0.02 * area)):
        _block(f, rng.uniform(x0, x1), rng.uniform(y0, y1), 0.06, rng.uniform(0.8, 2.5), rng.choice([0, np.pi / 2]))
    for _ in range(rng.poisson(0.08 * area)):
        cx, cy, lx, ly = rng.uniform(x0, x1), rng.uniform(y0, y1), rng.uniform(0.4, 1.6), rng.uniform(0.4, 0.9)
        for x, y in ((cx, cy), (cx + lx, cy), (cx, cy + ly), (cx + lx, cy + ly)):
            _block(f, x, y, 0.06, 0.06, 0.0)


def _block(f: Floor, x: float, y: float, w: float, h: float, turn: float) -> None:
    corners = np.array([[0, 0], [w, 0], [w, h], [0, h]])
    c, s = np.cos(turn), np.sin(turn)
    corners = np.array([x, y]) + corners @ np.array([[c, s], [-s, c]])
    centre, radius = corners.mean(0), np.hypot(w, h) / 2
    for a, b, _ in f.gateways:
        if np.hypot(*((a + b) / 2 - centre)) < radius + 0.35 + 0.4 * np.hypot(*(b - a)):
            return
    f.blocked.append(corners)


def scanned(floor: Floor, rng: np.random.Generator, settings: Settings) -> FreeSpace:
    """The free space that scans from random positions see; turns the gateways of the floor into the map frame."""
    truth, place = _raster(floor)
    floor.gateways[:] = [(place(a), place(b), kind) for a, b, kind in floor.gateways]
    spots = []
    for x0, y0, x1, y1 in floor.rooms:
        if rng.random() < 0.06:
            continue
        n = 2 + rng.poisson((x1 - x0) * (y1 - y0) / 4)
        spots += [place(np.array([rng.uniform(x0, x1), rng.uniform(y0, y1)])) for _ in range(n)]
    spots += [(a + b) / 2 for a, b, kind in floor.gateways if kind == "door" and rng.random() < 0.8]
    position = np.array(spots)
    cells = np.floor(position / RASTER).astype(int)
    position = position[truth[cells[:, 1], cells[:, 0]]]
    bearings = np.radians(np.arange(-180, 180, 1.0))
    heading = rng.uniform(-np.pi, np.pi, len(position))
    angle = heading[:, None] + bearings
    direction = np.stack([np.cos(angle), np.sin(angle)], -1).reshape(-1, 2)
    far = 20.0 / RASTER
    r = reach(truth, np.repeat(position / RASTER, len(bearings), axis=0), direction, far) * RASTER
    r = np.where(r >= 20.0, np.inf, r + rng.normal(0, 0.012, len(r))).reshape(angle.shape)
    poses = np.c_[position + rng.normal(0, rng.uniform(0, 0.02), position.shape), heading]
    zero = np.zeros(3)
    log = ScanLog(np.arange(len(r)), r, poses, bearings, zero, 30.0)
    return free_space(log, Trajectory(log.stamps, poses, zero), settings)


def _raster(floor: Floor) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """The floor drawn as a mask of free cells, turned by its angle, and the function from plan to map [m]."""
    c, s = np.cos(floor.turn), np.sin(floor.turn)
    turn = np.array([[c, s], [-s, c]])
    rects = [np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) for x0, y0, x1, y1 in [*floor.rooms, *floor.doors]]
    low = np.concatenate([r @ turn for r in rects]).min(0) - 1.0
    size = np.ceil((np.concatenate([r @ turn for r in rects]).max(0) + 1.0 - low) / RASTER).astype(int)

    def place(points: np.ndarray) -> np.ndarray:
        return points @ turn - low

    mask = np.zeros((size[1], size[0]), bool)
    for value, shapes in ((True, rects), (False, floor.blocked)):
        mask = fill_polygons(mask, [place(r) / RASTER for r in shapes], value)
    return mask, place
