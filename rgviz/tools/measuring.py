"""The ruler: distances, angles and areas between clicked places, and what the thing under it measures."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rgcore.model.records import Point, RGMap
from rgviz.picking import line_near
from rgviz.tools.tool import NEAR, Hand, Handle, Sketch, Stroke, Tool, Turn, changed, shoelace


@dataclass(frozen=True)
class Ruler(Tool):
    """``points`` stand, ``tip`` is where the hand points to; ``over`` tells of the gateway or line there."""

    points: tuple[Point, ...] = ()
    tip: Point | None = None
    over: str = ""
    done: bool = False

    title = "Measure"
    hint = "Click from place to place; it catches the ends of walls. Double-click ends, Esc begins anew."
    edits = False

    def press(self, map_: RGMap, hand: Hand) -> Turn:
        at = hand.caught(map_)
        if self.done:
            return Turn(Ruler(points=(at,), tip=at))
        if self.points and math.dist(at, self.points[-1]) <= NEAR * hand.pixel:
            return self.finish(map_)
        return Turn(changed(self, points=(*self.points, at), tip=at))

    def move(self, map_: RGMap, hand: Hand) -> Turn:
        if self.done:
            return Turn(self)
        return Turn(changed(self, tip=hand.caught(map_), over=measured(map_, hand)))

    def finish(self, map_: RGMap) -> Turn:
        return Turn(changed(self, done=bool(self.points), tip=None, over=""))

    def back(self, map_: RGMap) -> Turn | None:
        return Turn(changed(self, points=self.points[:-1], done=False))

    def cancel(self) -> Tool | None:
        return Ruler() if self.points else None

    @property
    def path(self) -> tuple[Point, ...]:
        tip = () if self.tip is None or self.tip in self.points[-1:] else (self.tip,)
        return (*self.points, *tip) if self.points else ()

    def sketch(self, map_: RGMap) -> Sketch:
        path = self.path
        legs = tuple(Stroke((a, b), "good", text=f"{math.dist(a, b):.2f} m") for a, b in pairwise(path))
        marks = tuple(Handle(f"m{i}", x, y, "end") for i, (x, y) in enumerate(self.points))
        return self.shown(strokes=legs, marks=marks, note=readout(path) or self.over)


def readout(path: tuple[Point, ...]) -> str:
    """What was measured, in words: the way, the direction of its last leg, the angle of its last corner, the area."""
    if len(path) < 2:
        return ""
    legs = [math.dist(a, b) for a, b in pairwise(path)]
    (ax, ay), (bx, by) = path[-2:]
    words = [f"{legs[-1]:.2f} m at {math.degrees(math.atan2(by - ay, bx - ax)) % 360:.0f}°"]
    if len(path) > 2:
        words = [f"{sum(legs):.2f} m in all", *words, f"corner {math.degrees(corner(*path[-3:])):.1f}°"]
        words.append(f"area {shoelace(path):.2f} m²")
    return ", ".join(words)


def corner(a: Point, b: Point, c: Point) -> float:
    """The angle at ``b`` between the ways to ``a`` and ``c`` [rad], at most half a turn."""
    one, other = math.atan2(a[1] - b[1], a[0] - b[0]), math.atan2(c[1] - b[1], c[0] - b[0])
    return abs(math.remainder(one - other, math.tau))


def measured(map_: RGMap, hand: Hand) -> str:
    """What the gateway or the line under the hand measures."""
    reach = NEAR * hand.pixel
    for g in map_.gateways.values():
        if _off(g.posts, hand.at) <= reach:
            return f"{g.name or g.id}: {g.width:.2f} m wide"
    near = line_near(map_, hand.at, reach)
    if near is None:
        return ""
    v = map_.lines[near]
    return f"{near}: {math.dist(v.start, v.end):.2f} m long"


def _off(ends: tuple[Point, Point], at: Point) -> float:
    """How far a place is from the stroke between two points [m]."""
    a, d = np.array(ends[0]), np.subtract(ends[1], ends[0])
    t = np.clip((np.subtract(at, a) @ d) / max(float(d @ d), 1e-12), 0, 1)
    return float(np.hypot(*(a + t * d - at)))
