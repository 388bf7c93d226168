"""An edit for another map: ids by what was recognised, places with the scans near them, by the types of its fields.

A new edit needs no code here (``fields.py``).
"""

from __future__ import annotations

import types
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import msgspec
import numpy as np
from msgspec import Meta

from rgcore.geometry import se2
from rgcore.model.drift import Drift
from rgcore.model.edits import AnyEdit, Edit, Several
from rgcore.model.fields import is_human_id
from rgcore.model.records import Point, rounded


class Stale(Exception):
    """What an edit is about is not to be found in the new map."""


class _Pieces(tuple[str, ...]):
    """What one id of a list became: several."""


def carry(
    edit: AnyEdit, ids: Mapping[str, str], drift: Drift, pieces: Mapping[str, tuple[str, ...]] | None = None
) -> AnyEdit:
    """The same edit for the new map. Raises Stale if one of its ids has no counterpart, or its places none.

    pieces  the lines that a line fell into in the new map: where an edit names a list of lines, all of them
    """
    if isinstance(edit, Several):
        return Several(name=edit.name, edits=tuple(carry(e, ids, drift, pieces) for e in edit.edits))  # type: ignore[misc]
    hints = get_type_hints(type(edit), include_extras=True)
    places = places_of(edit)
    if places and not drift.known:
        raise Stale("the two runs share no scan")
    carrier = _Carrier(ids, drift, drift.turn(np.mean(places, 0)) if places else 0.0, pieces or {})
    names = [f.name for f in msgspec.structs.fields(edit)]
    return type(edit)(**{name: _walk(getattr(edit, name), hints[name], carrier) for name in names})


@dataclass(frozen=True)
class _Carrier:
    """What becomes of a single value, by what its type says of it."""

    ids: Mapping[str, str]
    drift: Drift
    turn: float
    pieces: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def __call__(self, extra: dict[str, str], value: Any, listed: bool = False) -> Any:
        if "id" in extra:
            if value in self.ids:
                return self.ids[value]
            if is_human_id(value):
                return value
            if listed and extra["id"] == "lines" and value in self.pieces:
                return _Pieces(self.pieces[value])
            if not self.drift.known:
                raise Stale("the two runs share no scan")
            raise Stale(f"{value} has no clear counterpart in the new map")
        if extra.get("place") == "angle":
            return value if abs(self.turn) < 1e-6 else rounded(float(se2.wrap(value + self.turn)))
        if extra.get("place") in ("point", "point3"):
            moved = self.drift.points(np.array(value[:2]))[0]
            if np.abs(moved - value[:2]).max() < 1e-6:
                return value
            return (rounded(moved[0]), rounded(moved[1]), *value[2:])
        return value


def _walk(value: Any, hint: Any, act: Callable[..., Any], listed: bool = False) -> Any:
    """``value`` with ``act`` done to every part whose type carries an ``extra``."""
    if value is None:
        return None
    extra = _extra(hint)
    if extra:
        return act(extra, value, listed)
    inner = _inner(hint, value)
    if inner is None:
        return value
    out: list[Any] = []
    for v, h in zip(value, inner, strict=True):
        new = _walk(v, h, act, listed=True)
        out += [n for n in new if n not in out] if isinstance(new, _Pieces) else [new]
    return tuple(out)


def _found(what: str, value: Any, hint: Any) -> Iterator[Any]:
    """All parts of ``value`` whose type says that they are such a place (point also means point3)."""
    extra = _extra(hint)
    if value is not None and extra.get("place", "").startswith(what):
        yield value
    elif value is not None and not extra:
        for v, h in zip(value, inner, strict=True) if (inner := _inner(hint, value)) is not None else ():
            yield from _found(what, v, h)


def _extra(hint: Any) -> dict[str, str]:
    if get_origin(hint) in (Union, types.UnionType):
        return next((e for a in get_args(hint) if (e := _extra(a))), {})
    if get_origin(hint) is Annotated:
        return next((a.extra for a in get_args(hint) if isinstance(a, Meta) and a.extra), {})
    return {}


def _inner(hint: Any, value: Any) -> list[Any] | None:
    """The types of the parts of a tuple; None for anything else."""
    if get_origin(hint) in (Union, types.UnionType):
        return next((i for a in get_args(hint) if (i := _inner(a, value)) is not None), None)
    if get_origin(hint) is Annotated:
        return _inner(get_args(hint)[0], value)
    if get_origin(hint) is not tuple or not isinstance(value, tuple):
        return None
    args = get_args(hint)
    return [args[0]] * len(value) if len(args) == 2 and args[1] is Ellipsis else list(args)


def ids_of(edit: Edit) -> set[str]:
    """Ids of the things that an edit is about (not of those that it makes)."""
    if isinstance(edit, Several):
        return {id for e in edit.edits for id in ids_of(e)}
    found: set[str] = set()

    def note(extra: dict[str, str], value: Any, listed: bool = False) -> Any:
        if "id" in extra:
            found.add(value)
        return value

    hints = get_type_hints(type(edit), include_extras=True)
    for f in msgspec.structs.fields(edit):
        _walk(getattr(edit, f.name), hints[f.name], note)
    return found


def places_of(edit: Edit) -> list[Point]:
    """The places (x, y) [m] that an edit names."""
    if isinstance(edit, Several):
        return [p for e in edit.edits for p in places_of(e)]
    hints = get_type_hints(type(edit), include_extras=True)
    names = [f.name for f in msgspec.structs.fields(edit)]
    return [p[:2] for name in names for p in _found("point", getattr(edit, name), hints[name])]
