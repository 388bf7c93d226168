"""The tool that reshapes a region: corners are dragged, added, taken away, sides pushed. Each drag is one edit."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

from rgcore.errors import EditError
from rgcore.geometry import cutting
from rgcore.model.edits import ReshapeRegion
from rgcore.model.records import Point, RGMap, rounded
from rgviz.tools.tool import NEAR, Hand, Handle, Sketch, Stroke, Tool, Turn, changed, shoelace, short

Ring = tuple[Point, ...]
SHOWS = 4.0
"""A corner has room where it stands out by a quarter of what else must fit a handle (``Handle.room``): some 11 px."""


@dataclass(frozen=True)
class ReshapeTool(Tool):
    """The outline of a region in the hand. ``chosen``: the corner pressed last; ``drag``: what is held, with the rings
    as they would be."""

    region: str
    chosen: str | None = None
    drag: str | None = None
    rings: tuple[Ring, ...] = ()
    start: Point = (0.0, 0.0)

    title = "Reshape a region"
    hint = "Drag a corner, push a side; Ctrl+click adds a corner or takes one away."

    def press(self, map_: RGMap, hand: Hand) -> Turn:
        rings = _rings(map_, self.region)
        if hand.free:
            return self._added_or_gone(map_, rings, hand)
        if hand.handle is None or hand.handle not in {h.id for h in self._handles(map_)}:
            return Turn(changed(self, chosen=None))
        return Turn(changed(self, chosen=hand.handle, drag=hand.handle, rings=rings, start=hand.at))

    def move(self, map_: RGMap, hand: Hand) -> Turn:
        if self.drag is None or (
            math.dist(hand.at, self.start) <= 3 * hand.pixel and self.rings == _rings(map_, self.region)
        ):
            return Turn(self)
        what, n, k = _named(self.drag)
        rings = _rings(map_, self.region)
        ring = rings[n]
        if what == "c":
            tip = _right_angled(ring, k, hand.at) if hand.straight else hand.caught(map_)
            moved = _put(ring, {k: tip})
        else:
            moved = _pushed(ring, k, hand, map_)
        return Turn(changed(self, rings=_with(rings, n, moved)))

    def release(self, map_: RGMap, hand: Hand) -> Turn:
        after = self.move(map_, hand).tool
        assert isinstance(after, ReshapeTool)
        idle = changed(after, drag=None, rings=())
        if self.drag is None or after.rings == _rings(map_, self.region):
            return Turn(idle)
        return Turn(idle, self._edit(after.rings))

    def finish(self, map_: RGMap) -> Turn:
        return Turn(None)

    def back(self, map_: RGMap) -> Turn | None:
        if self.chosen is None or self.chosen[0] != "c":
            return Turn(self)
        _, n, k = _named(self.chosen)
        return self._without(_rings(map_, self.region), n, k)

    def cancel(self) -> Tool | None:
        return changed(self, drag=None, rings=()) if self.drag is not None else None

    def kept(self, map_: RGMap) -> Tool | None:
        if self.region not in map_.regions:
            return None
        names = {h.id for h in self._handles(map_)}
        return self if {self.chosen, self.drag} <= {None, *names} else changed(self, chosen=None, drag=None, rings=())

    def sketch(self, map_: RGMap) -> Sketch:
        if self.drag is None:
            outlines = tuple(Stroke(r, "draft", closed=True) for r in _rings(map_, self.region))
            return self.shown(strokes=outlines, handles=self._handles(map_))
        reason = cutting.fault(self.rings[0], self.rings[1:])
        ink = "good" if reason is None else "bad"
        strokes = tuple(Stroke(r, ink, closed=True, fill=n == 0) for n, r in enumerate(self.rings))  # type: ignore[arg-type]
        _, n, k = _named(self.drag)
        ring = self.rings[n]
        ends = (ring[k], ring[(k + 1) % len(ring)]) if self.drag[0] == "s" else (ring[k],)
        marks = tuple(Handle(f"held{i}", *p, "corner", chosen=True) for i, p in enumerate(ends))
        area = shoelace(self.rings[0]) - sum(map(shoelace, self.rings[1:]))
        note = f"{area:.1f} m²" if reason is None else f"the outline {reason}"
        return self.shown(strokes=strokes, marks=marks, note=note, refused=reason is not None)

    def _handles(self, map_: RGMap) -> tuple[Handle, ...]:
        out = []
        for n, ring in enumerate(_rings(map_, self.region)):
            for k, (a, b) in enumerate(zip(ring, (*ring[1:], ring[0]), strict=True)):
                middle = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
                out.append(Handle(f"s{n}.{k}", *middle, "side", room=math.dist(a, b)))
        for n, ring in enumerate(_rings(map_, self.region)):
            weights = _weights(ring)
            out += [
                Handle(f"c{n}.{k}", *p, "corner", room=SHOWS * weights[k], chosen=self.chosen == f"c{n}.{k}")
                for k, p in enumerate(ring)
            ]
        return tuple(out)

    def _added_or_gone(self, map_: RGMap, rings: tuple[Ring, ...], hand: Hand) -> Turn:
        corners = [(math.dist(p, hand.at), n, k) for n, ring in enumerate(rings) for k, p in enumerate(ring)]
        far, n, k = min(corners)
        if far <= NEAR * hand.pixel:
            return self._without(rings, n, k)
        feet = [(*_foot(r[k], r[(k + 1) % len(r)], hand.at), n, k) for n, r in enumerate(rings) for k in range(len(r))]
        far, foot, n, k = min(feet)
        if far > NEAR * hand.pixel:
            raise EditError("Ctrl+click on the outline to add a corner, on a corner to take it away")
        ring = rings[n]
        return Turn(changed(self, chosen=None), self._edit(_with(rings, n, (*ring[: k + 1], foot, *ring[k + 1 :]))))

    def _without(self, rings: tuple[Ring, ...], n: int, k: int) -> Turn:
        if len(rings[n]) <= 3:
            raise EditError("an outline has three corners at least")
        ring = tuple(p for i, p in enumerate(rings[n]) if i != k)
        return Turn(changed(self, chosen=None), self._edit(_with(rings, n, ring)))

    def _edit(self, rings: tuple[Ring, ...]) -> ReshapeRegion:
        return ReshapeRegion(region=self.region, boundary=rings[0], holes=rings[1:]).checked()


def _rings(map_: RGMap, region: str) -> tuple[Ring, ...]:
    """The outline, then the holes."""
    r = map_.regions[region]
    return (r.boundary, *r.holes)


def _named(handle: str) -> tuple[str, int, int]:
    """ "c0.12" is corner 12 of ring 0, "s0.12" the side that begins there."""
    ring, _, corner = handle[1:].partition(".")
    return handle[0], int(ring), int(corner)


@functools.lru_cache(maxsize=256)
def _weights(ring: Ring) -> tuple[float, ...]:
    """How far the outline goes astray without each corner [m], little ones taken away first (Visvalingam and Whyatt,
    1993, with heights for areas); 0 for the last four, which always show."""
    left = list(range(len(ring)))

    def height(i: int) -> float:
        before, here, after = (ring[left[j % len(left)]] for j in (i - 1, i, i + 1))
        return max(_foot(before, after, here)[0], 1e-6)

    heights, out, most = [height(i) for i in range(len(left))], [0.0] * len(ring), 0.0
    while len(left) > 4:
        at = min(range(len(left)), key=heights.__getitem__)
        most = max(most, heights.pop(at))
        out[left.pop(at)] = most
        for i in {(at - 1) % len(left), at % len(left)}:
            heights[i] = height(i)
    return tuple(out)


def _with(rings: tuple[Ring, ...], n: int, ring: Ring) -> tuple[Ring, ...]:
    return tuple(ring if i == n else r for i, r in enumerate(rings))


def _put(ring: Ring, points: dict[int, Point]) -> Ring:
    return tuple(points.get(i, p) for i, p in enumerate(ring))


def _right_angled(ring: Ring, k: int, at: Point) -> Point:
    """Onto the nearer of the directions in which the corner's neighbours see it: its sides keep theirs."""

    def onto(a: Point, b: Point) -> tuple[float, Point]:
        d = math.dist(a, b)
        s = ((at[0] - a[0]) * (b[0] - a[0]) + (at[1] - a[1]) * (b[1] - a[1])) / max(d * d, 1e-12)
        foot = short((a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])))
        return math.dist(foot, at), foot

    return min(onto(ring[k - 1], ring[k]), onto(ring[(k + 1) % len(ring)], ring[k]))[1]


def _pushed(ring: Ring, k: int, hand: Hand, map_: RGMap) -> Ring:
    """The ring with a side moved along its normal to where the hand is, or onto the end of a wall there."""
    i, j = k, (k + 1) % len(ring)
    a, b = ring[i], ring[j]
    length = max(math.dist(a, b), 1e-9)
    nx, ny = -(b[1] - a[1]) / length, (b[0] - a[0]) / length
    tip = hand.caught(map_)
    by = (tip[0] - a[0]) * nx + (tip[1] - a[1]) * ny
    return _put(ring, {m: (rounded(p[0] + by * nx), rounded(p[1] + by * ny)) for m, p in ((i, a), (j, b))})


def _foot(a: Point, b: Point, p: Point) -> tuple[float, Point]:
    """How far a place is from a side, and the nearest point of that."""
    d2 = max((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2, 1e-12)
    s = min(max(((p[0] - a[0]) * (b[0] - a[0]) + (p[1] - a[1]) * (b[1] - a[1])) / d2, 0.0), 1.0)
    foot = short((a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])))
    return math.dist(foot, p), foot
