"""No tool in the hand: the selected gateway, line or note shows handles, and dragging one moves it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rgcore.model.edits import Edit, MoveGateway, MoveGatewayPoints, MoveLine, MoveNote
from rgcore.model.follow import Follow
from rgcore.model.records import Point, RGMap, rounded
from rgviz.picking import Item
from rgviz.selecting import Items, still_there
from rgviz.tools.tool import (
    Hand,
    Handle,
    Ink,
    Shape,
    Sketch,
    Stroke,
    Tool,
    Turn,
    changed,
    metres,
    short,
    straightened,
    tried,
)


@dataclass(frozen=True)
class Adjust(Tool):
    """What is selected, ready to be dragged. Presses beside the handles are the picture's."""

    items: Items = ()
    grab = False

    def selected(self, items: Items) -> Tool:
        return Adjust(items)

    def press(self, map_: RGMap, hand: Hand) -> Turn:
        one = _single(map_, self.items)
        if one is None or hand.handle not in {h.id for h in handles(map_, one)}:
            return Turn(self)
        return Turn(Drag(item=one, handle=hand.handle or "", tip=place(map_, one, hand.handle or ""), start=hand.at))

    def sketch(self, map_: RGMap) -> Sketch:
        one = _single(map_, self.items)
        return self.shown(handles=handles(map_, one) if one is not None else ())


@dataclass(frozen=True)
class Drag(Tool):
    """A handle in the hand: ``tip`` is where it would come to stand; letting go makes the edit."""

    item: Item
    handle: str
    tip: Point
    start: Point
    moved: bool = False

    def move(self, map_: RGMap, hand: Hand) -> Turn:
        moved = self.moved or math.dist(hand.at, self.start) > 3 * hand.pixel
        return Turn(changed(self, tip=self._pointed(map_, hand), moved=moved) if moved else self)

    def release(self, map_: RGMap, hand: Hand) -> Turn:
        turn = self.move(map_, hand)
        dragged = turn.tool
        assert isinstance(dragged, Drag)
        return Turn(None, dragged.edit(map_) if dragged.moved else None)

    def cancel(self) -> Tool | None:
        return None

    def kept(self, map_: RGMap) -> Tool | None:
        there = still_there(map_, (self.item,)) and self.handle in {h.id for h in handles(map_, self.item)}
        return self if there else None

    def edit(self, map_: RGMap) -> Edit:
        """The edit that puts the handle where it is held."""
        kind, id = self.item.kind, self.item.id
        if kind == "note":
            return MoveNote(note=id, place=self.tip)
        if kind == "line":
            return MoveLine(
                line=id, **dict(zip(("start", "end"), _moved_line(map_, id, self.handle, self.tip), strict=True))
            )
        what, number = self.handle[0], int(self.handle[1:])
        g = map_.gateways[id]
        if what == "p":
            posts = (self.tip, g.posts[1]) if number == 0 else (g.posts[0], self.tip)
            return MoveGateway(gateway=id, posts=posts)
        if what == "c":
            return MoveGatewayPoints(gateway=id, crossing_points=_with(g.crossing_points, number, self.tip))
        return MoveGatewayPoints(gateway=id, gateway_points=_with(g.gateway_points, number, self.tip))

    def sketch(self, map_: RGMap) -> Sketch:
        edit, why = tried(map_, lambda: self.edit(map_))
        marks = (Handle("tip", *self.tip, _shape(self.item, self.handle), chosen=True),)
        ink: Ink = "bad" if edit is None else "good"
        strokes: tuple[Stroke, ...] = ()
        note = why
        if isinstance(edit, MoveLine):
            strokes, note = (Stroke((edit.start, edit.end), ink),), metres(edit.start, edit.end)
        elif isinstance(edit, MoveGateway):
            follow = Follow(map_.gateways[self.item.id].posts, edit.posts)
            points = follow.points(map_.gateways[self.item.id].gateway_points)
            strokes, note = (Stroke(edit.posts, ink), Stroke(tuple(points), "other")), metres(*edit.posts)
        return Sketch(strokes=strokes, marks=marks, note=note, refused=edit is None, grab=True)

    def _pointed(self, map_: RGMap, hand: Hand) -> Point:
        fixed = _other_end(map_, self.item, self.handle)
        if hand.straight and fixed is not None:
            return straightened(fixed, hand.at, _axes(map_, self.item))
        if self.handle in ("p0", "p1", "start", "end"):
            return hand.caught(map_, self.item.id)
        return short(hand.at)


def handles(map_: RGMap, item: Item) -> tuple[Handle, ...]:
    """The handles of an item: posts, crossing- and gateway-points of a gateway, ends of a line, place of a note."""
    if item.kind == "gateway":
        g = map_.gateways[item.id]
        groups: tuple[tuple[str, Shape, tuple[Point, ...]], ...] = (
            ("e", "entry", g.gateway_points),
            ("c", "crossing", g.crossing_points),
            ("p", "post", g.posts),
        )
        return tuple(Handle(f"{key}{n}", *p, shape) for key, shape, points in groups for n, p in enumerate(points))
    if item.kind == "line":
        v = map_.lines[item.id]
        long = math.dist(v.start, v.end)
        x, y = (v.start[0] + v.end[0]) / 2, (v.start[1] + v.end[1]) / 2
        return (
            Handle("whole", x, y, "side", room=long),
            Handle("start", *v.start, "end"),
            Handle("end", *v.end, "end"),
        )
    if item.kind == "note":
        return (Handle("place", *map_.notes[item.id].place, "note"),)
    return ()


def place(map_: RGMap, item: Item, handle: str) -> Point:
    """Where a handle stands. KeyError if the item has no such handle."""
    return {h.id: (h.x, h.y) for h in handles(map_, item)}[handle]


def _single(map_: RGMap, items: Items) -> Item | None:
    return items[0] if len(items) == 1 and still_there(map_, items) else None


def _shape(item: Item, handle: str) -> Shape:
    shapes: dict[str, Shape] = {"p": "post", "c": "crossing", "e": "entry"}
    if item.kind == "gateway":
        return shapes[handle[0]]
    return "note" if item.kind == "note" else "end"


def _moved_line(map_: RGMap, id: str, handle: str, tip: Point) -> tuple[Point, Point]:
    """The ends of a line one of which is held, or that is held by its middle: pushed aside, never along itself."""
    v = map_.lines[id]
    if handle != "whole":
        return (tip, v.end) if handle == "start" else (v.start, tip)
    length = max(math.dist(v.start, v.end), 1e-9)
    nx, ny = -(v.end[1] - v.start[1]) / length, (v.end[0] - v.start[0]) / length
    by = (tip[0] - v.start[0]) * nx + (tip[1] - v.start[1]) * ny
    return (
        (rounded(v.start[0] + by * nx), rounded(v.start[1] + by * ny)),
        (rounded(v.end[0] + by * nx), rounded(v.end[1] + by * ny)),
    )


def _other_end(map_: RGMap, item: Item, handle: str) -> Point | None:
    if item.kind == "line" and handle in ("start", "end"):
        return map_.lines[item.id].end if handle == "start" else map_.lines[item.id].start
    if item.kind == "gateway" and handle[0] == "p":
        return map_.gateways[item.id].posts[1 - int(handle[1:])]
    return None


def _axes(map_: RGMap, item: Item) -> tuple[float, ...]:
    homes = map_.lines[item.id].regions if item.kind == "line" else map_.gateways[item.id].regions
    return tuple(a for r in homes[:1] if r in map_.regions for a in map_.regions[r].axes)


def _with(points: tuple[Point, ...], number: int, point: Point) -> tuple[Point, ...]:
    return tuple(point if n == number else p for n, p in enumerate(points))
