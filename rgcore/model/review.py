"""Edits of the review: what was looked at and found right, what goes back to what the mapper made of it."""

from __future__ import annotations

from typing import Any

from rgcore.errors import EditError
from rgcore.geometry import cutting
from rgcore.model.edit import Edit, kind_of, put, put_all, several
from rgcore.model.fields import AnyId, AnyIds, Code
from rgcore.model.ground import settle, shape_of
from rgcore.model.records import Gateway, Ignored, Line, MapObject, Region, RGMap, replace


class Confirm(Edit, frozen=True):
    """Items were looked at and are right."""

    items: AnyIds

    def change(self, map: RGMap) -> RGMap:
        return _confirmed(map, self.items, True)

    def title(self, map: RGMap) -> str:
        return f"confirm {several(self.items, 'items')}"


class Unconfirm(Edit, frozen=True):
    """Items are still to be checked."""

    items: AnyIds

    def change(self, map: RGMap) -> RGMap:
        return _confirmed(map, self.items, False)

    def title(self, map: RGMap) -> str:
        return f"check {several(self.items, 'items')} again"


class RevertToAutomatic(Edit, frozen=True):
    """An item stands as the mapper made it, also if it was deleted.

    The edit names the item alone and takes its record from the automatic map, which the fold has at hand: an edit with
    a copy of the record would put the walls of the old run into the map of a new one.
    """

    item: AnyId

    def change(self, map: RGMap) -> RGMap:
        return self.change_from(map, map)

    def change_from(self, map: RGMap, base: RGMap) -> RGMap:
        kind = next((k for k in ("regions", "gateways", "lines", "objects") if self.item in getattr(base, k)), None)
        if kind is None:
            kind_of(map, self.item)
            raise EditError(f"{self.item} was made by a person; there is no automatic one to go back to")
        automatic = getattr(base, kind)[self.item]
        now = getattr(map, kind).get(self.item)
        if now is not None and replace(now, provenance=automatic.provenance) == automatic:
            return map
        back = _fitted(map, automatic)
        if now is not None:
            back = replace(back, provenance=replace(now.provenance, confirmed=False))
        after = put(map, kind, back)
        moved = isinstance(back, Region) and (now is None or (now.boundary, now.holes) != (back.boundary, back.holes))
        return _with_own_box(settle(map, after, [back.id]), back) if moved else after

    def title(self, map: RGMap) -> str:
        return f"revert {self.item} to automatic"


class IgnoreFinding(Edit, frozen=True):
    """What the lint found about these items is all right."""

    code: Code
    items: AnyIds

    def change(self, map: RGMap) -> RGMap:
        for id in self.items:
            kind_of(map, id)
        made = Ignored(id=finding_id(self.code, self.items), code=self.code, items=self.items)
        return map if made.id in map.ignored else put(map, "ignored", made)

    def title(self, map: RGMap) -> str:
        return f"ignore {self.code} of {several(self.items, 'items')}"


class HeedFinding(Edit, frozen=True):
    """What the lint finds about these items is told again."""

    code: Code
    items: AnyIds

    def change(self, map: RGMap) -> RGMap:
        id = finding_id(self.code, self.items)
        if id not in map.ignored:
            raise EditError(f"{self.code} of {several(self.items, 'items')} is not ignored")
        return replace(map, ignored={k: v for k, v in map.ignored.items() if k != id})

    def title(self, map: RGMap) -> str:
        return f"heed {self.code} of {several(self.items, 'items')}"


def finding_id(code: str, items: tuple[str, ...]) -> str:
    """What a finding of the lint is known by: its code and the items that it is about."""
    return ":".join((code, *items))


def _confirmed(map: RGMap, items: tuple[str, ...], confirmed: bool) -> RGMap:
    changed: dict[str, list[Any]] = {}
    for id in items:
        kind = kind_of(map, id)
        old = getattr(map, kind)[id]
        changed.setdefault(kind, []).append(replace(old, provenance=replace(old.provenance, confirmed=confirmed)))
    for kind, new in changed.items():
        map = put_all(map, kind, new)
    return map


def _fitted(map: RGMap, item: Any) -> Any:
    """An automatic item as it can stand in a map where other things are gone. Raises EditError if it cannot."""
    if isinstance(item, Region):
        shape = shape_of(item)
        for other in map.regions.values():
            if other.id != item.id and cutting.overlap(shape, shape_of(other)).area > 0.05 * shape.area:
                raise EditError(f"{item.id} would lie over {other.id}; delete or revert that first")
    if isinstance(item, Gateway):
        for id in item.regions:
            if id not in map.regions:
                raise EditError(f"{item.id} joins {id}, which is not in the map; bring that back first")
    if isinstance(item, Line):
        return replace(item, regions=tuple(r for r in item.regions if r in map.regions))
    if isinstance(item, MapObject):
        region = item.region if item.region in map.regions else None
        return replace(item, lines=tuple(v for v in item.lines if v in map.lines), region=region)
    return item


def _with_own_box(map: RGMap, region: Region) -> RGMap:
    """The map with the mapper's own box and axes of a region, not those that follow from its outline."""
    here = map.regions[region.id]
    return put_all(map, "regions", [replace(here, box=region.box, axes=region.axes)])
