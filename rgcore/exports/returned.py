"""Edits out of a drawing that was edited elsewhere: what differs from the map, item by item.

The edits are tried on a copy of the map in the order in which they can stand one after the other; what the map refuses
is told with its reason. Nothing is changed here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from rgcore.errors import EditError
from rgcore.exports.drawn import Drawn, drawn, same_place
from rgcore.exports.flat import printable
from rgcore.geometry.polygons import min_rectangle
from rgcore.model import edits as e
from rgcore.model.draft import add_gateway
from rgcore.model.fields import new_id
from rgcore.model.records import Point, RGMap, rounded

SAME = 0.002
"""m: what moved by less did so by the rounding of a format"""
_HEIGHT = 1.0
"""m, of an object that comes without one"""


@dataclass(frozen=True)
class Returned:
    """``edits`` in their order; ``refused``: what cannot be taken over, a sentence each."""

    edits: tuple[e.AnyEdit, ...]
    refused: tuple[str, ...]


def edits_from(drawing: Sequence[Drawn], map: RGMap) -> Returned:
    """The edits that make the map what the drawing shows.

    An item that is not in the drawing is deleted, if the drawing has others of its kind; what has no id is added.
    """
    here = {d.id: d for d in drawn(map)}
    there = {d.id: d for d in drawing if d.id is not None}
    kinds = {d.kind for d in drawing}
    refused = [f"{id} is not in this map: it was deleted since, or is another map's" for id in there if id not in here]
    wanted: list[tuple[int, e.AnyEdit]] = []
    for id, item in here.items():
        if id not in there and item.kind in kinds:
            wanted.append((0, _delete(item)))
        elif id in there:
            wanted += [(_ORDER[item.kind], edit) for edit in _changed(map, item, there[id])]
    trial, taken = map, list[e.AnyEdit]()
    steps = [edit for _, edit in sorted(wanted, key=lambda w: w[0])]
    for edit in steps:
        trial = _try(trial, edit, taken, refused)
    for item in sorted((d for d in drawing if d.id is None), key=lambda d: _ORDER[d.kind]):
        try:
            trial = _try(trial, _added(trial, item), taken, refused)
        except EditError as why:
            refused.append(f"a new {item.kind} at ({item.points[0, 0]:.2f}, {item.points[0, 1]:.2f}): {why}")
    return Returned(tuple(taken), tuple(refused))


_ORDER = {"region": 1, "gateway": 2, "line": 3, "object": 4, "note": 5}


def _try(map: RGMap, edit: e.AnyEdit, taken: list[e.AnyEdit], refused: list[str]) -> RGMap:
    try:
        after = edit.apply(map)
    except EditError as why:
        if not (type(edit).__name__.startswith("Delete") and "there is no" in str(why)):  # gone with another already
            refused.append(str(why))
        return map
    if after is not map:
        taken.append(edit)
    return after


def _delete(item: Drawn) -> e.AnyEdit:
    assert item.id is not None
    if item.kind == "region":
        return e.DeleteRegion(region=item.id)
    if item.kind == "gateway":
        return e.DeleteGateway(gateway=item.id)
    if item.kind == "line":
        return e.DeleteLines(lines=(item.id,))
    return e.DeleteObject(object=item.id) if item.kind == "object" else e.DeleteNote(note=item.id)


def _changed(map: RGMap, old: Drawn, new: Drawn) -> Iterator[e.AnyEdit]:
    """What a person did to an item."""
    assert old.id is not None
    id, moved = old.id, not same_place(old, new, SAME)
    named = new.name is not None and printable(new.name).strip() != printable(old.name or "").strip()
    classed = new.class_ is not None and bool(new.class_) and new.class_ != printable(old.class_ or "")
    name = (new.name or "").strip()
    if old.kind == "region":
        if moved:
            yield e.ReshapeRegion(region=id, boundary=_corners(new.points), holes=_holes(new))
        if classed:
            yield e.ClassifyRegion(region=id, class_=str(new.class_))
        if named and name:
            yield e.RenameRegion(region=id, name=name)
    elif old.kind == "gateway":
        if moved:
            yield e.MoveGateway(gateway=id, posts=_two(new.points))
        if classed:
            yield e.ClassifyGateway(gateway=id, class_=str(new.class_))
        if named:
            yield e.RenameGateway(gateway=id, name=name)
    elif old.kind == "line" and moved:
        start, end = _two(new.points)
        yield e.MoveLine(line=id, start=start, end=end)
    elif old.kind == "object":
        if moved:
            high = map.objects[id].size[2]
            center, size, yaw = _box(new, high, map.objects[id].center[2] - high / 2)
            yield e.MoveObject(object=id, center=center, size=size, yaw=yaw)
        if named:
            yield e.LabelObject(object=id, label=name)
    elif old.kind == "note":
        if moved:
            yield e.MoveNote(note=id, place=_corners(new.points)[0])
        if new.text is not None and printable(new.text) != printable(old.text or ""):
            yield e.WriteNote(note=id, text=new.text)


def _added(map: RGMap, item: Drawn) -> e.AnyEdit:
    """The edit that makes something drawn elsewhere. Raises EditError where it cannot be."""
    name = printable(item.name or "").strip()
    if item.kind == "region":
        class_, holes = item.class_ or "TOMA", _holes(item)
        boundary = _corners(item.points)
        return e.AddRegion(id=new_id(map, "regions"), boundary=boundary, holes=holes, name=name, class_=class_)
    if item.kind == "gateway":
        return msgspec.structs.replace(add_gateway(map, _two(item.points)), name=name)
    if item.kind == "line":
        start, end = _two(item.points)
        return e.DrawLine(id=new_id(map, "lines"), start=start, end=end)
    if item.kind == "object":
        center, size, yaw = _box(item, _HEIGHT, 0.0)
        return e.AddObject(id=new_id(map, "objects"), center=center, size=size, yaw=yaw, label=name)
    return e.AddNote(id=new_id(map, "notes"), text=item.text or name, place=_corners(item.points)[0])


def _box(
    item: Drawn, height: float, floor: float
) -> tuple[tuple[float, float, float], tuple[float, float, float], float]:
    """Center, size and yaw of the box over a footprint: along its first side, as boxes are drawn."""
    corners = item.points
    if len(corners) != 4:
        (x, y), (length, width), yaw = min_rectangle(corners)
    else:
        along, across = corners[1] - corners[0], corners[2] - corners[1]
        (x, y), yaw = corners.mean(0), float(np.arctan2(along[1], along[0]))
        length, width = float(np.hypot(*along)), float(np.hypot(*across))
    high = item.height or height
    low = floor if item.floor is None else item.floor
    return (
        (rounded(x), rounded(y), rounded(low + high / 2)),
        (rounded(length), rounded(width), rounded(high)),
        rounded(yaw),
    )


def _corners(points: np.ndarray) -> tuple[Point, ...]:
    return tuple((rounded(x), rounded(y)) for x, y in points)


def _holes(item: Drawn) -> tuple[tuple[Point, ...], ...]:
    return tuple(_corners(r) for r in item.rings[1:])


def _two(points: np.ndarray) -> tuple[Point, Point]:
    first, *_, last = _corners(points)
    return first, last
