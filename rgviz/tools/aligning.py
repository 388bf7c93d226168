"""A floor plan brought to its place: a point of it, then where that belongs; twice."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec

from rgcore.model.backdrops import corners
from rgcore.model.edits_backdrops import aligned
from rgcore.model.records import Point, RGMap
from rgviz.tools.tool import Hand, Handle, Sketch, Stroke, Tool, Turn, changed, metres, short, tried

SAYS = (
    "Click a point of the plan, such as a corner of the building.",
    "Click where that point belongs; it catches the ends of walls.",
    "Click a second point of the plan, far from the first. Enter: shift only.",
    "Click where the second point belongs.",
)


@dataclass(frozen=True)
class AlignTool(Tool):
    """``points``: on the plan, where it belongs, on the plan, where it belongs. After two, Enter only shifts it."""

    backdrop: str = ""
    points: tuple[Point, ...] = ()
    tip: Point | None = None

    title = "Align the floor plan"

    def press(self, map_: RGMap, hand: Hand) -> Turn:
        after = changed(self, points=(*self.points, self._at(map_, hand)), tip=None)
        return after.finish(map_) if len(after.points) == 4 else Turn(after)

    def move(self, map_: RGMap, hand: Hand) -> Turn:
        return Turn(changed(self, tip=self._at(map_, hand)))

    def finish(self, map_: RGMap) -> Turn:
        """With one pair the plan is shifted, with two it is turned and scaled as well."""
        pairs = _pairs(self.points)
        return Turn(None, aligned(map_, self.backdrop, pairs)) if pairs else Turn(self)

    def back(self, map_: RGMap) -> Turn | None:
        return Turn(changed(self, points=self.points[:-1]))

    def cancel(self) -> Tool | None:
        return AlignTool(self.backdrop) if self.points else None

    def kept(self, map_: RGMap) -> Tool | None:
        return self if self.backdrop in map_.backdrops else None

    def sketch(self, map_: RGMap) -> Sketch:
        """Arrows from the plan to where it belongs, and where the sheet would lie."""
        pairs = _pairs(self.points if self.tip is None else (*self.points, self.tip))
        strokes = [Stroke(pair, "good", text=metres(*pair)) for pair in pairs]
        wrong = ""
        if pairs:
            edit, wrong = tried(map_, lambda: aligned(map_, self.backdrop, pairs))
            if edit is not None:
                sheet = corners(edit.apply(map_).backdrops[self.backdrop]).tolist()
                strokes.append(Stroke(tuple(short((x, y)) for x, y in sheet), "other", closed=True))
        marks = tuple(Handle(f"m{i}", x, y, "corner" if i % 2 else "end") for i, (x, y) in enumerate(self.points))
        shown = self.shown(strokes=tuple(strokes), marks=marks, note=wrong, refused=bool(wrong))
        return msgspec.structs.replace(shown, hint=SAYS[min(len(self.points), 3)])

    def _at(self, map_: RGMap, hand: Hand) -> Point:
        """A point of the plan is where it is; where it belongs may be the end of a wall."""
        return hand.caught(map_) if len(self.points) % 2 else short(hand.at)


def _pairs(points: tuple[Point, ...]) -> list[tuple[Point, Point]]:
    return list(zip(points[::2], points[1::2], strict=False))
