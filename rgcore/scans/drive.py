"""Where a simulated robot goes: into every room, through every door, round the hallways and back to its start."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np
from scipy.sparse.csgraph import connected_components

from rgcore.config import Settings, setting
from rgcore.errors import InputError
from rgcore.geometry import se2
from rgcore.geometry.raycast import cast
from rgcore.scans.floor import FACE, Floor, FloorDoor
from rgcore.scans.roads import Roads


class Driving(Settings, frozen=True):
    """How the robot drives."""

    radius: Annotated[float, setting("m", "a robot of 0.5 m across", gt=0, le=2)] = 0.26
    step: Annotated[float, setting("m", "a scan each time it has come so far", gt=0, le=2)] = 0.18
    turn: Annotated[float, setting("rad", "a scan each time it has turned so far: 9 degrees", gt=0, le=1)] = 0.16
    speed: Annotated[float, setting("m/s", "walking pace of an indoor robot", gt=0, le=5)] = 0.4
    turn_speed: Annotated[float, setting("rad/s", "40 degrees a second", gt=0, le=5)] = 0.7
    view: Annotated[float, setting("m", "walls count as looked at from no farther than this", gt=0, le=50)] = 4.5
    hallway_view: Annotated[float, setting("m", "in hallways: short, to be driven all along", gt=0, le=50)] = 3.0
    coverage: Annotated[float, setting("1", "share of walls to look at; others hide behind things", gt=0, le=1)] = 0.85


@dataclass(frozen=True, eq=False)
class Drive:
    """``poses`` (N, 3) of the robot's centre at each scan, ``stamps`` (N,) s from the start."""

    poses: np.ndarray
    stamps: np.ndarray


@dataclass(frozen=True)
class _Stop:
    """A node to drive to; at a ``look`` the robot turns so that it has seen all around."""

    node: int
    look: bool


def drive(floor: Floor, settings: Driving | None = None) -> Drive:
    """A drive through the whole floor that can be reached from its start, and back.

    Every room is entered and looked at all around, every open door is passed through its middle, no wall comes nearer
    than the robot's radius. Raises InputError if the start or a room with an open door cannot be reached.
    """
    s = settings or Driving()
    roads = Roads(floor, s.radius)
    start, reached = _reachable(floor, roads)
    stops = [_Stop(start, False), *_look_points(floor, roads, reached, s)]
    order = _tour(roads.costs([p.node for p in stops], [p.node for p in stops]))
    stops = [stops[i] for i in order] + [stops[0]]
    ways = [roads.way(a.node, b.node) for a, b in pairwise(stops)]
    for door in floor.doors:
        if door.door.open and not crosses(np.concatenate(ways), door.posts).any():
            _pass_door(door, roads, reached, stops, ways)
    heading = 0.0 if floor.start is None else float(floor.start[2])
    first = np.array([*roads.xy[start], heading])
    return _poses(_fine(first, stops, ways, roads), s)


def _reachable(floor: Floor, roads: Roads) -> tuple[int, np.ndarray]:
    """The start node, and the nodes that can be reached from it."""
    if len(roads.xy) == 0:
        raise InputError(floor.source, "no place in it is wide enough for the robot; make the robot's radius smaller")
    _, part = connected_components(roads.graph, directed=False)
    if floor.start is None:
        largest = np.flatnonzero(part == np.bincount(part).argmax())
        start = int(largest[roads.clearance[largest].argmax()])
    else:
        start = roads.nearest(floor.start[:2])
        if np.hypot(*(roads.xy[start] - floor.start[:2])) > 0.3:
            raise InputError(floor.source, "start: no room for the robot there; move it away from walls and furniture")
    reached = np.flatnonzero(part == part[start])
    inside = set(roads.room[reached].tolist())
    open_ = {i for d in floor.doors if d.door.open for i in (d.a, d.b)}
    for r in floor.rooms:
        if r.id in open_ and r.id not in inside:
            raise InputError(
                floor.source, f'room "{r.room.name}": the robot cannot get in; move furniture or widen the door'
            )
    return start, reached


def _look_points(floor: Floor, roads: Roads, reached: np.ndarray, s: Driving) -> list[_Stop]:
    """Per room, few places from which its walls are seen (greedy set cover over pieces of 0.25 m)."""
    out = []
    for room in np.unique(roads.room[reached]):
        hallway = bool(floor.rooms) and floor.rooms[int(room) - 1].room.cls == "hallway"
        nodes = reached[roads.room[reached] == room]
        nodes = nodes[np.unique(np.round(roads.xy[nodes] / 0.4).astype(int), axis=0, return_index=True)[1]]
        nodes = _well_inside(floor, roads, nodes, int(room))
        seen = _walls_seen(floor, roads.xy[nodes], int(room), s.hallway_view if hallway else s.view)
        left: set[int] = set().union(*seen)
        enough = (1 - s.coverage) * len(left)
        while len(left) > enough:
            gain = np.array([len(p & left) for p in seen]) * (1 + 0.3 * np.minimum(roads.clearance[nodes], 1.0))
            best = int(gain.argmax())
            left -= seen[best]
            out.append(_Stop(int(nodes[best]), not hallway))
    return out


def _well_inside(floor: Floor, roads: Roads, nodes: np.ndarray, room: int) -> np.ndarray:
    """The nodes of a room that are no nearer than 1.3 m to its doors: who looks from a doorway has not been inside."""
    doors = [d.posts.mean(0) for d in floor.doors if d.door.open and room in (d.a, d.b)]
    if not doors:
        return nodes
    inside = nodes[np.linalg.norm(roads.xy[nodes, None] - np.array(doors), axis=2).min(1) >= 1.3]
    return inside if len(inside) else nodes


def _walls_seen(floor: Floor, points: np.ndarray, room: int, view: float) -> list[set[int]]:
    """For each point, the pieces (0.25 m) of the room's wall faces that are seen from there."""
    bearings = np.deg2rad(np.arange(-180.0, 180.0))
    ranges, hit = cast(floor.segments, np.column_stack([points, np.zeros(len(points))]), bearings, view)
    ok = (hit >= 0) & (floor.kind[hit] == FACE) & (floor.room[hit] == room)
    ends = points[:, None] + np.where(ok, ranges, 0)[..., None] * np.stack([np.cos(bearings), np.sin(bearings)], -1)
    along = np.linalg.norm(ends - floor.segments[hit, 0], axis=-1)
    piece = np.where(ok, hit * 4096 + (along / 0.25).astype(np.int64), -1)
    return [set(p[p >= 0].tolist()) for p in piece]


def _tour(cost: np.ndarray) -> list[int]:
    """A short round trip from 0: nearest neighbour, then 2-opt and or-opt moves until none helps."""
    n = len(cost)
    order, left = [0], set(range(1, n))
    while left:
        order.append(min(left, key=lambda j: (cost[order[-1], j], j)))
        left.remove(order[-1])
    better = True
    while better:
        better = False
        for i in range(1, n - 1):
            for j in range(i + 1, n):
                a, b, c, d = order[i - 1], order[i], order[j], order[(j + 1) % n]
                if cost[a, c] + cost[b, d] < cost[a, b] + cost[c, d] - 1e-9:
                    order[i : j + 1] = order[i : j + 1][::-1]
                    better = True
        for i in range(1, n):
            stop = order[i]
            rest = order[:i] + order[i + 1 :]
            ring = np.array([*rest, 0])
            extra = cost[ring[:-1], stop] + cost[stop, ring[1:]] - cost[ring[:-1], ring[1:]]
            best = int(extra.argmin())
            if extra[best] < extra[i - 1] - 1e-9:
                order = [*rest[: best + 1], stop, *rest[best + 1 :]]
                better = True
    return order


def crosses(path: np.ndarray, posts: np.ndarray) -> np.ndarray:
    """(K - 1,) which steps of a path (K, 2) cross between two posts (2, 2)."""
    along = posts[1] - posts[0]
    normal = np.array([-along[1], along[0]])
    side = (path - posts[0]) @ normal
    change = (side[:-1] > 0) != (side[1:] > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(change, side[:-1] / (side[:-1] - side[1:]), 0.0)
    u = ((path[:-1] + t[:, None] * np.diff(path, axis=0)) - posts[0]) @ along / (along @ along)
    return change & (u >= 0) & (u <= 1)


def _pass_door(door: FloorDoor, roads: Roads, reached: np.ndarray, stops: list[_Stop], ways: list[np.ndarray]) -> None:
    """Put the way through a door into the tour where the detour is shortest (in place); not if it is blocked."""
    a, b = (roads.nearest(p, reached) for p in door.posts.mean(0) + np.array([[0.7], [-0.7]]) * door.normal)
    if not crosses(roads.way(a, b), door.posts).any():
        return
    from_a, from_b = roads.costs([a, b], [p.node for p in stops])
    there, back = from_a[:-1] + from_b[1:], from_b[:-1] + from_a[1:]
    legs = np.array([np.linalg.norm(np.diff(w, axis=0), axis=1).sum() for w in ways])
    k = int((np.minimum(there, back) - legs).argmin())
    one, two = (a, b) if there[k] <= back[k] else (b, a)
    stops[k + 1 : k + 1] = [_Stop(one, False), _Stop(two, False)]
    ways[k : k + 1] = [roads.way(stops[i].node, stops[i + 1].node) for i in (k, k + 1, k + 2)]


def _fine(first: np.ndarray, stops: list[_Stop], ways: list[np.ndarray], roads: Roads) -> np.ndarray:
    """(K, 3) the drive in small steps, heading unwrapped: smooth runs, turns on the spot between them."""
    runs: list[np.ndarray] = []
    looks: list[bool] = []
    for stop, way in zip(stops[:-1], ways, strict=True):
        if len(way) < 2:
            continue
        ahead = way[min(5, len(way) - 1)] - way[0]
        behind = runs[-1][-1] - runs[-1][max(-6, -len(runs[-1]))] if runs else ahead
        if runs and not stop.look and ahead @ behind > 0.3 * np.linalg.norm(ahead) * np.linalg.norm(behind):
            runs[-1] = np.concatenate([runs[-1], way[1:]])
        else:
            runs.append(way)
            looks.append(stop.look)
    out = [first[None]]
    for run, look in zip(runs, looks, strict=True):
        xy = _smooth(run, roads)
        step = np.gradient(xy, axis=0)
        heading = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
        now = out[-1][-1, 2]
        turn = float(se2.wrap(heading[0] - now))
        if look and abs(turn) < np.deg2rad(150):  # the laser sees half around: the longer way shows the other half
            turn -= np.sign(turn) * 2 * np.pi if turn else 2 * np.pi
        n = max(int(abs(turn) / 0.02), 1)
        spot = np.column_stack([np.tile(xy[0], (n, 1)), now + turn * np.arange(1, n + 1) / n])
        out += [spot, np.column_stack([xy, heading - heading[0] + spot[-1, 2]])]
    end = out[-1][-1]
    n = 100
    turn = float(se2.wrap(first[2] - end[2]))
    out.append(np.column_stack([np.tile(end[:2], (n, 1)), end[2] + turn * np.arange(1, n + 1) / n]))
    return np.concatenate(out)


def _smooth(way: np.ndarray, roads: Roads) -> np.ndarray:
    """The way as a taut band of points every 0.05 m that keeps its clearance."""
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
    at = np.linspace(0, s[-1], max(int(s[-1] / 0.05), 2))
    xy = np.column_stack([np.interp(at, s, way[:, 0]), np.interp(at, s, way[:, 1])])
    keep = np.minimum(roads.room_to_drive(xy), roads.margin + 0.12)
    for _ in range(150):
        new = xy.copy()
        new[1:-1] += 0.5 * ((xy[:-2] + xy[2:]) / 2 - xy[1:-1])
        ok = roads.room_to_drive(new) >= keep - 1e-9
        xy = np.where(ok[:, None], new, xy)
    return xy


def _poses(fine: np.ndarray, s: Driving) -> Drive:
    """Poses where scans are taken: a scan each ``step`` of way and each ``turn``, both together counted in parts."""
    move = np.linalg.norm(np.diff(fine[:, :2], axis=0), axis=1)
    turn = np.abs(np.diff(fine[:, 2]))
    done = np.concatenate([[0], np.cumsum(move / s.step + turn / s.turn)])
    time = np.concatenate([[0], np.cumsum(move / s.speed + turn / s.turn_speed)])
    at = np.arange(int(done[-1]) + 1)
    poses = np.column_stack([np.interp(at, done, fine[:, k]) for k in range(3)])
    poses[:, 2] = se2.wrap(poses[:, 2])
    return Drive(poses, np.interp(at, done, time))
