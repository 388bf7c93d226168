"""Chords: the places where free space is narrow, and what they look like from both sides.

A chord joins the two nearest obstacles left and right of a point on the medial axis of the free space: the critical
lines of Thrun (1998) and, for a robot in a passage, the "closest obstacles left and right" of the paper (section IV-D).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.config import Places as Settings
from rgcore.evidence import Evidence
from rgcore.geometry.grid import clearance, dilate, reach

OPPOSITE = 0.9
"""Sine of half the angle that the two nearest obstacles must at least subtend: they lie on opposite sides."""

LOOK = 4.0
"""m: how far ahead and behind a chord the width of the free space is measured."""

FAN = np.radians(np.arange(-75.0, 76.0, 15.0))
"""Directions of the beams of a fan, from straight ahead towards the second post."""

NEAR = (1.0, 2.0, 3.5)
"""m: how far from a chord the largest disc of free space is looked for."""


@dataclass(frozen=True, eq=False)
class Chords(Evidence):
    """Candidates for gateways (K chords), in cells of the raster.

    posts    (K, 2, 2) the cells of the two obstacles
    middle   (K, 2)    halfway between them
    along    (K, 2)    unit vector from the first post to the second
    width    (K,)      distance of the posts, less the half cell on each side that is the obstacle itself
    reach    (K, 2)    how far one comes ahead and behind, up to twice ``LOOK``
    profile  (K, S, 2) free way from the line through the middle towards the side of each post, at each of ``offsets``
                       along that line; 0 where the line is blocked before
    runs     (K, 2)    how far a wall goes on beyond each post in line with the chord, up to half of ``LOOK``
    thick    (K, 2)    how thick that wall is a little beyond each post, up to half of ``LOOK``
    fan      (K, 2, F) ranges from the middle ahead and behind, in the directions ``FAN``, up to 1.5 times ``LOOK``
    disc     (K, 2, 3) radius of the largest disc of free space ahead and behind whose centre the fan sees, as far away
                       as ``NEAR`` says
    offsets  (S,)      positions along the way through, from behind (negative) to ahead
    """

    posts: np.ndarray
    middle: np.ndarray
    along: np.ndarray
    width: np.ndarray
    reach: np.ndarray
    profile: np.ndarray
    runs: np.ndarray
    thick: np.ndarray
    fan: np.ndarray
    disc: np.ndarray
    offsets: np.ndarray

    @classmethod
    def whole(cls) -> frozenset[str]:
        return frozenset({"offsets"})


def find_chords(free: np.ndarray, resolution: float, settings: Settings, where: np.ndarray | None = None) -> Chords:
    """All chords of the free space (H, W) that a robot may fit through and that are no wider than an opening.

    With a mask ``where`` (H, W) only those near the medial axis within it.
    """
    distance, nearest = clearance(free)
    low, high = 0.5 * settings.min_gateway / resolution, 0.5 * settings.max_gateway / resolution
    posts = []
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        h, w = free.shape
        here = np.s_[: h - dy, max(0, -dx) : w - max(0, dx)]
        there = np.s_[dy:, max(0, dx) : w + min(0, dx)]
        d = distance[here]
        y, x = np.nonzero((d > low) & (d < high))
        a, b = nearest[here][y, x], nearest[there][y, x]
        keep = np.hypot(*(a - b).T) > 2 * OPPOSITE * d[y, x]
        if where is not None:
            keep &= where[y, x]
        posts.append(np.stack([a[keep], b[keep]], 1))
    pairs = _unique(np.concatenate(posts))
    turned = [in_line(free, p, resolution) for p in (pairs, pairs[:, ::-1])]
    pairs = _unique(np.concatenate([pairs, *turned]))
    gap = np.hypot(*(pairs[:, 1] - pairs[:, 0]).T) - 1
    return measure_chords(free, pairs[(gap >= 2 * low) & (gap <= 2 * high)], resolution, distance)


def _unique(pairs: np.ndarray) -> np.ndarray:
    """Each chord once, whichever post comes first."""
    flip = (pairs[:, 0, 0] > pairs[:, 1, 0]) | ((pairs[:, 0, 0] == pairs[:, 1, 0]) & (pairs[:, 0, 1] > pairs[:, 1, 1]))
    pairs = np.where(flip[:, None, None], pairs[:, ::-1], pairs)
    return np.unique(pairs.reshape(-1, 4), axis=0).reshape(-1, 2, 2)


def in_line(free: np.ndarray, posts: np.ndarray, resolution: float) -> np.ndarray:
    """Chords (K, 2, 2) turned about their first post until they go on in line with a wall behind it.

    The chord of a door beside a corner of a room leans towards the corner's other wall; a door is closed by the
    continuation of its own wall.
    """
    a, d = posts[:, 0] + 0.5, (posts[:, 1] - posts[:, 0]).astype(float)
    n = round(LOOK / resolution)
    angle = np.arctan2(d[:, 1], d[:, 0])[:, None] + np.radians(np.arange(-48, 49, 4))[None]
    direction = np.stack([np.cos(angle), np.sin(angle)], -1).reshape(-1, 2)
    start = np.repeat(a, angle.shape[1], axis=0)
    wall = dilate(~free, 1)
    length = 1.5 + reach(free, start + 1.5 * direction, direction, 2 * n)
    end = start + length[:, None] * direction
    runs = reach(wall, start, -direction, 0.25 * n) + 0.5 * reach(wall, end, direction, 0.25 * n)
    value = (runs - length).reshape(angle.shape)
    value[(length <= 2).reshape(angle.shape)] = -np.inf
    best = np.arange(len(posts)), value.argmax(1)
    tip = np.floor(end.reshape(*angle.shape, 2)[best]).astype(posts.dtype)
    return np.stack([posts[:, 0], tip], 1)


def measure_chords(
    free: np.ndarray, posts: np.ndarray, resolution: float, distance: np.ndarray | None = None
) -> Chords:
    """Chords between given cells (K, 2, 2), with what the free space and the walls around them look like.

    ``distance`` (H, W): the clearance of the free space [cells], where it is known already.
    """
    distance = clearance(free)[0] if distance is None else distance
    a, b = posts[:, 0] + 0.5, posts[:, 1] + 0.5
    middle, gap = (a + b) / 2, np.hypot(*(b - a).T)
    along = (b - a) / np.maximum(gap, 1)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], 1)
    n = round(LOOK / resolution)
    offsets = np.arange(-n, n + 1, 2)
    ahead = np.stack([reach(free, middle, across, 2 * n), reach(free, middle, -across, 2 * n)], 1)
    points = middle[:, None] + offsets[None, :, None] * across[:, None]
    k, s = np.nonzero((offsets <= ahead[:, :1]) & (offsets >= -ahead[:, 1:]))
    profile = np.zeros((len(posts), len(offsets), 2))
    profile[k, s, 0] = reach(free, points[k, s], -along[k], n)
    profile[k, s, 1] = reach(free, points[k, s], along[k], n)
    blocked = ~free
    near_wall = dilate(blocked, 2)
    runs = np.stack([reach(near_wall, a, -along, n / 2), reach(near_wall, b, along, n / 2)], 1)
    beyond = 0.2 / resolution
    thick = [
        reach(blocked, p + beyond * d, across, n / 2) + reach(blocked, p + beyond * d, -across, n / 2)
        for p, d in ((a, -along), (b, along))
    ]
    fan, disc = _look_around(free, distance, middle, along, across, resolution)
    return Chords(posts, middle, along, gap - 1, ahead, profile, runs, np.stack(thick, 1), fan, disc, offsets)


def _look_around(
    free: np.ndarray,
    distance: np.ndarray,
    middle: np.ndarray,
    along: np.ndarray,
    across: np.ndarray,
    resolution: float,
) -> tuple[np.ndarray, np.ndarray]:
    """What one sees from the middle of each chord, ahead and behind: ranges of a fan and the sizes of the space."""
    far, step = 1.5 * LOOK / resolution, 0.35 / resolution
    fan, disc = np.zeros((len(middle), 2, len(FAN))), np.zeros((len(middle), 2, len(NEAR)))
    steps = np.arange(step, NEAR[-1] / resolution + 1, step)
    for i, sign in enumerate((1, -1)):
        beams = sign * np.cos(FAN)[:, None] * across[:, None] + np.sin(FAN)[:, None] * along[:, None]
        starts = np.repeat(middle, len(FAN), axis=0)
        fan[:, i] = reach(free, starts, beams.reshape(-1, 2), far).reshape(-1, len(FAN))
        points = (middle[:, None, None] + steps[:, None] * beams[:, :, None]).astype(np.int32)
        seen = steps < fan[:, i, :, None]
        points[~seen] = 0
        room = np.where(seen, distance[points[..., 1], points[..., 0]], 0).max(1)
        for j, near in enumerate(NEAR):
            disc[:, i, j] = room[:, steps <= near / resolution + 1].max(1)
    return fan, disc
