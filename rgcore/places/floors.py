"""Random office floors with their true gateways, to train the gateway network on: never a building of a test.

A hallway with a branch, a bend or a lobby at its end, rooms along both, closets, doors of many widths at any place of a
wall (beside corners too), in niches, in pairs with a pillar between them, and what makes doors hard to tell: their
leaves, cabinets at walls, desks, screens, table legs, glass.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

Rect = tuple[float, float, float, float]
"""x0, y0, x1, y1 [m]"""

RASTER = 0.025
"""m: cell of the raster that floors are scanned in."""


@dataclass
class Floor:
    """Free rectangles, blocked quadrilaterals (4, 2) and gateways (post, post, kind), in metres; ``turn`` in rad.

    ``spaces``: free polygons (n, 2) that are no rectangles along the axes. ``glass``: discs (x, y, radius) within
    which many echoes are missing.
    """

    thickness: float
    turn: float
    rooms: list[Rect] = field(default_factory=list)
    doors: list[Rect] = field(default_factory=list)
    blocked: list[np.ndarray] = field(default_factory=list)
    gateways: list[tuple[np.ndarray, np.ndarray, str]] = field(default_factory=list)
    spans: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    spaces: list[np.ndarray] = field(default_factory=list)
    glass: list[tuple[float, float, float]] = field(default_factory=list)

    def door(self, a: tuple[float, float], b: tuple[float, float], kind: str = "door") -> None:
        """A gap in a wall that runs along x or y; a and b are its posts in the middle of the wall."""
        h = self.thickness / 2 + RASTER
        (ax, ay), (bx, by) = a, b
        self.doors.append((ax, ay - h, bx, by + h) if ay == by else (ax - h, ay, bx + h, by))
        self.gateways.append((np.array(a, float), np.array(b, float), kind))

    def transition(self, a: ArrayLike, b: ArrayLike, kind: str) -> None:
        """A gateway where nothing is to be cut through."""
        self.gateways.append((np.array(a, float), np.array(b, float), kind))


def random_floor(rng: np.random.Generator) -> Floor:
    """One floor; all its doors are as wide as one of a few sizes."""
    t = float(rng.choice([0.06, 0.1, 0.15, 0.25, 0.35, 0.5]))
    f = Floor(t, float(rng.uniform(0, np.pi / 2)) if rng.random() < 0.7 else 0.0)
    wide = float(rng.uniform(1.2, 3.0) if rng.random() < 0.85 else rng.uniform(3.0, 3.8))
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
    if rng.random() < 0.3:
        _niches(f, rng, wide)
    for at, sign in ((0.0, -1), (length, 1)):
        _end(f, rng, at, sign, wide)
    if rng.random() < 0.5:
        leaves(f, rng)
    for room in list(f.rooms):
        _furnish(f, rng, room)
    for x0, y0, x1, y1 in f.rooms if rng.random() < 0.3 else ():
        if rng.random() < 0.5:
            x, y = rng.uniform(x0, x1), rng.uniform(y0, y1)
            side = rng.choice(["x", "y"])
            f.glass.append((x, rng.choice([y0, y1]), 0.8) if side == "x" else (rng.choice([x0, x1]), y, 0.8))
    return f


def _niches(f: Floor, rng: np.random.Generator, wide: float) -> None:
    """Doors set back from the hallway: the wall is cut away before them, on the side of the hallway."""
    t = f.thickness
    deep, beside = float(rng.uniform(0.15, 0.8)), float(rng.uniform(0.05, 0.6))
    for a, b, kind in f.gateways:
        if kind == "door" and a[1] == b[1] and min(abs(a[1] + t / 2), abs(a[1] - wide - t / 2)) < 0.01:
            sign = 1 if a[1] > 0 else -1
            edge = wide if sign > 0 else 0.0
            span = a[0] - beside - t, b[0] + beside + t
            behind = [r for r in f.rooms if r[0] < span[1] and r[2] > span[0] and _adjoins(r, edge, sign, t)]
            if any(r[3] - r[1] < deep + t + 1.2 for r in behind) or any(
                p[0] == q[0] and span[0] - t < p[0] < span[1] + t and min(abs(p[1] - edge), abs(q[1] - edge)) < deep + t
                for p, q, _ in f.gateways
            ):
                continue
            low, high = sorted((edge, edge + sign * deep))
            moved = [(r, (r[0], r[1] + deep, *r[2:]) if sign > 0 else (*r[:3], r[3] - deep)) for r in behind]
            f.rooms = [dict(moved).get(r, r) for r in f.rooms]
            f.spaces.append(corners((a[0] - beside, low - 0.05, b[0] + beside, high + 0.0)))
            a[1] = b[1] = edge + sign * (deep + t / 2)
            low, high = sorted((edge, edge + sign * (deep + t + 2 * RASTER)))
            f.doors.append((a[0], low, b[0], high))


def _adjoins(room: Rect, edge: float, sign: int, t: float) -> bool:
    """Whether the wall of the hallway is that of the room as well."""
    return abs((room[1] if sign > 0 else room[3]) - edge - sign * t) < 0.02


def corners(r: Rect) -> np.ndarray:
    """(4, 2) corners of a rectangle, counter-clockwise."""
    x0, y0, x1, y1 = r
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])


def leaves(f: Floor, rng: np.random.Generator) -> None:
    """Leaves of open doors, hinged at a post, standing at any angle that leaves the way free."""
    for a, b, kind in f.gateways:
        gap = np.hypot(*(b - a))
        if kind != "door" or gap > 1.3 or rng.random() < 0.4:
            continue
        if rng.random() < 0.5:
            a, b = b, a
        u = (b - a) / gap
        n = np.array([-u[1], u[0]]) * rng.choice([-1, 1])
        turn = np.radians(rng.uniform(80, 165))
        d = np.cos(turn) * u + np.sin(turn) * n
        w = np.array([-d[1], d[0]]) * 0.025
        start = a + (f.thickness / 2) * n - 0.03 * u
        f.blocked.append(np.array([start - w, start + gap * d - w, start + gap * d + w, start + w]))


def _branch(
    f: Floor, rng: np.random.Generator, length: float, wide: float
) -> list[tuple[float, float, float, float, int]]:
    """Up to one more hallway that leaves the first: a T, an L or an X."""
    if rng.random() < 0.3:
        return []
    w = wide * float(rng.uniform(0.7, 1.3))
    x = float(rng.choice([0.0, rng.uniform(3, length - w - 3)], p=[0.25, 0.75]))
    out = []
    sides = (1, -1) if rng.random() < 0.3 else (1,)
    letter = f"junction_{('L' if x == 0 else 'T') if len(sides) == 1 else ('T' if x == 0 else 'X')}"
    for side in sides:
        reach_ = float(rng.uniform(5, 14))
        y0, y1 = (wide, wide + reach_) if side > 0 else (-reach_, 0.0)
        f.rooms.append((x, y0 - 0.05, x + w, y1 + 0.05))
        edge = wide if side > 0 else 0.0
        f.transition((x, edge), (x + w, edge), letter)
        out.append((x, y0, x + w, y1, side))
    for at in (x, x + w):
        if 1.5 < at < length - 1.5:
            f.transition((at, 0.0), (at, wide), letter)
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
            elif w > 2.6 and rng.random() < 0.12:
                _pair(f, rng, (x, x + w), wall)
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


def _pair(f: Floor, rng: np.random.Generator, span: tuple[float, float], wall: float) -> None:
    """Two or three wide doors side by side with a pillar between each two."""
    n = 2 if rng.random() < 0.8 or span[1] - span[0] < 4 else 3
    pillar = float(rng.uniform(0.12, 0.45))
    gap = float(min(rng.uniform(0.75, 1.9), (span[1] - span[0] - 0.2 - (n - 1) * pillar) / n))
    if gap < 0.65:
        return
    rest = span[1] - span[0] - 0.2 - n * gap - (n - 1) * pillar
    at = span[0] + 0.1 + float(rng.uniform(0, max(rest, 1e-6)))
    for i in range(n):
        x = at + i * (gap + pillar)
        f.door((x, wall), (x + gap, wall))
    f.spans.append((np.array([at, wall]), np.array([at + n * gap + (n - 1) * pillar, wall])))


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
    for i, (a, b, kind) in enumerate(f.gateways):
        clash = not kind.startswith("junction") and any(
            np.hypot(*((a + b) / 2 - (p + q) / 2)) < 0.25 + 0.5 * (np.hypot(*(b - a)) + np.hypot(*(q - p)))
            and abs((b - a) @ (q - p)) > 0
            and not any(min((b - r) @ (s - r), (a - r) @ (s - r)) >= 0 and abs(a[1] - r[1]) < 0.01 for r, s in f.spans)
            for p, q, other in (f.gateways[j] for j in kept)
            if not other.startswith("junction")
        )
        if not clash:
            kept.append(i)
    doors = [i for i, g in enumerate(f.gateways) if g[2] in ("door", "opening")]
    f.doors = [d for i, d in zip(doors, f.doors, strict=True) if i in kept]
    f.gateways = [f.gateways[i] for i in kept]


def _end(f: Floor, rng: np.random.Generator, at: float, sign: int, wide: float) -> None:
    """What the hallway ends in: a wall, a door, or a lobby as wide as it likes."""
    what = rng.choice(["wall", "door", "lobby", "bend", "hall"], p=[0.15, 0.2, 0.35, 0.15, 0.15])
    if what == "wall":
        return
    t = f.thickness
    if what == "bend":
        return _bend(f, rng, at, sign, wide)
    flush = rng.random(2) < 0.25
    y0, y1 = -float(rng.uniform(0.2, 4)) * (not flush[0]), wide + float(rng.uniform(0.2, 4)) * (not flush[1])
    deep = float(rng.uniform(3, 9))
    near, far = at + sign * t, at + sign * (t + deep)
    wall = at + sign * t / 2
    f.rooms.append((min(near, far), y0, max(near, far), y1))
    if what == "lobby" and y1 - y0 > 1.6 * wide and deep > 1.6 * wide:
        f.door((wall, 0.0), (wall, wide), "opening")
        return
    if what == "hall":  # goes on across, as a hallway: a T without a gateway of its own
        left = near - wide if sign < 0 else near
        f.rooms[-1] = (left, -float(rng.uniform(2, 8)), left + wide, wide + float(rng.uniform(2, 8)))
        f.door((wall, 0.0), (wall, wide), "junction_T")
        return
    gap = min(_door_width(rng, wide), wide - 0.3)
    low = float(rng.uniform(0.1, wide - gap - 0.1))
    f.door((wall, low), (wall, low + gap))


def _bend(f: Floor, rng: np.random.Generator, at: float, sign: int, wide: float) -> None:
    """The hallway goes on at an angle; or it ends in a room that stands askew, which is an opening."""
    turn = float(rng.uniform(0.35, 1.2)) * rng.choice([-1, 1])
    d = np.array([sign * np.cos(turn), np.sin(turn)])
    n = np.array([-d[1], d[0]])
    inner = np.array([at, wide if turn > 0 else 0.0])
    side = n * (-1 if turn * sign > 0 else 1) * wide
    long = float(rng.uniform(3, 9))
    f.spaces.append(np.array([inner, inner + long * d, inner + long * d + side, inner + side]))
    f.spaces.append(np.array([inner, inner + side, [at, wide - inner[1]], [at - sign * 0.1, wide / 2]]))
    if rng.random() < 0.5:
        half = float(rng.uniform(1.0, 2.5)) * wide
        tip = inner + long * d + side / 2
        deep = float(rng.uniform(1.8, 3.5)) * wide
        f.spaces.append(
            np.array([tip - half * n, tip + half * n, tip + half * n + deep * d, tip - half * n + deep * d])
        )
        f.transition(inner + long * d, inner + long * d + side, "opening")


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
        if np.hypot(*((a + b) / 2 - centre)) < radius + 0.2 + 0.4 * np.hypot(*(b - a)):
            return
    f.blocked.append(corners)
