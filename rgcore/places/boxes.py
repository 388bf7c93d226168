"""Boxes that a room's lines may be the faces of, and what speaks for each (paper, section III).

A box stands on a *front*, a line of the room; its free space lies left of start -> end, so that the box lies right of
it. Each of its four sides is a *face* (a line that looks away from the box covers it, or the raster shows free space
before it and none behind), or stands at a *wall* (a line that looks towards the box lies in its plane), or is not seen.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from rgcore.config import Objects as Settings
from rgcore.evidence import Evidence
from rgcore.geometry.grid import Grid

PARALLEL = float(np.cos(np.radians(10)))
"""cosine of the largest difference of directions that count as parallel"""
PLANE = 0.1
"""m: a line this near to a side lies in it: merged lines are good to a few centimetres, small ones to a few degrees"""
FLUSH = 0.05
"""m: lines of one front are nearer to one plane: two cabinets side by side seldom are"""
THICK = 0.32
"""m: a box thinner than this whose other side is seen from another room is a wall"""
REACH = 0.8
"""m: how far beyond the end of its visible part a front may go on: other things stand before it"""
STRIP = np.array([0.07, 0.12])
"""m: where free space is looked for before and behind a side; nearer the raster's cells hold echoes of the side"""
FRONT, RIGHT, BACK, LEFT = range(4)
"""the sides of a box, seen from above with the front on top"""


@dataclass(frozen=True, eq=False)
class Boxes(Evidence):
    """Box hypotheses (K).

    front   (K,)      index of the line that the front stands on
    origin  (K, 2)    m, the left end of the front
    u       (K, 2)    direction of the front; the box lies right of it
    size    (K, 2)    m, along the front and behind it
    face    (K, 4)    share of each side (front, right, back, left) that lines cover
    wall    (K, 4)    1 where a wall lies in the plane of the side and touches it, falling to 0 with its distance
    edge    (K, 4)    share of each side where the raster shows free space before it and none behind
    open    (K, 4)    share of each side with free space before it
    solid   (K,)      share of the inside that no beam passed
    beyond  (K, 4)    m, how far the lines of a side go on beyond its ends: the box would be a part of something longer
    inside  (K,)      m, length of other lines inside
    foreign (K,)      share of the length or width along which lines of other rooms run inside: the box is a wall
    members (K, L)    the lines that are faces of the box
    """

    front: np.ndarray
    origin: np.ndarray
    u: np.ndarray
    size: np.ndarray
    face: np.ndarray
    wall: np.ndarray
    edge: np.ndarray
    open: np.ndarray
    solid: np.ndarray
    beyond: np.ndarray
    inside: np.ndarray
    foreign: np.ndarray
    members: np.ndarray

    @property
    def down(self) -> np.ndarray:
        """Direction (K, 2) from the front to the back."""
        return np.stack([self.u[:, 1], -self.u[:, 0]], 1)


def features(boxes: Boxes) -> np.ndarray:
    """(K, 33) what speaks for each box: of its front and back, of the side that is seen better, of the other one.

    A box and its mirror image have the same features.
    """
    hidden = (1 - boxes.open) * (1 - boxes.wall) * (1 - np.maximum(boxes.face, boxes.edge))
    beyond = np.minimum(boxes.beyond, 1.0)
    of_side = np.stack([boxes.face, boxes.wall, boxes.edge, boxes.open, hidden, beyond], 2)
    seen = np.maximum(boxes.face, boxes.edge) + 0.01 * boxes.wall
    swap = seen[:, RIGHT] < seen[:, LEFT]
    order = np.where(swap[:, None], [FRONT, BACK, LEFT, RIGHT], [FRONT, BACK, RIGHT, LEFT])
    sides = np.take_along_axis(of_side, order[..., None], 1).reshape(len(boxes), -1)
    width, depth = boxes.size.T
    whole = [
        boxes.solid,
        np.minimum(boxes.inside, 2.0),
        boxes.foreign,
        np.log(width),
        np.log(depth),
        np.minimum(boxes.size.min(1), 0.6),
        (boxes.open * (1 - seen)).sum(1),
        hidden.sum(1),
        boxes.members.sum(1) / 4,
    ]
    return np.c_[sides, np.stack(whole, 1)]


def boxes_on(ends: np.ndarray, foreign: np.ndarray, free: Grid, settings: Settings) -> Boxes | None:
    """All boxes that lines (L, 2, 2) of one room suggest; None if there are none.

    ``foreign`` (M, 2, 2): lines of other rooms; ``free``: mask of the free space.
    """
    d = ends[:, 1] - ends[:, 0]
    length = np.hypot(*d.T)
    u = d / length[:, None]
    parts = []
    for f in np.nonzero((length >= settings.min_face) & (length <= settings.max_width))[0]:
        n = np.array([-u[f, 1], u[f, 0]])
        local = _Local((ends - ends[f, 0]) @ u[f], (ends - ends[f, 0]) @ n, u @ u[f], u @ n)
        spans = _spans(local, float(length[f]), settings)
        if len(spans):
            across = _crossing((foreign - ends[f, 0]) @ u[f], (foreign - ends[f, 0]) @ n, spans)
            parts.append((np.full(len(spans), f), spans, *_sides(local, spans), across))
    if not parts:
        return None
    front, spans, face, wall, beyond, inside, members, across = map(np.concatenate, zip(*parts, strict=True))
    low, high, depth = spans.T
    origin = ends[front, 0] + u[front] * low[:, None]
    size = np.stack([high - low, depth], 1)
    edge, open_, solid = _raster(origin, u[front], size, free)
    return Boxes(front, origin, u[front], size, face, wall, edge, open_, solid, beyond, inside, across, members)


class _Local:
    """Lines in the frame of a front: x along it, y before it; the box lies at negative y."""

    def __init__(self, x: np.ndarray, y: np.ndarray, cos: np.ndarray, sin: np.ndarray) -> None:
        self.x, self.y = np.sort(x, 1), np.sort(y, 1)
        # the sides that a line would be a face of: it looks to the same side as the front, right, back, left
        self.looks = (cos > PARALLEL, sin < -PARALLEL, cos < -PARALLEL, sin > PARALLEL)

    def at(self, side: int) -> tuple[np.ndarray, np.ndarray]:
        """Where lines lie across (L,) and along (L, 2) the sides front and back, or right and left."""
        return (self.y.mean(1), self.x) if side in (FRONT, BACK) else (self.x.mean(1), self.y)


def _spans(lines: _Local, length: float, settings: Settings) -> np.ndarray:
    """Left end, right end and depth (k, 3) of the boxes on a front."""
    mx, my = lines.x.mean(1), -lines.y.mean(1)
    beside = (lines.y[:, 1] > -0.4) & (lines.y[:, 0] < -0.08)
    ends = beside & (lines.y[:, 1] < 0.5)
    across = (lines.looks[RIGHT] | lines.looks[LEFT]) & ends
    high = mx[(across | lines.looks[LEFT] & beside) & (mx > length - 0.15) & (mx < length + REACH)]
    low = mx[(across | lines.looks[RIGHT] & beside) & (mx < 0.15) & (mx > -REACH)]
    near = (lines.x[:, 0] < length + 2) & (lines.x[:, 1] > -2) & (my > 0)
    over = np.minimum(lines.x[:, 1], length) - np.maximum(lines.x[:, 0], 0)
    side = across & (lines.looks[RIGHT] & (np.abs(mx - length) < 0.2) | lines.looks[LEFT] & (np.abs(mx) < 0.2))
    depth = np.concatenate(
        [
            my[lines.looks[FRONT] & near],
            my[lines.looks[BACK] & (over > 0.3 * length)],
            -lines.y[side & (lines.y[:, 1] < 0.15), 0],
        ]
    )
    lows, highs, depths = (
        _distinct([0.0, *low.tolist()]),
        _distinct([length, *high.tolist()]),
        _distinct(depth.tolist()),
    )
    spans = []
    for a, b, d in itertools.product(lows, highs, depths):
        small, large = sorted((b - a, d))
        if settings.min_depth <= small <= settings.max_depth and settings.min_width <= large <= settings.max_width:
            spans.append((a, b, d))
    return np.array(spans).reshape(-1, 3)


def _distinct(values: list[float]) -> list[float]:
    """Values that differ by 4 cm."""
    out: list[float] = []
    for v in sorted(values):
        if not out or v - out[-1] > 0.04:
            out.append(v)
    return out


def _sides(lines: _Local, spans: np.ndarray) -> tuple[np.ndarray, ...]:
    """What lines say of boxes: ``face``, ``wall``, ``beyond``, ``inside`` and ``members``, as in Boxes."""
    low, high, depth = (s[:, None] for s in spans.T)
    zero = np.zeros_like(low)
    planes = (zero, high, -depth, low)
    ranges = ((low, high), (-depth, zero), (low, high), (-depth, zero))
    face, wall, beyond = (np.zeros((len(spans), 4)) for _ in range(3))
    members = np.zeros((len(spans), len(lines.x)), bool)
    for s in range(4):
        at, along = lines.at(s)
        (a, b), off = ranges[s], np.abs(at - planes[s])
        common = np.minimum(along[:, 1], b) - np.maximum(along[:, 0], a)
        face_lines = (off < (FLUSH if s == FRONT else PLANE)) & lines.looks[s]
        mine = face_lines & (common > 0.5 * (along[:, 1] - along[:, 0]))
        face[:, s] = np.minimum(np.where(mine, common, 0).sum(1) / (b - a)[:, 0], 1)
        rest = np.maximum(along[:, 1] - b, 0) + np.maximum(a - along[:, 0], 0)
        beyond[:, s] = np.where(face_lines & (common > -0.1), rest, 0).max(1)
        gap = np.where((off < PLANE) & lines.looks[(s + 2) % 4], np.maximum(-common, 0), np.inf).min(1)
        wall[:, s] = np.maximum(1 - gap / 2, 0)
        members |= mine
    x, y = lines.x.mean(1), lines.y.mean(1)
    within = (x > low + PLANE) & (x < high - PLANE) & (y > PLANE - depth) & (y < -PLANE) & ~members
    inside = within @ np.hypot(*(np.diff(v, axis=1)[:, 0] for v in (lines.x, lines.y)))
    return face, wall, beyond, inside, members


def _crossing(x: np.ndarray, y: np.ndarray, spans: np.ndarray) -> np.ndarray:
    """Share (k,) of a box along which lines (M, 2), in the frame of the front, run inside, or in a thin one's sides."""
    low, high, depth = (s[:, None] for s in spans.T)
    margin_x, margin_y = (np.where(extent < THICK, 0.04, -PLANE) for extent in (high - low, depth))
    dx, dy = np.ptp(x, 1), np.ptp(y, 1)
    mx, my = x.mean(1), y.mean(1)
    lengthwise = (dx > 3 * dy) & (my > -depth - margin_y) & (my < margin_y)
    over = np.minimum(x.max(1), high) - np.maximum(x.min(1), low)
    along = np.where(lengthwise, np.maximum(over, 0) / (high - low), 0).max(1, initial=0)
    crosswise = (dy > 3 * dx) & (mx > low - margin_x) & (mx < high + margin_x)
    over = np.minimum(y.max(1), 0) - np.maximum(y.min(1), -depth)
    return np.asarray(np.maximum(along, np.where(crosswise, np.maximum(over, 0) / depth, 0).max(1, initial=0)))


GRID = (np.arange(8) + 0.5) / 8


def _raster(
    origin: np.ndarray, u: np.ndarray, size: np.ndarray, free: Grid
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shares of each side that are an edge and that are open (K, 4), and the share of the inside not passed (K,)."""
    n = np.stack([-u[:, 1], u[:, 0]], 1)

    def look(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        points = origin[:, None] + x[..., None] * u[:, None] - y[..., None] * n[:, None]
        return np.asarray(free.at(points, outside=False), bool)

    w, h = size[:, :1], size[:, 1:]
    inner = np.stack(np.meshgrid(GRID, GRID), -1).reshape(-1, 2)
    m = 0.08
    solid = 1 - look(m + (w - 2 * m) * inner[:, 0], m + (h - 2 * m) * inner[:, 1]).mean(1)
    edge, open_ = np.zeros((len(size), 4)), np.zeros((len(size), 4))
    x, y = m + (w - 2 * m) * GRID, m + (h - 2 * m) * GRID

    def along(side: int, off: float) -> np.ndarray:
        """What lies at a distance before a side (negative: behind it)."""
        places = ((x, 0 * x - off), (0 * y + w + off, y), (x, 0 * x + h + off), (0 * y - off, y))
        return look(*places[side])

    for s in range(4):
        near, far = along(s, STRIP[0]), along(s, STRIP[1])
        open_[:, s] = (near.mean(1) + far.mean(1)) / 2
        edge[:, s] = (far & ~along(s, -STRIP[1])).mean(1)
    return edge, open_, solid
