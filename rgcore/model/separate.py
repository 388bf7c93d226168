"""Edits of several things at once: those whose things are independent are made for the things that are clear."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rgcore.model.carry import Stale, carry, ids_of
from rgcore.model.edits import AnyEdit, Edit, Several
from rgcore.model.edits_gateways import ClassifyGateway, DeleteGateway, RenameGateway
from rgcore.model.edits_lines import AlignLines, AssignLines, DeleteLines, MarkClutter
from rgcore.model.edits_notes import AddNote
from rgcore.model.edits_objects import ConfirmObject, DeleteObject, LabelObject, RejectObject
from rgcore.model.edits_regions import ClassifyRegion, RenameRegion
from rgcore.model.effect import shift_of
from rgcore.model.fields import is_human_id
from rgcore.model.review import Confirm, Unconfirm

if TYPE_CHECKING:
    from rgcore.model.rebase import Source

LISTS = {Confirm: "items", Unconfirm: "items", MarkClutter: "lines", DeleteLines: "lines", AlignLines: "lines"}
LISTS |= {AssignLines: "lines"}
"""Edits that mean each thing of a list by itself."""
ALIKE: tuple[type[Edit], ...] = (
    *(ClassifyRegion, RenameRegion, ClassifyGateway, RenameGateway, DeleteGateway, LabelObject, ConfirmObject),
    *(RejectObject, DeleteObject, MarkClutter, DeleteLines, AssignLines, AlignLines, Confirm, Unconfirm),
)
"""Edits that, several of one kind, mean each thing by itself."""


def doubtful_parts(edit: AnyEdit, source: Source) -> tuple[AnyEdit | None, AnyEdit | None, str]:
    """What can be carried of an edit, what cannot, and why not: (edit, None, "") where it is not to be parted.

    A note outlives its item and stays at its place. What was confirmed and looks other now is not confirmed any more.
    """
    if isinstance(edit, Several):
        return _several(edit, source)
    if isinstance(edit, AddNote) and edit.item is not None and not _known(edit.item, source):
        return msgspec.structs.replace(edit, item=None), None, f"{edit.item} has no clear counterpart in the new map"
    name = LISTS.get(type(edit))
    if name is None or not source.drift.known:
        return edit, None, ""
    why = {id: reason for id in getattr(edit, name) if (reason := _doubt(edit, id, source))}
    if not why:
        return edit, None, ""
    sure = tuple(id for id in getattr(edit, name) if id not in why)
    rest = msgspec.structs.replace(edit, **{name: tuple(why)})
    reason = "; ".join(list(why.values())[:3]) + (f" and {len(why) - 3} more" if len(why) > 3 else "")
    return (msgspec.structs.replace(edit, **{name: sure}) if sure else None), rest, reason


def _known(id: str, source: Source) -> bool:
    return id in source.ids or is_human_id(id)


def _doubt(edit: AnyEdit, id: str, source: Source) -> str:
    if id in source.ids:
        return shift_of(source, id) if isinstance(edit, Confirm) else ""
    if is_human_id(id) or (id in source.pieces and not isinstance(edit, Confirm | Unconfirm)):
        return ""
    return f"{id} has no clear counterpart in the new map"


def _several(edit: Several, source: Source) -> tuple[AnyEdit | None, AnyEdit | None, str]:
    kinds = {type(e) for e in edit.edits}
    if len(kinds) > 1 or not kinds <= set(ALIKE):
        return edit, None, ""
    sure, rest, why = [], [], []
    for e in edit.edits:
        try:
            carry(e, source.ids, source.drift, source.pieces)
            sure.append(e)
        except Stale as stale:
            rest.append(e)
            why.append(str(stale))
    if not rest or not sure or not any(ids_of(e) for e in rest):
        return edit, None, ""
    part, left = (msgspec.structs.replace(edit, edits=tuple(some)) for some in (sure, rest))
    return part, left, "; ".join(why[:3]) + (f" and {len(why) - 3} more" if len(why) > 3 else "")
