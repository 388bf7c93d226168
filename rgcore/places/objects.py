"""Object hypotheses: groups of lines inside a room that may be one thing (paper, section III).

First the room's own walls: the long lines. What stands before a wall with its front parallel to it and its short sides
across is a cabinet; its rectangle reaches back to the wall.
"""

from __future__ import annotations

import msgspec
import numpy as np

from rgcore.config import Objects as Settings
from rgcore.lines.merge import Lines
from rgcore.places.places import Places

Point3 = tuple[float, float, float]

PARALLEL = np.radians(10)
"""rad: largest difference of directions that count as parallel."""


class FoundObject(msgspec.Struct, frozen=True, kw_only=True):
    """A box over a group of lines: ``size`` along ``yaw``, across it, and up; ``lines`` and ``region`` are indices."""

    label: str
    center: Point3
    size: Point3
    yaw: float
    lines: tuple[int, ...]
    region: int
    confidence: float


def find_objects(lines: Lines, places: Places, settings: Settings) -> tuple[FoundObject, ...]:
    """Object hypotheses of all regions, the surest first within a region."""
    found = []
    for region in range(len(places.regions)):
        own = np.nonzero(lines.region == region)[0]
        if len(own) >= 3:
            found += _cabinets(lines.ends[own], own, region, settings)
    return tuple(found)


def _cabinets(ends: np.ndarray, index: np.ndarray, region: int, settings: Settings) -> list[FoundObject]:
    """Cabinets at the walls of one region, without overlaps."""
    d = ends[:, 1] - ends[:, 0]
    length = np.hypot(*d.T)
    u = d / length[:, None]
    fronts = np.nonzero((length >= settings.min_width) & (length <= settings.max_width))[0]
    candidates = [c for f in fronts if (c := _at_wall(int(f), ends, u, length, settings)) is not None]
    candidates.sort(key=lambda c: -c[0])
    chosen: list[FoundObject] = []
    used: set[int] = set()
    for confidence, center, size, yaw, members in candidates:
        apart = all(np.hypot(center[0] - o.center[0], center[1] - o.center[1]) > 0.4 for o in chosen)
        if not used & set(members[:1]) and apart:
            used |= set(members)
            chosen.append(
                FoundObject(
                    label="cabinet",
                    center=(round(center[0], 4), round(center[1], 4), round(settings.height / 2, 4)),
                    size=(round(size[0], 4), round(size[1], 4), settings.height),
                    yaw=round(yaw, 4),
                    lines=tuple(int(index[m]) for m in members),
                    region=region,
                    confidence=round(confidence, 3),
                )
            )
    return chosen


Box = tuple[float, np.ndarray, tuple[float, float], float, list[int]]


def _at_wall(f: int, ends: np.ndarray, u: np.ndarray, length: np.ndarray, settings: Settings) -> Box | None:
    """The cabinet whose front is line f: confidence, centre, size, yaw and members; None if it is none."""
    n = np.array([-u[f, 1], u[f, 0]])
    a = ends[f, 0]
    along, up = (ends - a) @ u[f], (ends - a) @ n
    low, high = along.min(1), along.max(1)
    same = u @ u[f] > np.cos(PARALLEL)
    depth = -up.mean(1)
    behind = same & (depth >= settings.min_depth) & (depth <= settings.max_depth)
    behind &= (low < length[f] + 0.6) & (high > -0.6)
    across = np.abs(u @ n) > np.cos(PARALLEL)
    sides = []
    for at in (0.0, length[f]):
        near = across & (np.abs(along.mean(1) - at) < 0.15) & (up.max(1) > -0.2) & (up.max(1) < 0.15)
        near &= (length >= 0.1) & (length <= settings.max_depth + 0.15)
        sides.append([int(k) for k in np.nonzero(near)[0] if k != f])
    seen = sum(bool(s) for s in sides)
    walls = np.nonzero(behind)[0]
    if seen == 0 or (len(walls) == 0 and seen < 2):
        return None
    reach = [-float(up[k].min()) for s in sides for k in s]
    back = float(depth[walls[np.argmax(length[walls])]]) if len(walls) else max(reach)
    if not settings.min_depth <= back <= settings.max_depth:
        return None
    center = a + u[f] * length[f] / 2 - n * back / 2
    confidence = 0.4 + 0.2 * seen + 0.2 * (len(walls) > 0)
    members = [int(f), *[k for s in sides for k in s]]
    return confidence, center, (float(length[f]), back), float(np.arctan2(u[f, 1], u[f, 0])), members
