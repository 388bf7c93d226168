"""A furnished floor whose walls are known exactly, what of them a robot saw, and how a line map stands up to it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rgcore.geometry import se2
from rgcore.geometry import segments as geometry
from rgcore.geometry.raycast import cast
from rgcore.lines.merge import Lines
from rgcore.scans.floor import FACE, build_floor
from rgcore.scans.plan import Door, Furniture, Plan, Room
from rgcore.scans.simulate import Laser, Simulated, Simulation, simulate
from rgcore.slam.trajectory import Trajectory

STEP = 0.05  # m between the points of a wall
OFFSET, TURN = 0.02, np.deg2rad(0.5)  # a line farther off or turned more is not that wall
FALSE = 0.05  # m: a line with more than half of it farther from any surface shows what is not there
REACH = 12.0  # m: walls seen only from farther away do not count


class Walls(NamedTuple):
    """present: share of the seen walls (by wall, those seen for more than 0.5 m); false: share of the lines;
    offset [m] and turn [rad]: medians of the present walls."""

    walls: int
    present: float
    false: float
    offset: float
    turn: float


def furnished(wall: float = 0.1) -> Plan:
    """Six rooms on both sides of a hallway, walls of 10 cm, with desks, chairs and cabinets."""
    rooms, doors, things = [Room("hall", ((0, 0), (15, 0), (15, 2), (0, 2)), cls="hallway")], [], []
    for k in range(6):
        x, up = 5 * (k % 3), k < 3
        low, high = (2, 6) if up else (-4, 0)
        rooms.append(Room(f"room {k}", ((x, low), (x + 5, low), (x + 5, high), (x, high))))
        doors.append(Door((x + 1.5, 2 if up else 0)))
        back, away = (5.4, -1) if up else (-3.4, 1)
        things.append(Furniture("desk", (x + 3.5, back), (1.6, 0.8), shape="legs"))
        things.append(Furniture("chair", (x + 3.4, back + 0.9 * away), (0.45, 0.45), yaw=0.4, shape="legs"))
        things.append(Furniture("cabinet", (x + 0.35, back), (0.5, 0.9)))
    return Plan("furnished", (1.0, 1.0, 0.0), tuple(rooms), wall, tuple(doors), (), tuple(things))


def driven(seed: int = 0, noise: float = 0.012) -> Simulated:
    """``noise`` [m] of the ranges."""
    return simulate(build_floor(furnished(), "furnished"), Simulation(seed=seed, laser=Laser(noise=noise)))


def normalized(s: Simulated, lines: Lines, way: Trajectory | None = None) -> np.ndarray:
    """(K, 2) errors of the long lines on walls by what their covariance says: across and of the direction.

    ``way``: the poses of the mapper. The frame of its map is laid on that of the plan by the means of these.
    """
    ends = lines.ends
    if way is not None:
        turn = np.median(se2.wrap(s.map_from_base[:, 2] - way.map_from_base[:, 2]))
        middle = way.map_from_base[:, :2].mean(0)
        spun = se2.transform(np.array([0.0, 0.0, turn]), ends.reshape(-1, 2) - middle)
        ends = (spun + s.map_from_base[:, :2].mean(0)).reshape(ends.shape)
    walls = s.floor.segments[s.floor.kind == FACE]
    d, along = walls[:, 1] - walls[:, 0], ends[:, 1] - ends[:, 0]
    length = np.hypot(*d.T)
    u = d / length[:, None]
    to = ends.mean(1)[:, None] - walls[:, 0]
    off, at = u[:, 0] * to[..., 1] - u[:, 1] * to[..., 0], (to * u).sum(-1)
    turn = np.arctan2(u[:, 0] * along[:, 1:] - u[:, 1] * along[:, :1], along @ u.T)
    away = np.where((np.abs(turn) < 0.1) & (at > 0) & (at < length), np.abs(off), np.inf)
    row, wall = np.arange(len(ends)), away.argmin(1)
    good = (geometry.lengths(ends) > 0.5) & (away.min(1) < FALSE) & (lines.support >= 10)
    errors = np.column_stack([off[row, wall], turn[row, wall]])
    return (errors / np.sqrt(np.maximum(lines.covariance[:, [0, 2]], 1e-12)))[good]


def judge(lines: np.ndarray, s: Simulated) -> Walls:
    """How lines (L, 2, 2) stand up to the walls that the robot saw; map frame = frame of the plan."""
    true = s.floor.segments
    points, of = _points(true)
    seen, eyes = _seen(s, points, of)
    walls = [k for k in np.flatnonzero(s.floor.kind == FACE) if seen[of == k].sum() * STEP > 0.5]
    offsets, turns, present = [], [], 0
    for k in walls:
        own = (of == k) & seen
        off, turn = _nearest(points[own], eyes[own], lines, true[k])
        good = (off <= OFFSET) & (turn <= TURN)
        present += good.mean() >= 0.8
        offsets.append(np.median(off))
        turns.append(np.median(turn))
    at, line = _points(lines)
    away = np.array([geometry.distances(p, true).min() for p in at]) > FALSE
    false = np.bincount(line, away, len(lines)) / np.bincount(line, minlength=len(lines)) > 0.5
    return Walls(
        len(walls), present / len(walls), float(false.mean()), float(np.median(offsets)), float(np.median(turns))
    )


def _points(ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (P, 2) in the middle of every step of segments, and the segment of each."""
    count = np.maximum(1, np.round(geometry.lengths(ends) / STEP).astype(int))
    of = np.repeat(np.arange(len(ends)), count)
    share = (np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[of]
    return ends[of, 0] + share[:, None] * (ends[of, 1] - ends[of, 0]), of


def _seen(s: Simulated, points: np.ndarray, of: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(P,) mask of the points that some beam hit, and (P, 2) from where."""
    poses = s.map_from_laser
    ranges, hit = cast(s.floor.segments, poses, s.log.bearings, REACH)
    n, i = np.nonzero(hit >= 0)
    angle = poses[n, 2] + s.log.bearings[i]
    echo = poses[n, :2] + ranges[n, i][:, None] * np.stack([np.cos(angle), np.sin(angle)], 1)
    start = s.floor.segments[hit[n, i], 0]
    first, count = np.searchsorted(of, hit[n, i]), np.bincount(of)[hit[n, i]]
    length = geometry.lengths(s.floor.segments)[hit[n, i]]
    at = first + np.minimum((np.hypot(*(echo - start).T) / length * count).astype(int), count - 1)
    eyes, seen = np.zeros((len(points), 2)), np.zeros(len(points), bool)
    eyes[at], seen[at] = poses[n, :2], True
    return seen, eyes


def _nearest(
    points: np.ndarray, eyes: np.ndarray, lines: np.ndarray, wall: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Offset [m] and turn [rad] of the nearest line that is no more than 5 degrees off and seen from the same side."""
    d, w = lines[:, 1] - lines[:, 0], wall[1] - wall[0]
    turn = np.abs(np.arcsin(np.clip((d[:, 0] * w[1] - d[:, 1] * w[0]) / np.hypot(*d.T) / np.hypot(*w), -1, 1)))
    to_eye = eyes[:, None] - lines[None, :, 0]
    left = d[None, :, 0] * to_eye[..., 1] - d[None, :, 1] * to_eye[..., 0] > 0
    off = np.where(left & (turn < np.deg2rad(5)), geometry.distances(points[:, None], lines[None]), np.inf)
    best = off.argmin(1)
    return off[np.arange(len(points)), best], turn[best]
