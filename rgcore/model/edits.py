"""Edits: each is a frozen value that says what shall be, and a function from a map to a map.

A new edit is one class beside its siblings (``edits_regions.py``, ``edits_gateways.py``, ...) and one word in
``SingleEdit``: journal, undo, scripting, provenance and carrying to a new run follow from its fields and their types
(``fields.py``). Consistency of the map lives in the edit; to ask whether one is allowed is to try it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Annotated, Any, TypeVar, get_args

import msgspec
from msgspec import Meta

from rgcore.errors import EditError
from rgcore.model.edit import Edit
from rgcore.model.edits_backdrops import AddBackdrop, AlignBackdrop, DeleteBackdrop
from rgcore.model.edits_gateways import (
    AddGateway,
    AssignGateway,
    ClassifyGateway,
    DeleteGateway,
    MoveGateway,
    MoveGatewayPoints,
    RenameGateway,
)
from rgcore.model.edits_lines import (
    AlignLines,
    AssignLines,
    DeleteLines,
    DrawLine,
    JoinLines,
    MarkClutter,
    MoveLine,
    SplitLine,
)
from rgcore.model.edits_notes import AddNote, DeleteNote, MoveNote, WriteNote
from rgcore.model.edits_objects import (
    AddObject,
    ConfirmObject,
    DeleteObject,
    LabelObject,
    MoveObject,
    RejectObject,
    SeedObject,
)
from rgcore.model.edits_regions import (
    AddRegion,
    ClassifyRegion,
    DeleteRegion,
    MergeRegions,
    RenameRegion,
    ReshapeRegion,
    SplitRegion,
)
from rgcore.model.fields import Name, refusal
from rgcore.model.records import RGMap
from rgcore.model.review import Confirm, HeedFinding, IgnoreFinding, RevertToAutomatic, Unconfirm

T = TypeVar("T")

SingleEdit = (
    ClassifyRegion
    | RenameRegion
    | ReshapeRegion
    | SplitRegion
    | MergeRegions
    | AddRegion
    | DeleteRegion
    | ClassifyGateway
    | RenameGateway
    | MoveGateway
    | MoveGatewayPoints
    | AddGateway
    | AssignGateway
    | DeleteGateway
    | DrawLine
    | MoveLine
    | JoinLines
    | SplitLine
    | AlignLines
    | MarkClutter
    | AssignLines
    | DeleteLines
    | SeedObject
    | AddObject
    | MoveObject
    | LabelObject
    | ConfirmObject
    | RejectObject
    | DeleteObject
    | AddNote
    | WriteNote
    | MoveNote
    | DeleteNote
    | Confirm
    | Unconfirm
    | RevertToAutomatic
    | IgnoreFinding
    | HeedFinding
    | AddBackdrop
    | AlignBackdrop
    | DeleteBackdrop
)


class Several(Edit, frozen=True):
    """All of these edits, one after the other, as one step: if the map refuses one, none is made."""

    name: Name = msgspec.field(name="title")
    edits: Annotated[
        tuple[SingleEdit, ...], Meta(min_length=1, max_length=10000, description="must be 1 to 10000 single edits")
    ]

    def checked(self) -> Several:
        if not all(isinstance(e, get_args(SingleEdit)) for e in self.edits):
            raise EditError("edits must be 1 to 10000 single edits")
        count = len(self.edits)
        edits = tuple(_told(i, count, e.checked) for i, e in enumerate(self.edits, 1))
        return super(Several, msgspec.structs.replace(self, edits=edits)).checked()

    def change_from(self, map: RGMap, base: RGMap) -> RGMap:
        for i, edit in enumerate(self.edits, 1):
            map = _told(i, len(self.edits), partial(edit.change_from, map, base))
        return map

    def change(self, map: RGMap) -> RGMap:
        return self.change_from(map, map)

    def title(self, map: RGMap) -> str:
        return self.name


AnyEdit = SingleEdit | Several
EDITS: dict[str, type[Edit]] = {e.__name__: e for e in get_args(AnyEdit)}
"""Every edit by its name in the journal."""


def decode_edit(text: str | bytes) -> AnyEdit:
    """An edit from its JSON: ``{"edit": "RenameRegion", "region": "r3", "name": "Lab"}``. Raises EditError."""
    try:
        raw = msgspec.json.decode(text)
    except (msgspec.DecodeError, ValueError) as e:
        raise EditError(f"not JSON: {e}") from e
    return _decoded(raw)


def _decoded(raw: Any) -> AnyEdit:
    kind = raw.get("edit") if isinstance(raw, dict) else None
    if not isinstance(kind, str) or kind not in EDITS:
        raise EditError(f"unknown edit {kind!r}; known are {', '.join(EDITS)}")
    parts = raw.get("edits")
    if EDITS[kind] is Several and isinstance(parts, list):
        edits = [_told(i, len(parts), partial(_decoded, part)) for i, part in enumerate(parts, 1)]
        raw = {**raw, "edits": [msgspec.to_builtins(e) for e in edits]}
    try:
        return msgspec.convert(raw, EDITS[kind]).checked()  # type: ignore[return-value]
    except msgspec.ValidationError as e:
        raise refusal(EDITS[kind], e) from e


def _told(number: int, count: int, do: Callable[[], T]) -> T:
    """What ``do`` gives; its refusal says which of several edits it is about."""
    try:
        return do()
    except EditError as e:
        raise EditError(f"edit {number} of {count}: {e}" if count > 1 else str(e)) from e
