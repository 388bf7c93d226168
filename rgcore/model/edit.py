"""What every edit is: a frozen value with ``apply``, checked against the types of its fields."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

import msgspec
import numpy as np

from rgcore.errors import EditError
from rgcore.model.fields import refusal
from rgcore.model.records import Backdrop, Gateway, Line, MapObject, Note, Region, RGMap, replace, rounded

E = TypeVar("E", bound="Edit")
T = TypeVar("T")


class Edit(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag=True, tag_field="edit"):
    """Base of all edits: subclasses give ``change`` and ``title``."""

    def apply(self, map: RGMap, base: RGMap | None = None) -> RGMap:
        """The map with this edit. Raises EditError with a sentence if a value is out of bounds or the map refuses.

        ``base``: the automatic map that ``map`` was folded from; only an edit that goes back to it looks there.
        """
        return self.checked().change_from(map, map if base is None else base)

    def change_from(self, map: RGMap, base: RGMap) -> RGMap:
        """``change``, for the few edits that look at the automatic map as well."""
        return self.change(map)

    def checked(self: E) -> E:
        """The same edit as the journal will give it back: values within their bounds, numbers as the document has them.

        Raises EditError.
        """
        try:
            plain = _rounded(msgspec.to_builtins(self, enc_hook=_plain))
            return msgspec.json.decode(msgspec.json.encode(plain), type=type(self))
        except msgspec.ValidationError as e:
            raise refusal(type(self), e) from e
        except (TypeError, ValueError) as e:
            raise EditError(f"{type(self).__name__}: {e}") from e

    def change(self, map: RGMap) -> RGMap:
        raise NotImplementedError

    def title(self, map: RGMap) -> str:
        """What the edit does, for the undo button; ``map`` is the one that it is applied to."""
        raise NotImplementedError


def _plain(value: Any) -> Any:
    """NumPy values in an edit that a script made, as plain ones."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is no value for an edit")


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return rounded(value)
    if isinstance(value, dict):
        return {k: _rounded(v) for k, v in value.items()}
    return [_rounded(v) for v in value] if isinstance(value, list | tuple) else value


def the_line(map: RGMap, id: str) -> Line:
    """A line of the map. Raises EditError, as its siblings do, if it is not there."""
    return _the(map.lines, "line", id)


def the_region(map: RGMap, id: str) -> Region:
    return _the(map.regions, "region", id)


def the_gateway(map: RGMap, id: str) -> Gateway:
    return _the(map.gateways, "gateway", id)


def the_object(map: RGMap, id: str) -> MapObject:
    return _the(map.objects, "object", id)


def the_note(map: RGMap, id: str) -> Note:
    return _the(map.notes, "note", id)


def the_backdrop(map: RGMap, id: str) -> Backdrop:
    return _the(map.backdrops, "floor plan", id)


def must_be_new(map: RGMap, kind: str, id: str) -> None:
    """Raises EditError if the map has an item of a kind with this id already."""
    if id in getattr(map, kind):
        raise EditError(f"there is already {'an' if kind == 'objects' else 'a'} {kind[:-1]} {id} in this map")


def put(map: RGMap, kind: str, item: Any) -> RGMap:
    """The map with one item set; the same map if it is so already."""
    items = getattr(map, kind)
    return map if items.get(item.id) == item else replace(map, **{kind: {**items, item.id: item}})


def put_all(map: RGMap, kind: str, items: Iterable[Any]) -> RGMap:
    """The map with several items of a kind set; those that are so already stay the same objects."""
    old = getattr(map, kind)
    new = {item.id: item for item in items if old.get(item.id) != item}
    return replace(map, **{kind: {**old, **new}}) if new else map


def drop(map: RGMap, kind: str, *ids: str) -> RGMap:
    """The map without items of a kind. A note on one stays at its place; what was ignored about one is forgotten."""
    map = replace(map, **{kind: {k: v for k, v in getattr(map, kind).items() if k not in ids}})
    map = put_all(map, "notes", (replace(n, item=None) for n in map.notes.values() if n.item in ids))
    if any(set(ids) & set(f.items) for f in map.ignored.values()):
        map = replace(map, ignored={k: f for k, f in map.ignored.items() if not set(ids) & set(f.items)})
    return map


def kind_of(map: RGMap, id: str) -> str:
    """The table of the map that holds an item: "lines", "regions", ... Raises EditError if none does."""
    for kind in ("regions", "gateways", "lines", "objects", "notes"):
        if id in getattr(map, kind):
            return kind
    raise EditError(f"there is no {id} in this map")


def several(ids: Sequence[str], word: str) -> str:
    """Some ids in a title: all of up to three, else their number."""
    if len(ids) > 3:
        return f"{len(ids)} {word}"
    return " and ".join(filter(None, [", ".join(ids[:-1]), ids[-1]]))


def _the(items: dict[str, T], word: str, id: str) -> T:
    try:
        return items[id]
    except KeyError:
        raise EditError(f"there is no {word} {id} in this map") from None
