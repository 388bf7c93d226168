"""Edits of lines: walls that the laser did not see, walls that are none, and walls in pieces."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rgcore.errors import EditError
from rgcore.model.edit import Edit, drop, must_be_new, put, put_all, several, the_line, the_region
from rgcore.model.fields import Angle, LineId, LineIds, NewLineId, Place, RegionId
from rgcore.model.ground import region_before
from rgcore.model.records import Line, Point, RGMap, replace, rounded

LEAST_LINE = 0.05
"""m: a shorter line has no direction"""
COLLINEAR = 0.15
"""m: lines that stray no farther from their common straight line can be joined"""
ASKEW = math.radians(30)
"""rad: a line that is turned by more becomes another line"""


class DrawLine(Edit, frozen=True):
    """There is a wall; free space lies to the left of start -> end. Without ``region``, it bounds the one there."""

    id: NewLineId
    start: Place
    end: Place
    region: RegionId | None = None

    def change(self, map: RGMap) -> RGMap:
        must_be_new(map, "lines", self.id)
        _must_be_long("the new line", self.start, self.end)
        home = region_before(map, self.start, self.end) if self.region is None else the_region(map, self.region).id
        return put(map, "lines", Line(id=self.id, start=self.start, end=self.end, regions=(home,) if home else ()))

    def title(self, map: RGMap) -> str:
        return "draw a wall"


class MoveLine(Edit, frozen=True):
    """A line begins and ends here."""

    line: LineId
    start: Place
    end: Place

    def change(self, map: RGMap) -> RGMap:
        old = the_line(map, self.line)
        _must_be_long(old.id, self.start, self.end)
        return put(map, "lines", replace(old, start=self.start, end=self.end, deviation=None))

    def title(self, map: RGMap) -> str:
        return f"move {self.line}"


class DeleteLines(Edit, frozen=True):
    """There are no such lines; objects over them stay, without them."""

    lines: LineIds

    def change(self, map: RGMap) -> RGMap:
        for id in self.lines:
            the_line(map, id)
        return drop(_exchanged(map, dict.fromkeys(self.lines, ())), "lines", *self.lines)

    def title(self, map: RGMap) -> str:
        return f"delete {several(self.lines, 'lines')}"


class JoinLines(Edit, frozen=True):
    """Lines of one wall are one line, the first of them, on the straight line that fits all; free space stays left."""

    lines: LineIds

    def change(self, map: RGMap) -> RGMap:
        if len(set(self.lines)) < max(2, len(self.lines)):
            raise EditError("two lines or more are joined, each named once")
        old = [the_line(map, id) for id in self.lines]
        start, end = _common(old)
        first = replace(
            old[0],
            start=start,
            end=end,
            regions=tuple(dict.fromkeys(r for v in old for r in v.regions)),
            support=sum(v.support for v in old),
            residual=_residual(old),
            deviation=None,
        )
        map = _exchanged(map, dict.fromkeys(self.lines, (first.id,)))
        return drop(put(map, "lines", first), "lines", *self.lines[1:])

    def title(self, map: RGMap) -> str:
        return f"join {several(self.lines, 'lines')}"


class SplitLine(Edit, frozen=True):
    """A line is two that meet at the place nearest to this one; the longer part stays the line."""

    line: LineId
    at: Place
    id: NewLineId

    def change(self, map: RGMap) -> RGMap:
        old = the_line(map, self.line)
        must_be_new(map, "lines", self.id)
        a, b = np.array(old.start), np.array(old.end)
        share = float((np.array(self.at) - a) @ (b - a) / max((b - a) @ (b - a), 1e-12))
        length = math.dist(old.start, old.end)
        if not LEAST_LINE <= share * length <= length - LEAST_LINE:
            raise EditError(f"{old.id} cannot be split there: a part would be shorter than 5 cm")
        at = _point(a + share * (b - a))
        parts = [(old.start, at, share), (at, old.end, 1 - share)]
        kept, new = (
            replace(old, start=s, end=e, support=round(old.support * part), deviation=None)
            for s, e, part in sorted(parts, key=lambda p: -p[2])
        )
        map = put_all(map, "lines", [kept, replace(new, id=self.id)])
        return _exchanged(map, {old.id: (old.id, self.id)})

    def title(self, map: RGMap) -> str:
        return f"split {self.line}"


class AlignLines(Edit, frozen=True):
    """Lines stand along this direction or across it, each turned about its middle; by at most 30 degrees."""

    lines: LineIds
    direction: Angle

    def change(self, map: RGMap) -> RGMap:
        return put_all(map, "lines", [self._turned(the_line(map, id)) for id in self.lines])

    def _turned(self, line: Line) -> Line:
        a, b = np.array(line.start), np.array(line.end)
        off = math.remainder(self.direction - math.atan2(*(b - a)[::-1]), math.pi / 2)
        if abs(off) > ASKEW:
            raise EditError(f"{line.id} stands {math.degrees(abs(off)):.0f}° off that direction; 30° is the most")
        if abs(off) < 1e-6:
            return line
        c, s = math.cos(off), math.sin(off)
        half = np.array([[c, -s], [s, c]]) @ (b - a) / 2
        return replace(line, start=_point((a + b) / 2 - half), end=_point((a + b) / 2 + half), deviation=None)

    def title(self, map: RGMap) -> str:
        return f"align {several(self.lines, 'lines')}"


class MarkClutter(Edit, frozen=True):
    """Lines are things in the room and no walls, or walls after all."""

    lines: LineIds
    clutter: bool = True

    def change(self, map: RGMap) -> RGMap:
        return put_all(map, "lines", [replace(the_line(map, id), clutter=self.clutter) for id in self.lines])

    def title(self, map: RGMap) -> str:
        return f"mark {several(self.lines, 'lines')} as {'clutter' if self.clutter else 'wall'}"


class AssignLines(Edit, frozen=True):
    """Lines bound this region, or none."""

    lines: LineIds
    region: RegionId | None = None

    def change(self, map: RGMap) -> RGMap:
        home = () if self.region is None else (the_region(map, self.region).id,)
        old = [the_line(map, id) for id in self.lines]
        others = [tuple(r for r in v.regions[1:] if r not in home) if home else () for v in old]
        return put_all(map, "lines", [replace(v, regions=(*home, *rest)) for v, rest in zip(old, others, strict=True)])

    def title(self, map: RGMap) -> str:
        return f"let {several(self.lines, 'lines')} bound {self.region or 'no region'}"


def _common(lines: Sequence[Line]) -> tuple[Point, Point]:
    """Ends on the total-least-squares line of all, weighted by length. Raises EditError if they are not collinear."""
    ends = np.array([(v.start, v.end) for v in lines])
    d = ends[:, 1] - ends[:, 0]
    length = np.hypot(*d.T)
    weight = np.repeat(length, 2) / (2 * length.sum())
    points = ends.reshape(-1, 2)
    center = weight @ points
    _, axes = np.linalg.eigh((points - center).T @ ((points - center) * weight[:, None]))
    u = axes[:, 1] * (1.0 if axes[:, 1] @ d[0] >= 0 else -1.0)
    for line, along in zip(lines, d @ u, strict=True):
        if along <= 0:
            raise EditError(f"{line.id} looks the other way; only lines of one side of a wall can be joined")
    off = np.abs((points - center) @ np.array([-u[1], u[0]]))
    if (worst := float(off.max())) > COLLINEAR:
        name = lines[int(off.argmax()) // 2].id
        raise EditError(f"{name} lies {worst:.2f} m beside the others; only lines of one wall can be joined")
    s = (points - center) @ u
    return _point(center + s.min() * u), _point(center + s.max() * u)


def _residual(lines: Sequence[Line]) -> float | None:
    known = [(v.residual, v.support) for v in lines if v.residual is not None and v.support]
    if not known:
        return None
    return rounded(math.sqrt(sum(n * r * r for r, n in known) / sum(n for _, n in known)))


def _exchanged(map: RGMap, by: dict[str, tuple[str, ...]]) -> RGMap:
    """The map whose objects name other lines instead of some."""
    over = [o for o in map.objects.values() if any(id in by for id in o.lines)]
    new = [replace(o, lines=tuple(dict.fromkeys(n for id in o.lines for n in by.get(id, (id,))))) for o in over]
    return put_all(map, "objects", new)


def _must_be_long(what: str, start: Point, end: Point) -> None:
    if math.dist(start, end) < LEAST_LINE:
        raise EditError(f"{what} would be shorter than 5 cm")


def _point(p: np.ndarray) -> Point:
    return rounded(p[0]), rounded(p[1])
