"""Gateways: what is known of each transition, and its posts on the ends of the walls (paper, sections II and IV-D)."""

from __future__ import annotations

import msgspec
import numpy as np

from rgcore.config import Places as Settings
from rgcore.geometry import se2
from rgcore.geometry.grid import Grid
from rgcore.lines.merge import Lines
from rgcore.places.divide import sides
from rgcore.places.hypotheses import TRANSITIONS, Hypotheses
from rgcore.places.places import FoundGateway, Places, Point


def find_gateways(
    labels: Grid, found: Hypotheses, positions: np.ndarray, settings: Settings
) -> tuple[FoundGateway, ...]:
    """The gateways between the regions of ``labels``, in the order in which the robot passed them first.

    ``positions`` (N, 2) m: where the scans were taken.
    """
    known = []
    for k in range(len(found)):
        front, back = sides(labels.values, found.posts[k])
        if min(front, back) >= 0 and front != back:
            a, b = labels.centers(found.posts[k])
            width = float(np.hypot(*(b - a)))
            class_ = TRANSITIONS[int(found.kind[k])]
            if not class_.startswith("junction"):
                class_ = "narrow_passage" if width <= settings.widest_door else "opening"
            known.append(describe(a, b, (front, back), class_, float(found.score[k]), positions, settings))
    last = len(positions)
    return tuple(sorted(known, key=lambda g: (g.first_scan if g.first_scan >= 0 else last, g.posts)))


def describe(
    a: np.ndarray,
    b: np.ndarray,
    regions: tuple[int, int],
    class_: str,
    confidence: float,
    positions: np.ndarray,
    settings: Settings,
) -> FoundGateway:
    """A gateway between posts a and b; ``regions`` are those left of and right of a -> b."""
    middle, u = (a + b) / 2, (b - a) / np.hypot(*(b - a))
    n = np.array([-u[1], u[0]])
    passes = crossings(positions, a, b)
    away = 2 * settings.robot_radius * n
    points = {regions[0]: middle + away, regions[1]: middle - away}
    both = tuple(sorted(regions))
    angle = float(np.arctan2(n[1], n[0]))
    return FoundGateway(
        class_=class_,
        confidence=round(confidence, 4),
        regions=both,
        posts=(point(a), point(b)),
        crossing_points=(point(middle),),
        gateway_points=tuple(point(points[r]) for r in both),
        traversal_directions=(round(angle, 4), round(float(se2.wrap(angle + np.pi)), 4)),
        passed=len(passes) > 0,
        first_scan=int(passes[0]) if len(passes) else -1,
    )


def crossings(positions: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Indices of the scans after which the robot's way crosses the chord a - b."""
    p, q = positions[:-1], positions[1:]

    def side(o: np.ndarray, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        return (t[..., 0] - o[..., 0]) * (x[..., 1] - o[..., 1]) - (t[..., 1] - o[..., 1]) * (x[..., 0] - o[..., 0])

    crossed = (side(p, q, a) * side(p, q, b) <= 0) & (side(a, b, p) * side(a, b, q) <= 0)
    return np.nonzero(crossed & (np.abs(q - p).sum(1) > 0))[0]


def snap_posts(places: Places, lines: Lines, settings: Settings) -> Places:
    """Move the posts onto ends of lines (door jambs) that are near, where the width hardly changes by it; each
    gateway-point then lies in its region.
    """
    ends = lines.ends.reshape(-1, 2)
    gateways = tuple(_snapped(g, ends, settings) for g in places.gateways) if len(ends) else places.gateways
    return Places(places.labels, places.regions, tuple(_inside(g, places.labels) for g in gateways))


def _inside(gateway: FoundGateway, labels: Grid) -> FoundGateway:
    """The gateway with points that lie in its regions: nearer to the crossing where the region is shallow, else where
    the region is nearest.
    """
    middle, points = np.array(gateway.crossing_points[0]), []
    for region, at in zip(gateway.regions, np.array(gateway.gateway_points), strict=True):
        tried = middle + np.linspace(1.0, 0.2, 9)[:, None] * (at - middle)
        good = np.flatnonzero(labels.at(tried, outside=-1) == region)
        if len(good):
            points.append(point(tried[good[0]]))
            continue
        iy, ix = np.nonzero(labels.values == region)
        cells = labels.centers(np.stack([ix, iy], 1))
        points.append(point(cells[np.argmin(((cells - at) ** 2).sum(1))] if len(cells) else at))
    return msgspec.structs.replace(gateway, gateway_points=tuple(points))


def _snapped(gateway: FoundGateway, ends: np.ndarray, settings: Settings) -> FoundGateway:
    a, b = np.array(gateway.posts)
    width = np.hypot(*(b - a))
    choices = []
    for p in (a, b):
        far = np.hypot(*(ends - p).T)
        near = np.argsort(far, kind="stable")[:4]
        choices.append([(0.1, p), *[(float(far[k]), ends[k]) for k in near if far[k] <= settings.snap_distance]])
    pairs = [
        (da + db + 0.5 * abs(np.hypot(*(q - p)) - width), i, j)
        for i, (da, p) in enumerate(choices[0])
        for j, (db, q) in enumerate(choices[1])
    ]
    _, i, j = min(pairs)
    p, q = choices[0][i][1], choices[1][j][1]
    shift = (p + q) / 2 - (a + b) / 2
    return msgspec.structs.replace(
        gateway,
        posts=(point(p), point(q)),
        crossing_points=(point((p + q) / 2),),
        gateway_points=tuple(point(np.array(x) + shift) for x in gateway.gateway_points),
    )


def point(p: np.ndarray) -> Point:
    """A plain point, rounded to a tenth of a millimetre."""
    return (round(float(p[0]), 4), round(float(p[1]), 4))
