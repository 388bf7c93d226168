"""Tools that draw points one after the other: split a region, draw a wall, a gateway, a region."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from rgcore.errors import EditError
from rgcore.geometry import cutting, polygons
from rgcore.model import draft
from rgcore.model.edits import AddGateway, AddRegion, DrawLine, Edit, SplitRegion
from rgcore.model.fields import new_id
from rgcore.model.gates import sides
from rgcore.model.ground import LEAST_REGION, before_line, region_before, shape_of
from rgcore.model.records import Point, RGMap
from rgviz.picking import Item, Kind, region_at
from rgviz.selecting import Items
from rgviz.tools.tool import (
    NEAR,
    Hand,
    Handle,
    Sketch,
    Stroke,
    Tool,
    Turn,
    changed,
    metres,
    shoelace,
    straightened,
    tried,
)

Ends = tuple[Point, Point]


@dataclass(frozen=True)
class Drawing(Tool):
    """Points are set by clicks, or two of them by one drag. ``points`` stand; ``tip`` is where the hand points to.

    ``snap``: of the last doing [m]; ``pressed``: the button is down since the last point was set.
    """

    points: tuple[Point, ...] = ()
    tip: Point | None = None
    snap: float = draft.SNAP
    pressed: bool = False

    least: ClassVar[int] = 2
    most: ClassVar[int] = 64

    def press(self, map_: RGMap, hand: Hand) -> Turn:
        tip = self._pointed(map_, hand)
        tool = changed(self, tip=tip, snap=hand.snap)
        near = NEAR * hand.pixel
        again = bool(self.points) and math.dist(tip, self.points[-1]) <= near
        if len(self.points) >= self.least and (again or (self.closes and math.dist(hand.at, self.points[0]) <= near)):
            return tool.finish(map_)  # a double click, or a ring that is closed
        return Turn(tool) if again else tool._with(map_, tip, pressed=True)

    def move(self, map_: RGMap, hand: Hand) -> Turn:
        return Turn(changed(self, tip=self._pointed(map_, hand), snap=hand.snap))

    def release(self, map_: RGMap, hand: Hand) -> Turn:
        tip = self._pointed(map_, hand)
        tool = changed(self, tip=tip, pressed=False)
        if self.pressed and len(self.points) == 1 and math.dist(tip, self.points[0]) > 2 * NEAR * hand.pixel:
            after = tool._with(map_, tip)
            if after.edit is None and self.least == 2 and isinstance(after.tool, Drawing):
                return after.tool.finish(map_)
            return after
        return Turn(tool)

    def finish(self, map_: RGMap) -> Turn:
        if not self.points:
            return Turn(self)
        if len(self.points) < self.least:
            raise EditError(f"set {self.least} points or more; {len(self.points)} stand")
        edit = self.edit(map_, self.points)
        return Turn(type(self)(), edit, self.made(edit))

    def back(self, map_: RGMap) -> Turn | None:
        return Turn(changed(self, points=self.points[:-1])) if self.points else None

    def cancel(self) -> Tool | None:
        return type(self)() if self.points else None

    def edit(self, map_: RGMap, points: tuple[Point, ...]) -> Edit:
        raise NotImplementedError

    def made(self, edit: Edit) -> Items | None:
        """What to select after the edit."""
        return None

    @property
    def closes(self) -> bool:
        """Whether the points are a ring."""
        return False

    def axes(self, map_: RGMap) -> tuple[float, ...]:
        home = region_at(map_, np.array(self.points[-1])) if self.points else None
        return map_.regions[home].axes if home else ()

    @property
    def path(self) -> tuple[Point, ...]:
        """The points and the tip."""
        tip = () if self.tip is None or self.tip in self.points[-1:] else (self.tip,)
        return (*self.points, *tip) if self.points else ()

    def _pointed(self, map_: RGMap, hand: Hand) -> Point:
        if hand.straight and self.points:
            return straightened(self.points[-1], hand.at, self.axes(map_))
        return hand.caught(map_)

    def _with(self, map_: RGMap, point: Point, pressed: bool = False) -> Turn:
        tool = changed(self, points=(*self.points, point), pressed=pressed)
        return tool.finish(map_) if len(tool.points) == self.most else Turn(tool)

    def _tip(self, map_: RGMap) -> tuple[Handle, ...]:
        """A ring around the tip where it has caught the end of a wall."""
        return (Handle("tip", *self.tip, "snap"),) if self.tip and draft.is_end(map_, self.tip) else ()


@dataclass(frozen=True)
class SplitTool(Drawing):
    """A line across a region; without a chosen ``region``, across the one that it begins in."""

    region: str | None = None
    gateway: bool = False

    title = "Split a region"
    hint = "Drag a line across it, or click its corners and double-click."

    def finish(self, map_: RGMap) -> Turn:
        turn = super().finish(map_)
        return turn if turn.edit is None else Turn(SplitTool(gateway=self.gateway), turn.edit, turn.select)

    def cancel(self) -> Tool | None:
        return SplitTool(region=self.region, gateway=self.gateway) if self.points else None

    def kept(self, map_: RGMap) -> Tool | None:
        return self if self.region is None or self.region in map_.regions else None

    def edit(self, map_: RGMap, points: tuple[Point, ...]) -> SplitRegion:
        return draft.split_region(map_, self._home(map_, points), points, gateway=self.gateway, snap=self.snap)

    def made(self, edit: Edit) -> Items | None:
        assert isinstance(edit, SplitRegion)
        return (Item("region", edit.id),)

    def _home(self, map_: RGMap, points: tuple[Point, ...]) -> str:
        """The region that most of the drawn line lies in, of the chosen one and those under its ends and middle."""
        if self.region is not None:
            return self.region
        middle = np.mean(points[:2], axis=0)
        homes = [region_at(map_, np.asarray(p)) for p in (middle, *points)]
        home = next((h for h in homes if h is not None), None)
        if home is None:
            raise EditError("there is no region under that line")
        return home

    def sketch(self, map_: RGMap) -> Sketch:
        if len(self.path) < 2:
            return self.shown(marks=self._tip(map_))
        drawn = Stroke(self.path)
        try:
            edit = self.edit(map_, self.path)
            halves, cut = cutting.halve(shape_of(map_.regions[edit.region]), np.array(edit.cut), LEAST_REGION)
        except EditError as e:
            return self.shown(strokes=(drawn,), note=str(e), refused=True)
        if len(halves) != 2:
            note = f"{edit.region} falls into {len(halves)} parts" if len(halves) > 2 else "draw it from wall to wall"
            return self.shown(strokes=(drawn,), note=note, refused=True, marks=self._tip(map_))
        areas = [_area(ring(h), ink) for h, ink in zip(halves, ("good", "other"), strict=True)]
        path = Stroke(tuple((float(x), float(y)) for x, y in cut), "good")
        note = f"{' and '.join(f'{h.area:.1f}' for h in halves)} m²"
        return self.shown(strokes=(*areas, path), note=note, marks=self._tip(map_))


@dataclass(frozen=True)
class EndsTool(Drawing):
    """Something that has two ends; what would be made is shown as the map would take it."""

    kind: ClassVar[Kind]
    most = 2

    def made(self, edit: Edit) -> Items | None:
        return (Item(self.kind, edit.id),)  # type: ignore[attr-defined]

    def sketch(self, map_: RGMap) -> Sketch:
        if len(self.path) < 2:
            return self.shown(marks=self._tip(map_))
        edit, why = tried(map_, lambda: self.edit(map_, self.path))
        if edit is None:
            return self.shown(strokes=(Stroke(self.path, "bad"),), note=why, refused=True)
        ends, across, note = self.preview(map_, edit)
        strokes = (Stroke(ends, "good"), Stroke(across, "other"))
        return self.shown(strokes=strokes, note=note, marks=self._tip(map_))

    def preview(self, map_: RGMap, edit: Any) -> tuple[Ends, Ends, str]:
        """Its ends, a stroke that tells its sides, and what is said of it."""
        raise NotImplementedError


@dataclass(frozen=True)
class WallTool(EndsTool):
    """A wall that the laser did not see."""

    title = "Draw a wall"
    hint = "Drag from end to end, or click both. Shift: along a main axis; Ctrl: no snapping."
    kind = "line"

    def edit(self, map_: RGMap, points: tuple[Point, ...]) -> Edit:
        return draft.draw_wall(map_, points[0], points[1], snap=self.snap)

    def preview(self, map_: RGMap, edit: DrawLine) -> tuple[Ends, Ends, str]:
        a, b = edit.start, edit.end
        middle = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
        home = region_before(map_, a, b)
        name = f" of {_called(map_, home)}" if home else ", bounds no region"
        return (a, b), (middle, before_line(a, b, min(0.4, math.dist(a, b) / 3))), metres(a, b) + name


@dataclass(frozen=True)
class GatewayTool(EndsTool):
    """A gateway between the regions on both sides of its posts."""

    title = "Add a gateway"
    hint = "Click its two posts, or drag from one to the other."
    kind = "gateway"

    def edit(self, map_: RGMap, points: tuple[Point, ...]) -> Edit:
        return draft.add_gateway(map_, (points[0], points[1]), snap=self.snap)

    def preview(self, map_: RGMap, edit: AddGateway) -> tuple[Ends, Ends, str]:
        regions = " and ".join(_called(map_, r) for r in edit.regions)
        return edit.posts, sides(edit.posts), f"{metres(*edit.posts)} {edit.class_} between {regions}"


@dataclass(frozen=True)
class RegionTool(Drawing):
    """A region that the mapper did not find, or a part of others."""

    title = "Add a region"
    hint = "Click its corners, the first one again to close it. Shift: along a main axis."
    least = 3

    def edit(self, map_: RGMap, points: tuple[Point, ...]) -> AddRegion:
        return AddRegion(id=new_id(map_, "regions"), boundary=points).checked()

    def made(self, edit: Edit) -> Items | None:
        return (Item("region", edit.id),)  # type: ignore[attr-defined]

    @property
    def closes(self) -> bool:
        return True

    def sketch(self, map_: RGMap) -> Sketch:
        path, marks = self.path, self._tip(map_)
        if len(path) < 3:
            return self.shown(strokes=(Stroke(path),) if len(path) == 2 else (), marks=marks)
        reason = cutting.fault(path)
        if reason is not None:
            strokes = (Stroke(path, "bad", closed=True),)
            return self.shown(strokes=strokes, note=f"the outline {reason}", refused=True, marks=marks)
        return self.shown(strokes=(_area(path, "good"),), note=f"{shoelace(path):.1f} m²", marks=marks)


def ring(shape: object) -> tuple[Point, ...]:
    """The outer ring of a polygon."""
    outer, _ = polygons.rings(shape, 3)
    return outer


def _area(corners: tuple[Point, ...], ink: str) -> Stroke:
    return Stroke(corners, ink, closed=True, fill=True)  # type: ignore[arg-type]


def _called(map_: RGMap, region: str) -> str:
    name = map_.regions[region].name
    return f"{region} ({name})" if name and name != region else region
