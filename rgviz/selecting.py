"""Selections: a tuple of items of one kind, in the order in which they were chosen."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np

from rgcore.model.records import RGMap
from rgviz.picking import KINDS, Item

Items = tuple[Item, ...]


def still_there(map_: RGMap, items: Items) -> Items:
    """Those of the items that the map still has: a selection lets go of what was deleted."""
    return tuple(i for i in items if i.id in table(map_, i))


def table(map_: RGMap, item: Item) -> Mapping[str, object]:
    """The records of an item's kind, by id."""
    found: Mapping[str, object] = getattr(map_, KINDS[item.kind])
    return found


def record(map_: RGMap, item: Item) -> object:
    """The record of an item. KeyError if the map does not have it."""
    return table(map_, item)[item.id]


def toggled(selection: Items, item: Item) -> Items:
    """The selection with an item added, or taken away if it is in; an item of another kind replaces it."""
    if any(i.kind != item.kind for i in selection):
        return (item,)
    return tuple(i for i in selection if i != item) if item in selection else (*selection, item)


def added(selection: Items, items: Items) -> Items:
    """The selection and those of the items that are of its kind; without one, those of the first item's kind."""
    kind = (selection or items)[0].kind if selection or items else None
    return tuple(dict.fromkeys((*selection, *(i for i in items if i.kind == kind))))


def without(selection: Items, items: Items) -> Items:
    gone = set(items)
    return tuple(i for i in selection if i not in gone)


def ids_of(items: Items, kind: str) -> tuple[str, ...]:
    return tuple(i.id for i in items if i.kind == kind)


def of_ids(map_: RGMap, ids: Iterable[str]) -> Items:
    """Items by their ids, as a search gives them; those of the kind that most are of, unknown ids left out."""
    found = [Item(kind, id) for id in ids for kind, name in KINDS.items() if id in getattr(map_, name)]
    kinds = [i.kind for i in found]
    most = max(kinds, key=kinds.count, default=None)
    return tuple(dict.fromkeys(i for i in found if i.kind == most))


def lines_of(map_: RGMap, items: Items) -> Items:
    """All lines of the selected regions; of those that the selected lines, gateways or objects belong to."""
    regions = set(ids_of(items, "region"))
    for i in still_there(map_, items):
        thing = record(map_, i)
        regions |= {*getattr(thing, "regions", ())[:1], *filter(None, [getattr(thing, "region", None)])}
    return tuple(Item("line", v.id) for v in map_.lines.values() if v.regions and v.regions[0] in regions)


def others(map_: RGMap, items: Items) -> Items:
    """All items of the selected kind that are not selected; without a selection, all lines."""
    kind = items[0].kind if items else "line"
    return tuple(i for id in getattr(map_, KINDS[kind]) if (i := Item(kind, id)) not in set(items))


def extent_of(map_: RGMap, items: Items, margin: float = 0.15, least: float = 0.75) -> np.ndarray | None:
    """(2, 2) lower left and upper right [m] of some items, wider by ``margin`` of their size, at ``least`` so many
    metres; None of none."""
    points: list[np.ndarray] = []
    for i in still_there(map_, items):
        if i.kind == "region":
            points.append(np.asarray(map_.regions[i.id].boundary))
        elif i.kind == "gateway":
            points.append(np.asarray(map_.gateways[i.id].posts))
        elif i.kind == "line":
            points.append(np.asarray([map_.lines[i.id].start, map_.lines[i.id].end]))
        elif i.kind == "note":
            points.append(np.asarray([map_.notes[i.id].place]))
        else:
            o = map_.objects[i.id]
            reach = 0.5 * math.hypot(*o.size[:2])
            points.append(np.array([o.center[:2]]) + np.array([[-reach, -reach], [reach, reach]]))
    if not points:
        return None
    all_ = np.concatenate(points)
    low, high = all_.min(0), all_.max(0)
    pad = max(least, margin * float((high - low).max()))
    return np.array([low - pad, high + pad])
