"""The types of an edit's fields: what a value may be, and how it is carried to another run of the map.

Values come from browsers and scripts, so every type has bounds and says them in words. ``extra`` tells ``rebase.carry``
what to do with a value: ``{"id": kind}`` is looked up, ``{"place": ...}`` moves with the poses near it, others stay.
"""

from __future__ import annotations

import re
import secrets
import types
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import msgspec
from msgspec import Meta

from rgcore.errors import EditError
from rgcore.model.records import RGMap

_PLAIN = r"[^\x00-\x1f\x7f\u2028\u2029\u202a-\u202e\u2066-\u2069]"  # no control characters, none that turn the text
_NAME = rf"^(?=\S){_PLAIN}*\S\Z"
_TEXT = rf"^{_PLAIN}*\Z"


def _text(says: str, pattern: str, longest: int) -> Meta:
    return Meta(max_length=longest, pattern=pattern, description=says)


def _id(says: str, kind: str) -> Meta:
    return Meta(max_length=40, description=says, extra={"id": kind})


RegionId = Annotated[str, _id("must be the id of a region", "regions")]
GatewayId = Annotated[str, _id("must be the id of a gateway", "gateways")]
LineId = Annotated[str, _id("must be the id of a line", "lines")]
LineIds = Annotated[tuple[LineId, ...], Meta(min_length=1, max_length=1000, description="must name 1 to 1000 lines")]
ObjectId = Annotated[str, _id("must be the id of an object", "objects")]
AnyId = Annotated[str, _id("must be the id of an item", "any")]
RegionIds = Annotated[tuple[RegionId, ...], Meta(max_length=16, description="must name at most 16 regions")]
SomeRegions = Annotated[
    tuple[RegionId, ...], Meta(min_length=2, max_length=64, description="must name 2 to 64 regions")
]
AnyIds = Annotated[tuple[AnyId, ...], Meta(min_length=1, max_length=10000, description="must name 1 to 10000 items")]


def _new(prefix: str) -> Meta:
    return Meta(pattern=rf"^{prefix}u[0-9a-f]{{8}}\Z", description=f"must be a new id like {prefix}u3f9c02aa")


NewLineId = Annotated[str, _new("l")]
NewRegionId = Annotated[str, _new("r")]
NewGatewayId = Annotated[str, _new("g")]
NewObjectId = Annotated[str, _new("o")]
NewBackdropId = Annotated[str, _new("b")]
BackdropId = Annotated[str, _id("must be the id of a floor plan", "backdrops")]
NewNoteId = Annotated[str, _new("n")]
NoteId = Annotated[str, _id("must be the id of a note", "notes")]

ClassName = Annotated[str, _text("must be a name of 1 to 40 characters, no space around it", _NAME, 40)]
Name = Annotated[str, _text("must be a name of 1 to 80 characters, no space around it", _NAME, 80)]
Code = Annotated[str, Meta(max_length=40, pattern=r"^[a-z-]+\Z", description="must be the code of a finding")]
NoteText = Annotated[
    str,
    Meta(
        max_length=1000, pattern=rf"^\s*(?=\S)(?:{_PLAIN}|\n)*\Z", description="must be a text of 1 to 1000 characters"
    ),
]
Text = Annotated[str, _text("must be at most 80 characters on one line", _TEXT, 80)]

Metre = Annotated[float, Meta(ge=-1e5, le=1e5, description="must be finite metres, at most 100 km from the origin")]
Extent = Annotated[float, Meta(gt=0, le=1000, description="must be lengths above 0 and up to 1000 m")]
Angle = Annotated[
    float, Meta(ge=-6.2832, le=6.2832, description="must be an angle [rad] within one turn", extra={"place": "angle"})
]
Place = Annotated[tuple[Metre, Metre], Meta(description="must be points (x, y)", extra={"place": "point"})]
Places = Annotated[tuple[Place, ...], Meta(min_length=1, max_length=16, description="must be 1 to 16 points")]
Path = Annotated[tuple[Place, ...], Meta(min_length=2, max_length=64, description="must be 2 to 64 points")]
Ring = Annotated[tuple[Place, ...], Meta(min_length=3, max_length=5000, description="must be 3 to 5000 corners")]
Rings = Annotated[tuple[Ring, ...], Meta(max_length=1000, description="must be at most 1000 rings of corners")]
Posts = Annotated[tuple[Place, Place], Meta(description="must be the two ends of the opening")]
Place3 = Annotated[tuple[Metre, Metre, Metre], Meta(description="must be a point (x, y, z)", extra={"place": "point3"})]
Sha256 = Annotated[str, Meta(pattern=r"^[0-9a-f]{64}\Z", description="must be the SHA-256 of the file")]
PlanForm = Annotated[str, Meta(pattern=r"^(png|jpg|dxf)\Z", description="must be png, jpg or dxf")]
PlanSize = Annotated[
    tuple[Annotated[float, Meta(gt=0, le=1e9)], Annotated[float, Meta(gt=0, le=1e9)]],
    Meta(description="must be width and height above 0"),
]
PlanLength = Annotated[
    float, Meta(ge=0.01, le=1e5, description="must be the metres of the longer side, 0.01 to 100 km")
]
Size3 = Annotated[tuple[Extent, Extent, Extent], Meta(description="must be three lengths")]

PREFIX = {"lines": "l", "regions": "r", "gateways": "g", "objects": "o", "notes": "n", "backdrops": "b"}


def new_id(map: RGMap, kind: str) -> str:
    """An id for a thing that a person makes: prefix, u, 8 random hex digits; not in the map yet."""
    while True:
        id = f"{PREFIX[kind]}u{secrets.token_hex(4)}"
        if id not in getattr(map, kind):
            return id


def is_human_id(id: str) -> bool:
    """Whether an edit made the thing with this id (and not the pipeline)."""
    return re.fullmatch(r"[lrgonb]u[0-9a-f]{8}", id) is not None


def refusal(type_: type[msgspec.Struct], error: Exception) -> EditError:
    """What msgspec found wrong with a value of ``type_``, as a sentence."""
    reason, _, path = str(error).partition(" - at `$")
    field, bracket, inner = path.strip("`.").partition("[")
    for f in msgspec.structs.fields(type_):
        if f.encode_name == field:
            hint = get_type_hints(type_, include_extras=True)[f.name]
            return EditError(f"{field} {_description(hint, (bracket + inner).count('['))}")
    return EditError(f"{type_.__name__}: {reason[:1].lower()}{reason[1:]}")


def _description(hint: Any, depth: int) -> str:
    """What the type of a value says of itself; ``depth``: how many tuples inside the field the value lies."""
    says = ""
    while depth >= 0 or not says:
        if get_origin(hint) in (Union, types.UnionType):
            hint = next(a for a in get_args(hint) if a is not types.NoneType)
        bare, *metas = get_args(hint) if get_origin(hint) is Annotated else (hint,)
        says = next((m.description for m in metas if isinstance(m, Meta) and m.description), says)
        if not get_args(bare):
            break
        hint, depth = get_args(bare)[0], depth - 1
    return says
