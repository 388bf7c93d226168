"""Gateways: which chords are transitions, and their posts on the ends of the walls (paper, section IV-D)."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np

from rgcore.config import Places as Settings
from rgcore.evidence import Evidence
from rgcore.lines.merge import Lines
from rgcore.places.chords import Chords
from rgcore.places.places import FoundGateway, Places, Point

AHEAD = 1.2
"""m: a space that opens behind a chord stays open for at least this."""


@dataclass(frozen=True, eq=False)
class Hypotheses(Evidence):
    """Chords that may be gateways, the likeliest first (K), in cells.

    posts (K, 2, 2), score (K,) in 0..1, opening (K,): wide on one side only, a hallway's end
    """

    posts: np.ndarray
    score: np.ndarray
    opening: np.ndarray


@dataclass(frozen=True, eq=False)
class Sides(Evidence):
    """What the free space does on one side of each chord (K): all in metres.

    depth  way until the space is wider than the chord for good; inf if it never is
    wide   its greatest width over the next ``AHEAD``
    stays  share of ``AHEAD`` for which it stays wide
    reach  way until it is blocked
    """

    depth: np.ndarray
    wide: np.ndarray
    stays: np.ndarray
    reach: np.ndarray


def both_sides(chords: Chords, resolution: float) -> tuple[Sides, Sides]:
    """The sides ahead of and behind each chord."""
    width, profile = chords.width * resolution, chords.profile * resolution
    need = np.maximum(1.25 * width, width + 0.3)[:, None]
    middle, span = len(chords.offsets) // 2, round(AHEAD / resolution)
    sides = []
    for side, p in enumerate((profile[:, middle:], profile[:, middle::-1])):
        wide, blocked = p >= need, p <= 0
        first = np.where(wide.any(1), wide.argmax(1), p.shape[1])
        step = np.arange(p.shape[1])
        passed = np.logical_or.accumulate(blocked, axis=1)
        after = (step >= first[:, None]) & (step < first[:, None] + span)
        sides.append(
            Sides(
                np.where(first < p.shape[1], first * resolution, np.inf),
                np.where(after, p, 0).max(1),
                (wide & after).sum(1) / np.maximum((after & ~passed).sum(1), 1),
                chords.reach[:, side] * resolution,
            )
        )
    return sides[0], sides[1]


def judge(chords: Chords, resolution: float, settings: Settings) -> Hypotheses:
    """Score the chords and keep the best of those that are near each other."""
    front, back = both_sides(chords, resolution)
    width = chords.width * resolution
    runs = np.sort(chords.runs, axis=1) * resolution
    stays = np.minimum(front.stays, back.stays) >= 0.85
    wall = front.depth + back.depth
    in_line = (runs[:, 0] >= 0.15) & (runs[:, 1] >= 0.5)
    door = stays & (wall <= 0.8) & (width <= settings.max_gateway) & in_line
    one = np.minimum(front.depth, back.depth)
    far = np.maximum(front.depth, back.depth)
    nearer = front.depth < back.depth
    wide = np.where(nearer, front.wide, back.wide)
    ahead = np.where(nearer, front.reach, back.reach)
    stay = np.where(nearer, front.stays, back.stays)
    opening = (
        ~door & (one <= 0.35) & (far >= 1.5) & (wide >= 2 * width) & (stay >= 0.9) & (ahead >= 2 * width) & in_line
    )
    kept = np.nonzero(door | opening)[0]
    lean = np.where(door, np.abs(np.minimum(front.depth, 9) - np.minimum(back.depth, 9)), one)
    score = (
        np.where(door, 1.0, 0.6)
        * np.exp(-0.3 * width)
        * np.exp(-0.5 * lean)
        * (0.5 + 0.25 * np.minimum(runs.sum(1), 2))
    )
    order = kept[np.argsort(-score[kept], kind="stable")]
    chosen: list[int] = []
    for k in order:
        if all(not _clash(chords, k, j, 0.5 / resolution) for j in chosen):
            chosen.append(k)
    pick = np.array(chosen, int)
    return Hypotheses(chords.posts[pick], score[pick], opening[pick])


def _clash(chords: Chords, a: int, b: int, near: float) -> bool:
    """Whether two chords are the same transition: their middles are near, or one crosses the other."""
    if np.hypot(*(chords.middle[a] - chords.middle[b])) < near:
        return True
    (p, q), (r, s) = chords.posts[a].astype(float), chords.posts[b].astype(float)

    def side(o: np.ndarray, t: np.ndarray, x: np.ndarray) -> float:
        return float((t[0] - o[0]) * (x[1] - o[1]) - (t[1] - o[1]) * (x[0] - o[0]))

    return side(p, q, r) * side(p, q, s) < 0 and side(r, s, p) * side(r, s, q) < 0


def snap_posts(places: Places, lines: Lines, settings: Settings) -> Places:
    """Move the posts onto ends of lines (door jambs) that are near, where the width hardly changes by it."""
    ends = lines.ends.reshape(-1, 2)
    if not len(ends):
        return places
    return Places(places.labels, places.regions, tuple(_snapped(g, ends, settings) for g in places.gateways))


def _snapped(gateway: FoundGateway, ends: np.ndarray, settings: Settings) -> FoundGateway:
    a, b = np.array(gateway.posts)
    width = np.hypot(*(b - a))
    choices = []
    for p in (a, b):
        far = np.hypot(*(ends - p).T)
        near = np.argsort(far, kind="stable")[:4]
        choices.append([(0.1, p), *[(float(far[k]), ends[k]) for k in near if far[k] <= settings.snap_distance]])
    best = min(
        (
            (da + db + 2 * abs(np.hypot(*(q - p)) - width), i, j)
            for i, (da, p) in enumerate(choices[0])
            for j, (db, q) in enumerate(choices[1])
        )
    )
    p, q = choices[0][best[1]][1], choices[1][best[2]][1]
    shift = (p + q) / 2 - (a + b) / 2
    move = lambda points: tuple(point(np.array(x) + shift) for x in points)  # noqa: E731
    return msgspec.structs.replace(
        gateway,
        posts=(point(p), point(q)),
        crossing_points=(point((p + q) / 2),),
        gateway_points=move(gateway.gateway_points),
    )


def point(p: np.ndarray) -> Point:
    """A plain point, rounded to a tenth of a millimetre."""
    return (round(float(p[0]), 4), round(float(p[1]), 4))
