"""The types of an edit's fields: what a value may be, and how it is carried to another run of the map.

Values come from browsers and scripts, so every type has bounds and says them in words. ``extra`` tells ``rebase.carry`` what
to do with a value: ``{"id": kind}`` is looked up, ``{"new": kind}`` stays, ``{"place": ...}`` moves with the poses near it.
"""

from __future__ import annotations

import re
import secrets
from collections.abc import Iterator
from typing import Annotated, Any, get_args, get_type_hints

import msgspec
from msgspec import Meta

from rgcore.errors import EditError
from rgcore.model.records import RGMap

_PLAIN = r"[^\x00-\x1f\x7f\u2028\u2029\u202a-\u202e\u2066-\u2069]"  # no control characters, no turning of the text's direction
_CLASS = rf"^(?=\S){_PLAIN}*\S$"
_TEXT = rf"^{_PLAIN}*$"

RegionId = Annotated[str, Meta(max_length=40, description="must be the id of a region", extra={"id": "regions"})]
GatewayId = Annotated[str, Meta(max_length=40, description="must be the id of a gateway", extra={"id": "gateways"})]
LineId = Annotated[str, Meta(max_length=40, description="must be the id of a line", extra={"id": "lines"})]
ObjectId = Annotated[str, Meta(max_length=40, description="must be the id of an object", extra={"id": "objects"})]
NewObjectId = Annotated[
    str, Meta(pattern="^ou[0-9a-f]{8}$", description="must be an id like ou3f9c02aa", extra={"new": "objects"})
]

ClassName = Annotated[
    str, Meta(max_length=40, pattern=_CLASS, description="must be a name of 1 to 40 characters on one line")
]
Name = Annotated[
    str, Meta(max_length=80, pattern=_CLASS, description="must be a name of 1 to 80 characters on one line")
]
Text = Annotated[str, Meta(max_length=80, pattern=_TEXT, description="must be at most 80 characters on one line")]

Metre = Annotated[float, Meta(ge=-1e5, le=1e5, description="must hold finite metres, at most 100 km from the origin")]
Extent = Annotated[float, Meta(gt=0, le=1000, description="must hold lengths above 0 and up to 1000 m")]
Angle = Annotated[
    float,
    Meta(ge=-6.2832, le=6.2832, description="must hold an angle in rad within one turn", extra={"place": "angle"}),
]
Place = Annotated[tuple[Metre, Metre], Meta(description="must hold points (x, y)", extra={"place": "point"})]
Place3 = Annotated[tuple[Metre, Metre, Metre], Meta(description="must be a point (x, y, z)", extra={"place": "point3"})]
Size3 = Annotated[tuple[Extent, Extent, Extent], Meta(description="must be three lengths")]

PREFIX = {"lines": "l", "regions": "r", "gateways": "g", "objects": "o"}


def new_id(map: RGMap, kind: str) -> str:
    """An id for a thing that a person makes: prefix, u, 8 random hex digits; not in the map yet."""
    while True:
        id = f"{PREFIX[kind]}u{secrets.token_hex(4)}"
        if id not in getattr(map, kind):
            return id


def is_human_id(id: str) -> bool:
    """Whether an edit made the thing with this id (and not the pipeline)."""
    return re.fullmatch(r"[lrgo]u[0-9a-f]{8}", id) is not None


def metas(hint: Any) -> Iterator[Meta]:
    """All ``Meta`` of a type annotation, outermost first."""
    args = get_args(hint)
    yield from (a for a in args if isinstance(a, Meta))
    for a in args:
        if not isinstance(a, Meta):
            yield from metas(a)


def refusal(type_: type[msgspec.Struct], error: Exception) -> EditError:
    """What msgspec found wrong with a value of ``type_``, as a sentence."""
    reason, _, path = str(error).partition(" - at `$")
    name = re.match(r"\.?([a-z_0-9]*)", path)
    field = name.group(1) if name else ""
    inner = {f.encode_name: f.name for f in msgspec.structs.fields(type_)}.get(field)
    if inner is None:
        return EditError(f"{type_.__name__}: {reason[:1].lower()}{reason[1:]}")
    hint = get_type_hints(type_, include_extras=True)[inner]
    # the innermost description speaks of single values, the outermost of the form of the whole
    descriptions = [m.description for m in metas(hint) if m.description]
    if not descriptions:
        return EditError(f"{type_.__name__}: {field}: {reason[:1].lower()}{reason[1:]}")
    deep = reason.startswith("Expected `float`") or path.count("[") > 0
    return EditError(f"{field} {descriptions[-1 if deep else 0]}")
