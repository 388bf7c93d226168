"""Where a gateway is crossed, entered and left, by its posts and the regions that it joins (paper, section II)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rgcore.errors import EditError
from rgcore.geometry import cutting, polygons
from rgcore.model.edit import the_region
from rgcore.model.ground import ROBOT_RADIUS, shape_of
from rgcore.model.records import Point, RGMap, rounded

AWAY = 2 * ROBOT_RADIUS
"""m: gateway-points lie a robot's width before and behind the crossing-point, as those that are found"""
NEAR = 1.0
"""m: a gateway lies no farther than this from the regions that it joins"""
LEAST_WIDTH = 0.05
"""m between the posts"""


def middle(posts: tuple[Point, Point]) -> Point:
    """The place between two posts."""
    (ax, ay), (bx, by) = posts
    return rounded((ax + bx) / 2), rounded((ay + by) / 2)


def sides(posts: tuple[Point, Point], away: float = AWAY) -> tuple[Point, Point]:
    """The points left of and right of first post -> second post, ``away`` [m] from their middle."""
    (ax, ay), (bx, by) = posts
    width = max(math.dist(*posts), 1e-9)
    x, y = middle(posts)
    nx, ny = -(by - ay) / width * away, (bx - ax) / width * away
    return (rounded(x + nx), rounded(y + ny)), (rounded(x - nx), rounded(y - ny))


def directions(posts: tuple[Point, Point]) -> tuple[float, float]:
    """Both directions in which a gateway between posts is passed [rad]."""
    (ax, ay), (bx, by) = posts
    angle = math.atan2(bx - ax, -(by - ay))
    return rounded(angle), rounded(math.remainder(angle + math.pi, 2 * math.pi))


def gateway_points(map: RGMap, posts: tuple[Point, Point], regions: tuple[str, ...]) -> tuple[Point, ...]:
    """One point a region: of two, one on each side of the posts; of others, the nearest place with room for a robot.

    Raises EditError if a region is not there, or lies farther than 1 m from the posts.
    """
    shapes = [shape_of(the_region(map, id)) for id in regions]
    here = middle(posts)
    for id, shape in zip(regions, shapes, strict=True):
        if (far := cutting.distance(shape, here)) > NEAR:
            raise EditError(f"{id} is {far:.1f} m away from there; a gateway lies at the edge of what it joins")
    if len(regions) == 2:
        left, right = sides(posts)
        ways = [(left, right), (right, left)]
        return min(ways, key=lambda way: sum(cutting.distance(s, p) for s, p in zip(shapes, way, strict=True)))
    return tuple(_inside(shape, here) for shape in shapes)


def _inside(shape: Any, point: Point) -> Point:
    room = polygons.shrink(shape, ROBOT_RADIUS)
    place = polygons.nearest(room if not room.is_empty else shape, np.array([point]))[0]
    return rounded(place[0]), rounded(place[1])


def regions_beside(map: RGMap, posts: tuple[Point, Point]) -> tuple[str, ...]:
    """The two regions on both sides of posts, those nearest to where one enters; fewer where there are none."""
    found: list[str] = []
    for point in sides(posts):
        far = {r.id: cutting.distance(shape_of(r), point) for r in map.regions.values() if r.id not in found}
        best = min(far, key=lambda id: far[id], default=None)
        if best is not None and far[best] <= AWAY:
            found.append(best)
    return tuple(found)
