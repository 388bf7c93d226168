"""A gateway hypothesis from a single scan: the closest obstacles left and right (paper, section IV-D)."""

from __future__ import annotations

import numpy as np

from rgcore.config import Places as Settings
from rgcore.geometry import se2
from rgcore.places.chords import OPPOSITE, in_line, measure_chords
from rgcore.places.divide import free_mask
from rgcore.places.freespace import FreeSpace
from rgcore.places.hypotheses import KINDS, features, network

BESIDE = np.radians((25.0, 155.0))
"""Obstacles left and right lie this far off the direction of motion."""

AHEAD, FREE = np.radians(20.0), 1.0
"""rad, m: the way ahead within this angle must be free so far."""

WINDOW = 9.0
"""m around the robot of free space that the network looks at."""


def beside(points: np.ndarray, settings: Settings) -> np.ndarray | None:
    """Posts (2, 2) that echoes (K, 2) suggest, right one first, in the frame of the robot, x in its way; or None.

    They are the closest obstacles left and right, a passage apart, opposite to each other, and the way ahead is free.
    """
    distance, angle = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    if (distance[np.abs(angle) < AHEAD] < FREE).any():
        return None
    posts = []
    for side in (-angle, angle):
        there = np.flatnonzero((side > BESIDE[0]) & (side < BESIDE[1]))
        if not len(there):
            return None
        posts.append(there[distance[there].argmin()])
    width = float(np.hypot(*(points[posts[1]] - points[posts[0]])))
    if not settings.min_gateway <= width <= settings.widest_door:
        return None
    opposite = width > 2 * OPPOSITE * float(distance[posts].min())
    return points[posts] if opposite else None


def looks_like_one(free: FreeSpace, posts: np.ndarray, settings: Settings) -> tuple[float, np.ndarray]:
    """How sure the network is that there is a door between posts (2, 2) m, and where its posts are then (2, 2) m."""
    mask = free_mask(free)
    cells = np.floor((posts - free.origin) / free.resolution).astype(np.int64)[None]
    every = np.concatenate(
        [cells, in_line(mask, cells, free.resolution), in_line(mask, cells[:, ::-1], free.resolution)]
    )
    width = np.hypot(*(every[:, 1] - every[:, 0]).T) * free.resolution
    every = every[(width >= settings.min_gateway) & (width <= settings.widest_door)]
    if not len(every):
        return 0.0, posts
    chance = network().probabilities(features(measure_chords(mask, every, free.resolution), free.resolution))
    sure = chance[:, KINDS.index("door")]
    best = int(sure.argmax())
    return float(sure[best]), free.origin + (every[best] + 0.5) * free.resolution


def in_way(points: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Echoes (K, 2) of the robot's frame in a frame with x the way it has just gone, ``moved`` (2,)."""
    way = float(np.arctan2(moved[1], moved[0]))
    return se2.transform(np.array([0.0, 0.0, -way]), points)


def crossed(start: np.ndarray, end: np.ndarray, posts: np.ndarray) -> np.ndarray:
    """Which of the lines between posts (G, 2, 2) the way from ``start`` (2,) to ``end`` (2,) crosses, (G,) mask."""

    def side(o: np.ndarray, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        return (t[..., 0] - o[..., 0]) * (x[..., 1] - o[..., 1]) - (t[..., 1] - o[..., 1]) * (x[..., 0] - o[..., 0])

    a, b = posts[:, 0], posts[:, 1]
    out: np.ndarray = (side(start, end, a) * side(start, end, b) < 0) & (side(a, b, start) * side(a, b, end) <= 0)
    return out
