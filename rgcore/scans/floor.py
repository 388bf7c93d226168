"""A floor as the laser meets it: wall faces, door posts and furniture as segments, and a raster of the rooms."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from rgcore.errors import InputError
from rgcore.geometry.grid import Grid
from rgcore.scans.plan import Door, Furniture, Junction, Plan, Room
from rgcore.scans.rings import area, box_corners, edges, inset, inside, oriented, tangled

RESOLUTION = 0.05
"""m, cell of the room raster: well under half a wall."""
LEG = 0.05
"""m, side of a table's leg."""

LARGEST = 500.0
"""m, wider floors are written in another unit."""

FACE, POST, FURNITURE = 0, 1, 2
"""What a segment of a floor is: face of a wall, side of a door opening, furniture."""


@dataclass(frozen=True, eq=False)
class FloorRoom:
    """The free floor of a room: ``outline`` (K, 2) counter-clockwise, ``holes`` clockwise, both on the wall faces."""

    id: int
    room: Room
    outline: np.ndarray
    holes: tuple[np.ndarray, ...]
    area: float

    @property
    def rings(self) -> tuple[np.ndarray, ...]:
        return (self.outline, *self.holes)

    def holds(self, point: np.ndarray) -> bool:
        return bool(inside(self.rings, point[None])[0])


@dataclass(frozen=True, eq=False)
class FloorDoor:
    """A door between rooms ``a`` and ``b`` (ids): ``posts`` (2, 2), ``normal`` (2,) from b to a."""

    door: Door
    a: int
    b: int
    posts: np.ndarray
    normal: np.ndarray


@dataclass(frozen=True, eq=False)
class Floor:
    """A floor, ready to be driven through.

    source             file or name of the plan, for messages
    start    (3,)      first pose of the robot; None = anywhere
    segments (S, 2, 2) m, what the laser meets; free space to the left of start -> end
    kind     (S,)      FACE, POST or FURNITURE
    room     (S,)      id of the room that a face bounds, 0 = none
    labels             raster of room ids, 0 = no free floor
    """

    source: str
    name: str
    start: np.ndarray | None
    segments: np.ndarray
    kind: np.ndarray
    room: np.ndarray
    labels: Grid
    rooms: tuple[FloorRoom, ...] = ()
    doors: tuple[FloorDoor, ...] = ()
    junctions: tuple[Junction, ...] = ()
    furniture: tuple[Furniture, ...] = ()


def build_floor(plan: Plan, source: str | Path | None = None) -> Floor:
    """The floor of a plan. ``source`` is named in errors.

    Raises InputError for a plan that cannot be built: crossing outlines, overlapping rooms, a door that is on no common
    wall, a room without a door, furniture that stands in a wall.
    """
    where = source or plan.name
    rooms = tuple(_floor_room(i + 1, r, plan.wall, where) for i, r in enumerate(plan.rooms))
    doors = tuple(_floor_door(i, d, plan, where) for i, d in enumerate(plan.doors))
    _check(plan, rooms, doors, where)
    parts = [_faces(r, plan, doors, where) for r in rooms]
    posts = [_reveals(d, plan.wall) for d in doors if d.door.open]
    boxes = [_shape(f) for f in plan.furniture] + [[_wall_box(w.start, w.end, w.thickness)] for w in plan.walls]
    things = [edges(box[::-1]) for shape in boxes for box in shape]
    segments = np.concatenate([*parts, *posts, *things])
    n_wall = sum(len(p) for p in parts)
    kind = np.repeat([FACE, POST, FURNITURE], [n_wall, 2 * len(posts), len(segments) - n_wall - 2 * len(posts)])
    room = np.zeros(len(segments), np.int64)
    room[:n_wall] = np.repeat([r.id for r in rooms], [len(p) for p in parts])
    labels = _label(rooms, doors, [b for shape in boxes for b in shape], plan.wall, where)
    start = np.array(plan.start)
    if labels.at(start[:2]) == 0:
        raise InputError(where, f"start: ({start[0]:g}, {start[1]:g}) is not on the free floor of a room")
    return Floor(
        str(where), plan.name, start, segments, kind, room, labels, rooms, doors, plan.junctions, plan.furniture
    )


def _floor_room(id_: int, room: Room, wall: float, where: str | Path) -> FloorRoom:
    rings = [oriented(room.outline, True), *(oriented(h, False) for h in room.holes)]
    for ring in rings:
        if tangled(ring):
            raise InputError(where, f'room "{room.name}": its outline crosses itself or runs back on itself')
    outline, *holes = (inset(r, wall / 2) for r in rings)
    free = area(outline) + sum(area(h) for h in holes)
    if tangled(outline) or area(outline) <= 0 or free < 0.25:
        raise InputError(where, f'room "{room.name}": no floor is left between its walls of {wall:g} m')
    return FloorRoom(id_, room, outline, tuple(holes), free)


def _floor_door(index: int, door: Door, plan: Plan, where: str | Path) -> FloorDoor:
    """Finds the common wall: an edge of exactly two rooms that holds the middle of the door."""
    at = np.array(door.at)
    found: list[tuple[int, np.ndarray]] = []
    for i, room in enumerate(plan.rooms):
        for ring in (oriented(room.outline, True), *(oriented(h, False) for h in room.holes)):
            for start, end in edges(ring):
                length = np.linalg.norm(end - start)
                along = (end - start) / length
                s, off = (at - start) @ along, abs(along[0] * (at - start)[1] - along[1] * (at - start)[0])
                if off < 0.01 and 0 <= s <= length:
                    found.append((i + 1, along))
    name = _door_name(index, door)
    if len(found) != 2 or found[0][0] == found[1][0] or abs(found[0][1] @ found[1][1]) < 0.999:
        names = ", ".join(plan.rooms[i - 1].name for i, _ in found) or "none"
        raise InputError(
            where,
            f"{name}: not on the common wall of two rooms, but on walls of: {names}; move it to their common edge",
        )
    (a, along), (b, _) = found
    half = along * door.width / 2
    return FloorDoor(door, a, b, np.stack([at - half, at + half]), np.array([-along[1], along[0]]))


def _door_name(index: int, door: Door) -> str:
    return f"doors[{index}] at ({door.at[0]:g}, {door.at[1]:g})"


def _check(plan: Plan, rooms: tuple[FloorRoom, ...], doors: tuple[FloorDoor, ...], where: str | Path) -> None:
    names = [r.name for r in plan.rooms]
    if twice := sorted({n for n in names if names.count(n) > 1}):
        raise InputError(where, f'room "{twice[0]}": the name is used twice')
    corners = np.concatenate([r.outline for r in rooms])
    if not (np.ptp(corners, axis=0) <= LARGEST).all():
        raise InputError(where, f"the floor is more than {LARGEST:g} m wide; write coordinates in metres")
    with_door = {d.a for d in doors} | {d.b for d in doors}
    for r in rooms:
        if len(rooms) > 1 and r.id not in with_door:
            raise InputError(where, f'room "{r.room.name}": has no door; add one on a wall shared with another room')
    for j in plan.junctions:
        if j.room not in names:
            raise InputError(where, f'junction at ({j.at[0]:g}, {j.at[1]:g}): there is no room "{j.room}"')
    for i, f in enumerate(plan.furniture):
        corners = box_corners(f.at, f.size, f.yaw)
        if not any(inside(r.rings, corners).all() for r in rooms):
            raise InputError(
                where,
                f"furniture[{i}] {f.label} at ({f.at[0]:g}, {f.at[1]:g}): stands in a wall or outside of the rooms",
            )


def _faces(r: FloorRoom, plan: Plan, doors: tuple[FloorDoor, ...], where: str | Path) -> np.ndarray:
    """(K, 2, 2) faces of a room's walls, left out where an open door is."""
    mine = [(i, d) for i, d in enumerate(doors) if r.id in (d.a, d.b)]
    out = []
    for start, end in (e for ring in r.rings for e in edges(ring)):
        length = float(np.linalg.norm(end - start))
        along = (end - start) / length
        cuts = [0.0, length]
        for i, d in mine:
            off = along[0] * (d.posts - start)[:, 1] - along[1] * (d.posts - start)[:, 0]
            s = np.sort((d.posts - start) @ along)
            if (abs(off + plan.wall / 2) > 0.01).any() or s[1] < 0 or s[0] > length:
                continue
            if s[0] < -1e-9 or s[1] > length + 1e-9:
                raise InputError(
                    where, f'{_door_name(i, d.door)}: reaches into a corner of room "{r.room.name}"; move or narrow it'
                )
            if d.door.open:
                cuts += [float(s[0]), float(s[1])]
        if _overlap(cuts[2:]):
            raise InputError(where, f'room "{r.room.name}": two of its doors overlap')
        ordered = sorted(cuts)
        pieces = [(s, t) for s, t in zip(ordered[::2], ordered[1::2], strict=True) if t - s > 1e-6]
        out += [[start + along * s, start + along * t] for s, t in pieces]
    return np.array(out).reshape(-1, 2, 2)


def _overlap(cuts: list[float]) -> bool:
    spans = sorted(zip(cuts[::2], cuts[1::2], strict=True))
    return any(b[0] < a[1] for a, b in pairwise(spans))


def _passage(d: FloorDoor, wall: float) -> np.ndarray:
    """(4, 2) the floor in the wall, counter-clockwise: edge 1 and edge 3 are its sides."""
    n = d.normal * wall / 2
    return np.stack([d.posts[0] - n, d.posts[1] - n, d.posts[1] + n, d.posts[0] + n])


def _reveals(d: FloorDoor, wall: float) -> np.ndarray:
    return edges(_passage(d, wall))[[1, 3]]


def _shape(f: Furniture) -> list[np.ndarray]:
    """Rectangles (4, 2), counter-clockwise, that a piece of furniture shows to the laser."""
    if f.shape == "box":
        return [box_corners(f.at, f.size, f.yaw)]
    legs = box_corners(f.at, (max(f.size[0] - LEG, LEG), max(f.size[1] - LEG, LEG)), f.yaw)
    return [box_corners((float(x), float(y)), (LEG, LEG), f.yaw) for x, y in legs]


def _wall_box(start: tuple[float, float], end: tuple[float, float], thickness: float) -> np.ndarray:
    (ax, ay), (bx, by) = start, end
    yaw, length = float(np.arctan2(by - ay, bx - ax)), float(np.hypot(bx - ax, by - ay))
    return box_corners(((ax + bx) / 2, (ay + by) / 2), (length, thickness), yaw)


def _label(
    rooms: tuple[FloorRoom, ...], doors: tuple[FloorDoor, ...], boxes: list[np.ndarray], wall: float, where: str | Path
) -> Grid:
    """The room raster. A door's floor goes half to each room; furniture is no floor."""
    points = np.concatenate([r.outline for r in rooms])
    low, high = points.min(0) - 2 * wall, points.max(0) + 2 * wall
    origin = np.where((points.min(0) >= 0) & (points.min(0) < 50), 0.0, np.floor(low))  # readers that know no origin
    w, h = np.ceil((high - origin) / RESOLUTION).astype(int)
    grid = Grid(np.zeros((h, w), np.uint8), origin, RESOLUTION)
    values = np.zeros((h, w), np.uint8)

    def cells(rings: tuple[np.ndarray, ...]) -> tuple[np.ndarray, np.ndarray]:
        lo, hi = np.clip(grid.cells(np.stack([rings[0].min(0), rings[0].max(0)])), 0, [w - 1, h - 1])
        x, y = np.meshgrid(np.arange(lo[0], hi[0] + 1), np.arange(lo[1], hi[1] + 1))
        xy = np.stack([x.ravel(), y.ravel()], 1)
        xy = xy[inside(rings, grid.centers(xy))]
        return xy[:, 1], xy[:, 0]

    for r in rooms:
        at = cells(r.rings)
        if (values[at] > 0).any():
            other = rooms[int(values[at].max()) - 1].room.name
            raise InputError(where, f'rooms "{other}" and "{r.room.name}" overlap')
        values[at] = r.id
    for d in doors:
        if d.door.open:
            iy, ix = cells((_passage(d, wall),))
            side = (grid.centers(np.stack([ix, iy], 1)) - d.posts[0]) @ d.normal
            values[iy, ix] = np.where(side > 0, d.a, d.b)
    for box in boxes:
        values[cells((box,))] = 0
    return grid.like(values)
