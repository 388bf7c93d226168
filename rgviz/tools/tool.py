"""What every tool is: a frozen value fed with the hand's doings in map coordinates. No browser here.

A tool answers each doing with a ``Turn``: the tool as it goes on, perhaps an edit to make, perhaps what to select then.
``sketch`` says what the page shows meanwhile: plain shapes, drawn over the picture by ``static/gestures.js``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal

import msgspec

from rgcore.errors import EditError
from rgcore.model import draft
from rgcore.model.edits import Edit
from rgcore.model.records import Point, RGMap, rounded
from rgviz.selecting import Items

NEAR = 9.0
"""px within which a press means a point that is there already"""
SNAP = 12.0
"""px within which a drawn point means the end of a wall; never more than ``draft.SNAP`` metres"""

Ink = Literal["draft", "good", "other", "bad"]
"""How a stroke looks: being drawn, an area or wall as it will be, a second one beside it, what is refused."""
Shape = Literal["post", "crossing", "entry", "corner", "side", "end", "note", "snap"]


@dataclass(frozen=True)
class Hand:
    """Where the hand is.

    at        on the floor, map frame [m]
    pixel     what one pixel of the screen covers there [m]
    handle    the handle that it pressed, if any
    straight  Shift is held: along or across a main axis; free: Ctrl is held: nothing snaps
    """

    at: Point
    pixel: float = 0.01
    handle: str | None = None
    straight: bool = False
    free: bool = False

    @property
    def snap(self) -> float:
        """How far a point may be moved to catch the end of a wall [m]."""
        return 0.0 if self.free else min(draft.SNAP, SNAP * self.pixel)

    def caught(self, map_: RGMap, without: str | None = None) -> Point:
        """Where the hand points to: the end of a wall near it (not of the line ``without``), else the place itself, in
        whole millimetres."""
        if not self.free:
            place = draft.snapped(map_, self.at, self.snap, without)
            if place != self.at:
                return place
        return short(self.at)


class Stroke(msgspec.Struct, frozen=True, omit_defaults=True):
    """A path, or a filled area where ``closed`` and ``fill``; ``text`` stands beside its middle."""

    points: tuple[Point, ...]
    ink: Ink = "draft"
    closed: bool = False
    fill: bool = False
    text: str = ""


class Handle(msgspec.Struct, frozen=True, omit_defaults=True):
    """A mark that can be dragged. ``room`` [m]: it shows only where that is wide enough on the screen to be hit (0:
    always), a corner also near the pointer."""

    id: str
    x: float
    y: float
    shape: Shape
    room: float = 0.0
    chosen: bool = False


class Sketch(msgspec.Struct, frozen=True, omit_defaults=True):
    """What the page draws for a tool, and says: ``title`` and ``hint`` above the picture, ``note`` beside the pointer.

    ``grab``: every press on the picture is the tool's; else only one on a handle. ``marks`` show but cannot be dragged.
    """

    strokes: tuple[Stroke, ...] = ()
    handles: tuple[Handle, ...] = ()
    marks: tuple[Handle, ...] = ()
    title: str = ""
    hint: str = ""
    note: str = ""
    refused: bool = False
    grab: bool = False


@dataclass(frozen=True)
class Turn:
    """What becomes of a doing: the tool that goes on (None: it is put away), an edit, the selection after it.

    ask     a question to the person, whose answer ``then`` makes an edit of
    select  what is selected now; None: as before
    """

    tool: Tool | None
    edit: Edit | None = None
    select: Items | None = None
    ask: Question | None = None


@dataclass(frozen=True)
class Question:
    """A line of text is wanted, at a place of the map."""

    label: str
    at: Point
    then: Callable[[RGMap, str], Edit]


@dataclass(frozen=True)
class Tool:
    """Base: does nothing. A doing gives a turn, or raises EditError with a sentence; the tool stays as it was then."""

    title: ClassVar[str] = ""
    hint: ClassVar[str] = ""
    grab: ClassVar[bool] = True
    edits: ClassVar[bool] = True
    """whether it is for changing the map: not for those who only look"""

    def press(self, map_: RGMap, hand: Hand) -> Turn:
        return Turn(self)

    def move(self, map_: RGMap, hand: Hand) -> Turn:
        return Turn(self)

    def release(self, map_: RGMap, hand: Hand) -> Turn:
        return Turn(self)

    def finish(self, map_: RGMap) -> Turn:
        """Enter."""
        return Turn(self)

    def back(self, map_: RGMap) -> Turn | None:
        """Backspace or Delete; None: the tool has no use for it."""
        return None

    def cancel(self) -> Tool | None:
        """Esc: what is drawn so far goes; the second time, the tool."""
        return None

    def selected(self, items: Items) -> Tool:
        """The tool after the selection is another one."""
        return self

    def kept(self, map_: RGMap) -> Tool | None:
        """The tool in another map; None where what it works on is gone."""
        return self

    def sketch(self, map_: RGMap) -> Sketch:
        return self.shown()

    def shown(self, **what: Any) -> Sketch:
        return Sketch(title=self.title, hint=self.hint, grab=self.grab, **what)


def tried(map_: RGMap, make: Callable[[], Edit]) -> tuple[Edit | None, str]:
    """An edit that the map takes, or None and the sentence of the refusal."""
    try:
        edit = make()
        edit.apply(map_)
    except EditError as e:
        return None, str(e)
    return edit, ""


def short(point: Point) -> Point:
    """In whole millimetres: no hand is finer."""
    return rounded(round(point[0], 3)), rounded(round(point[1], 3))


def straightened(a: Point, b: Point, axes: tuple[float, ...]) -> Point:
    """``b`` moved onto the nearest direction from ``a`` along or across one of the axes [rad] (else of the map)."""
    d, far = math.atan2(b[1] - a[1], b[0] - a[0]), math.dist(a, b)
    off = min((math.remainder(d - axis, math.pi / 2) for axis in axes or (0.0,)), key=abs)
    along = far * math.cos(off)
    return short((a[0] + along * math.cos(d - off), a[1] + along * math.sin(d - off)))


def metres(a: Point, b: Point) -> str:
    return f"{math.dist(a, b):.2f} m"


def shoelace(ring: tuple[Point, ...]) -> float:
    """m² within a ring, whichever way it runs."""
    return abs(sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(ring, (*ring[1:], *ring[:1]), strict=True))) / 2


changed = replace
"""A copy of a tool with some fields changed."""
