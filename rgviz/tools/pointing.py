"""Tools that point at things: by a rectangle, at a place of a line, at the regions that something joins."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rgcore.errors import EditError
from rgcore.model import draft
from rgcore.model.edits import AddNote, AssignGateway, AssignLines, Edit, SplitLine
from rgcore.model.fields import new_id
from rgcore.model.records import Point, RGMap
from rgviz.picking import Item, line_near, region_at
from rgviz.selecting import Items, added, ids_of, still_there, without
from rgviz.tools.tool import NEAR, Hand, Handle, Question, Sketch, Stroke, Tool, Turn, changed


@dataclass(frozen=True)
class Rectangle(Tool):
    """Base: a rectangle from where the button went down to where it is let go."""

    corner: Point | None = None
    tip: Point | None = None

    def press(self, map_: RGMap, hand: Hand) -> Turn:
        return Turn(changed(self, corner=hand.at, tip=hand.at))

    def move(self, map_: RGMap, hand: Hand) -> Turn:
        return Turn(changed(self, tip=hand.at) if self.corner is not None else self)

    def release(self, map_: RGMap, hand: Hand) -> Turn:
        corner = self.corner
        idle = changed(self, corner=None, tip=None)
        if corner is None or min(abs(hand.at[0] - corner[0]), abs(hand.at[1] - corner[1])) <= 3 * hand.pixel:
            return Turn(idle)
        low, high = np.sort([corner, hand.at], axis=0).tolist()
        return idle.drawn(map_, hand, (low[0], low[1]), (high[0], high[1]))

    def drawn(self, map_: RGMap, hand: Hand, low: Point, high: Point) -> Turn:
        raise NotImplementedError

    def cancel(self) -> Tool | None:
        return None if self.corner is None else changed(self, corner=None, tip=None)

    def sketch(self, map_: RGMap) -> Sketch:
        if self.corner is None or self.tip is None:
            return self.shown()
        (x0, y0), (x1, y1) = self.corner, self.tip
        ring = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
        size = f"{abs(x1 - x0):.2f} x {abs(y1 - y0):.2f} m"
        return self.shown(strokes=(Stroke(ring, "good", closed=True, fill=True),), note=self.says(map_) or size)

    def says(self, map_: RGMap) -> str:
        return ""


@dataclass(frozen=True)
class SelectTool(Rectangle):
    """What lies in a rectangle is selected: things of the kind that is selected already, else lines."""

    items: Items = ()

    title = "Select by rectangle"
    hint = "Drag a rectangle. Shift adds to the selection, Ctrl takes away."
    edits = False

    def drawn(self, map_: RGMap, hand: Hand, low: Point, high: Point) -> Turn:
        kind = self.items[0].kind if self.items else None
        inside = tuple(i for i in in_rectangle(map_, low, high) if kind in (None, i.kind))
        if hand.free:
            chosen = without(self.items, inside)
        else:
            chosen = added(self.items if hand.straight else (), inside)
        return Turn(changed(self, items=chosen), select=chosen)

    def selected(self, items: Items) -> Tool:
        return changed(self, items=items)


@dataclass(frozen=True)
class BoxTool(Rectangle):
    """A box over what stands in a rectangle, ``height`` [m] high."""

    height: float = 1.0

    title = "Make an object by rectangle"
    hint = "Drag a rectangle around its lines, or where an object stands that no line shows."

    def drawn(self, map_: RGMap, hand: Hand, low: Point, high: Point) -> Turn:
        edit = draft.object_in_rectangle(map_, low, high, self.height)
        return Turn(self, edit, (Item("object", edit.id),))

    def says(self, map_: RGMap) -> str:
        assert self.corner is not None
        assert self.tip is not None
        count = len(draft.lines_in_rectangle(map_, self.corner, self.tip))
        return f"{count} line{'s' * (count != 1)}" if count else ""


@dataclass(frozen=True)
class CutLineTool(Tool):
    """A line is cut in two where one clicks on it."""

    tip: Point | None = None
    pixel: float = 0.01

    title = "Split a line"
    hint = "Click the line where it shall be two."

    def move(self, map_: RGMap, hand: Hand) -> Turn:
        return Turn(changed(self, tip=hand.at, pixel=hand.pixel))

    def press(self, map_: RGMap, hand: Hand) -> Turn:
        line = line_near(map_, hand.at, 1.5 * NEAR * hand.pixel)
        if line is None:
            raise EditError("there is no line under the pointer")
        edit = SplitLine(line=line, at=hand.at, id=new_id(map_, "lines")).checked()
        return Turn(changed(self, tip=hand.at), edit, (Item("line", line), Item("line", edit.id)))

    def sketch(self, map_: RGMap) -> Sketch:
        line = line_near(map_, self.tip, 1.5 * NEAR * self.pixel) if self.tip else None
        if line is None or self.tip is None:
            return self.shown()
        v = map_.lines[line]
        d = np.subtract(v.end, v.start)
        s = float(np.clip(np.subtract(self.tip, v.start) @ d / max(d @ d, 1e-12), 0, 1))
        x, y = v.start + s * d
        at, long = (float(x), float(y)), math.dist(v.start, v.end)
        parts = (Stroke((v.start, at), "good"), Stroke((at, v.end), "other"))
        words = f"{line}: {s * long:.2f} + {(1 - s) * long:.2f} m"
        return self.shown(strokes=parts, marks=(Handle("cut", *at, "snap"),), note=words)


@dataclass(frozen=True)
class AssignTool(Tool):
    """Gateways join, or lines bound, the regions that are clicked."""

    items: Items
    regions: tuple[str, ...] = ()
    most: int = 2

    title = "Let it join other regions"
    hint = "Click the regions that it joins or bounds. Enter ends."

    @classmethod
    def for_(cls, map_: RGMap, items: Items) -> AssignTool:
        """For the selected lines, or the one selected gateway. Raises EditError for others."""
        if items and items[0].kind == "line":
            return cls(items, most=1)
        if len(items) != 1 or items[0].kind != "gateway":
            raise EditError("Select a gateway, or lines, first.")
        return cls(items, most=4 if map_.gateways[items[0].id].class_.startswith("junction_") else 2)

    def press(self, map_: RGMap, hand: Hand) -> Turn:
        region = region_at(map_, np.array(hand.at))
        if region is None:
            raise EditError("there is no region under the pointer")
        regions = tuple(r for r in self.regions if r != region) if region in self.regions else (*self.regions, region)
        tool = changed(self, regions=regions)
        return tool.finish(map_) if len(regions) == self.most else Turn(tool)

    def finish(self, map_: RGMap) -> Turn:
        if not self.regions:
            return Turn(None)
        edit: Edit
        if self.items[0].kind == "line":
            edit = AssignLines(lines=ids_of(self.items, "line"), region=self.regions[0])
        else:
            edit = AssignGateway(gateway=self.items[0].id, regions=self.regions)
        return Turn(None, edit)

    def cancel(self) -> Tool | None:
        return changed(self, regions=()) if self.regions else None

    def kept(self, map_: RGMap) -> Tool | None:
        items = still_there(map_, self.items)
        return (
            changed(self, items=items, regions=tuple(r for r in self.regions if r in map_.regions)) if items else None
        )

    def sketch(self, map_: RGMap) -> Sketch:
        strokes = tuple(Stroke(map_.regions[r].boundary, "good", closed=True, fill=True) for r in self.regions)
        return self.shown(strokes=strokes)


@dataclass(frozen=True)
class NoteTool(Tool):
    """A note where one clicks."""

    title = "Add a note"
    hint = "Click the place that it is about."

    def press(self, map_: RGMap, hand: Hand) -> Turn:
        at = hand.at

        def made(m: RGMap, text: str) -> Edit:
            return AddNote(id=new_id(m, "notes"), text=text, place=at).checked()

        return Turn(None, ask=Question("Note", at, made))


def in_rectangle(map_: RGMap, low: Point, high: Point) -> Items:
    """What lies wholly in an upright rectangle of the floor, kind by kind: lines first, regions last."""

    def inside(points: tuple[Point, ...]) -> bool:
        return all(low[0] <= x <= high[0] and low[1] <= y <= high[1] for x, y in points)

    out = [Item("line", id) for id in draft.lines_in_rectangle(map_, low, high)]
    out += [Item("gateway", g.id) for g in map_.gateways.values() if inside(g.posts)]
    out += [Item("object", o.id) for o in map_.objects.values() if inside((o.center[:2],))]
    out += [Item("note", n.id) for n in map_.notes.values() if inside((n.place,))]
    return (*out, *(Item("region", r.id) for r in map_.regions.values() if inside(r.boundary)))
