"""Search in a map: ``kind:region class:TOMA accuracy>0.2 edited:yes name~lab`` gives the ids of what fits all terms.

A term is a field, a sign and a value: ``:`` is (any of ``a,b``), ``~`` contains, ``< <= > >=`` compares a number. A
bare word is looked for in ids, names, labels and classes; a minus before a term turns it; quotes keep a value with
spaces together. An item without the field fits no term about it.
"""

from __future__ import annotations

import math
import operator
import re
import shlex
from collections.abc import Callable
from difflib import get_close_matches
from typing import Any

from rgcore.errors import QueryError
from rgcore.model.ground import shape_of
from rgcore.model.records import Gateway, Line, MapObject, Note, Region, RGMap

KINDS = {"region": "regions", "gateway": "gateways", "object": "objects", "line": "lines", "note": "notes"}
_COMPARE: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_TERM = re.compile(r"(?P<minus>-?)(?P<field>[a-z]+)(?P<sign><=|>=|[:~<>])(?P<value>.*)", re.DOTALL)

Test = Callable[[RGMap, Any], bool]


def find(map: RGMap, text: str) -> list[str]:
    """Ids of the items that fit all terms, kind by kind in the order of the map; all items for an empty text.

    Raises QueryError with a sentence that names the term.
    """
    try:
        words = shlex.split(text)
    except ValueError as e:
        raise QueryError(f"a quote is not closed in: {text}") from e
    tests = [_test(word) for word in words]
    items = (item for kind in KINDS.values() for item in getattr(map, kind).values())
    return [item.id for item in items if all(test(map, item) for test in tests)]


def _test(word: str) -> Test:
    term = _TERM.fullmatch(word)
    if term is None:
        return _bare(word)
    field, sign, value = term["field"], term["sign"], term["value"]
    if field not in FIELDS:
        near = get_close_matches(field, FIELDS, 1)
        hint = f"; did you mean {near[0]}?" if near else f"; there are {', '.join(sorted(FIELDS))}"
        raise QueryError(f"{word}: there is no field {field}{hint}")
    if not value:
        raise QueryError(f"{word}: a value is missing after {sign}")
    of, says = FIELDS[field]
    if says == "number":
        fits = _number(word, sign, value)
    elif sign in _COMPARE:
        raise QueryError(f"{word}: {field} is no number; use {field}:{value} or {field}~{value}")
    else:
        fits = _words(word, field, sign, value, says)
    turned = bool(term["minus"])

    def test(map: RGMap, item: Any) -> bool:
        have = of(map, item)
        return (have is not None and fits(have)) != turned

    return test


def _number(word: str, sign: str, value: str) -> Callable[[Any], bool]:
    try:
        wanted = float(value)
    except ValueError:
        raise QueryError(f"{word}: {value} is no number") from None
    if sign == "~" or not math.isfinite(wanted):
        raise QueryError(f"{word}: compare a number by : < <= > or >=")
    if sign == ":":
        return lambda have: math.isclose(have, wanted, abs_tol=1e-9)
    compare = _COMPARE[sign]
    return lambda have: compare(have, wanted)


def _words(word: str, field: str, sign: str, value: str, allowed: str) -> Callable[[Any], bool]:
    wanted = [v.casefold() for v in value.split(",") if v]
    choices = allowed.split()
    for v in wanted:
        if choices and sign == ":" and v not in choices:
            raise QueryError(f"{word}: {field} is one of {', '.join(choices)}")
    if sign == "~":
        return lambda have: any(v in h.casefold() for h in _all(have) for v in wanted)
    return lambda have: any(h.casefold() in wanted for h in _all(have))


def _bare(word: str) -> Test:
    turned, wanted = word.startswith("-") and len(word) > 1, word.lstrip("-").casefold()

    def test(map: RGMap, item: Any) -> bool:
        texts = (item.id, _name(map, item) or "", getattr(item, "class_", ""))
        return any(wanted in t.casefold() for t in texts) != turned

    return test


def _all(have: Any) -> tuple[str, ...]:
    return have if isinstance(have, tuple) else (have,)


def _kind(map: RGMap, item: Any) -> str:
    types = {"region": Region, "gateway": Gateway, "object": MapObject, "line": Line, "note": Note}
    return next(kind for kind, type_ in types.items() if isinstance(item, type_))


def _name(map: RGMap, item: Any) -> str | None:
    if isinstance(item, MapObject):
        return item.label
    return item.text if isinstance(item, Note) else getattr(item, "name", None)


def _regions(map: RGMap, item: Any) -> tuple[str, ...]:
    if isinstance(item, MapObject):
        return (item.region,) if item.region else ()
    return (item.id,) if isinstance(item, Region) else getattr(item, "regions", ())


def _region(map: RGMap, item: Any) -> tuple[str, ...]:
    ids = _regions(map, item)
    return (*ids, *(map.regions[r].name for r in ids if r in map.regions))


def _length(map: RGMap, item: Any) -> float | None:
    if isinstance(item, Line):
        return math.dist(item.start, item.end)
    return item.size[0] if isinstance(item, MapObject) else None


def _width(map: RGMap, item: Any) -> float | None:
    if isinstance(item, Gateway):
        return item.width
    if isinstance(item, Region):
        return min(item.box.size)
    return item.size[1] if isinstance(item, MapObject) else None


def _score(map: RGMap, item: Any) -> float | None:
    return item.class_scores.get(item.class_) if isinstance(item, Region) else None


def _area(map: RGMap, item: Any) -> float | None:
    return float(shape_of(item).area) if isinstance(item, Region) else None


def _noted(map: RGMap, item: Any) -> str:
    return _yes(any(n.item == item.id for n in map.notes.values()))


def _yes(value: bool | None) -> Any:
    return None if value is None else "yes" if value else "no"


def _plain(name: str) -> Callable[[RGMap, Any], Any]:
    return lambda map, item: getattr(item, name, None)


def _flag(name: str) -> Callable[[RGMap, Any], Any]:
    return lambda map, item: _yes(getattr(item, name, None))


FIELDS: dict[str, tuple[Callable[[RGMap, Any], Any], str]] = {
    "kind": (_kind, " ".join(KINDS)),
    "id": (_plain("id"), ""),
    "name": (_name, ""),
    "label": (_name, ""),
    "class": (_plain("class_"), ""),
    "region": (_region, ""),
    "source": (lambda map, item: item.provenance.source, "auto human edited"),
    "edited": (lambda map, item: _yes(item.provenance.source != "auto"), "yes no"),
    "state": (lambda map, item: "confirmed" if item.provenance.confirmed else "unconfirmed", "confirmed unconfirmed"),
    "by": (lambda map, item: item.provenance.by, ""),
    "passed": (_flag("passed"), "yes no"),
    "clutter": (_flag("clutter"), "yes no"),
    "noted": (_noted, "yes no"),
    "accuracy": (_plain("accuracy"), "number"),
    "scans": (_plain("scans"), "number"),
    "score": (_score, "number"),
    "area": (_area, "number"),
    "width": (_width, "number"),
    "length": (_length, "number"),
    "confidence": (_plain("confidence"), "number"),
    "support": (_plain("support"), "number"),
    "residual": (_plain("residual"), "number"),
}
"""Each field: how it is had from an item (None = it has none), and "number", its values, or "" for any text."""
