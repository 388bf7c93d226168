"""Tools turn what a hand does into edits; plain functions, tested without a browser."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from rgcore.errors import EditError
from rgcore.model.edits import (
    ClassifyGateway,
    ClassifyRegion,
    DeleteGateway,
    DeleteObject,
    Edit,
    LabelObject,
    MoveObject,
    RenameGateway,
    RenameRegion,
)
from rgcore.model.records import MapObject, RGMap, replace
from rgviz.picking import Item


def classify(item: Item, class_: str) -> Edit:
    """The edit that gives a region or gateway a class. Raises EditError for other things."""
    class_ = " ".join(class_.split())
    if item.kind == "region":
        return ClassifyRegion(region=item.id, class_=class_)
    if item.kind == "gateway":
        return ClassifyGateway(gateway=item.id, class_=class_)
    raise EditError("only regions and gateways have a class; select one first")


def rename(item: Item, name: str) -> Edit:
    """The edit that names a region, gateway or object. Raises EditError for lines."""
    name = " ".join(name.split())
    if item.kind == "region":
        return RenameRegion(region=item.id, name=name)
    if item.kind == "gateway":
        return RenameGateway(gateway=item.id, name=name)
    if item.kind == "object":
        return LabelObject(object=item.id, label=name)
    raise EditError("a line has no name")


def delete(item: Item) -> Edit:
    """The edit that deletes a gateway or an object. Raises EditError for other things."""
    if item.kind == "gateway":
        return DeleteGateway(gateway=item.id)
    if item.kind == "object":
        return DeleteObject(object=item.id)
    raise EditError(f"a {item.kind} cannot be deleted yet; select a gateway or an object")


def dragged(box: MapObject, position: tuple[float, ...], wxyz: tuple[float, ...]) -> MapObject:
    """The box as the gizmo holds it: moved on the floor and turned about the vertical."""
    w, x, y, z = wxyz
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    center = (_round(position[0]), _round(position[1]), box.center[2])
    return replace(box, center=center, yaw=_round(yaw))


def quaternion(yaw: float) -> tuple[float, float, float, float]:
    """wxyz of a turn about the vertical."""
    return math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)


def resized(box: MapObject, field: str, value: float) -> MapObject:
    """The box with its ``length``, ``width``, ``height`` [m] or ``turn`` [degrees] changed; it stays on its floor."""
    if not math.isfinite(value):
        raise EditError(f"the {field} of an object must be a number")
    if field == "turn":
        return replace(box, yaw=_round(math.remainder(math.radians(value), 2 * math.pi)))
    if value <= 0:
        raise EditError(f"the {field} of an object must be above 0 m")
    x, y, z = box.center
    along, across, high = box.size
    floor = z - high / 2
    size = {"length": (value, across, high), "width": (along, value, high), "height": (along, across, value)}[field]
    return replace(box, size=size, center=(x, y, _round(floor + size[2] / 2)))


def move(box: MapObject) -> Edit:
    """The edit that puts an object where this box stands."""
    return MoveObject(object=box.id, center=box.center, size=box.size, yaw=box.yaw)


def still_there(map_: RGMap, items: tuple[Item, ...]) -> tuple[Item, ...]:
    """Those of the items that the map still has: a selection lets go of what was deleted."""
    tables: dict[str, Mapping[str, object]]
    tables = {"region": map_.regions, "gateway": map_.gateways, "line": map_.lines, "object": map_.objects}
    return tuple(i for i in items if i.id in tables[i.kind])


def added(selection: tuple[Item, ...], item: Item) -> tuple[Item, ...]:
    """The selection with an item added, or taken away if it is in; only things of one kind are selected together."""
    if any(i.kind != item.kind for i in selection):
        return (item,)
    return tuple(i for i in selection if i != item) if item in selection else (*selection, item)


def extent_of(map_: RGMap, items: tuple[Item, ...]) -> np.ndarray | None:
    """(2, 2) lower left and upper right [m] of some items, with a margin; None of none."""
    points: list[np.ndarray] = []
    for i in still_there(map_, items):
        if i.kind == "region":
            points.append(np.asarray(map_.regions[i.id].boundary))
        elif i.kind == "gateway":
            points.append(np.asarray(map_.gateways[i.id].posts))
        elif i.kind == "line":
            points.append(np.asarray([map_.lines[i.id].start, map_.lines[i.id].end]))
        else:
            o = map_.objects[i.id]
            reach = 0.5 * math.hypot(*o.size[:2])
            points.append(np.array([o.center[:2]]) + np.array([[-reach, -reach], [reach, reach]]))
    if not points:
        return None
    all_ = np.concatenate(points)
    low, high = all_.min(0), all_.max(0)
    pad = max(0.75, 0.15 * float((high - low).max()))
    return np.array([low - pad, high + pad])


def _round(value: float) -> float:
    return round(float(value), 4)
