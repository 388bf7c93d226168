"""What can be done by one click about an edit that waits. Each was tried on the new map and is allowed there."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from rgcore.errors import EditError
from rgcore.model import draft
from rgcore.model.carry import Stale, carry, ids_of
from rgcore.model.edits import AnyEdit
from rgcore.model.edits_gateways import AddGateway, MoveGateway
from rgcore.model.edits_lines import DrawLine, MoveLine
from rgcore.model.edits_objects import AddObject, MoveObject, SeedObject
from rgcore.model.edits_regions import AddRegion, ReshapeRegion
from rgcore.model.fields import new_id
from rgcore.model.history import History
from rgcore.model.identify import TABLES
from rgcore.model.outcome import Outcome, Remedy
from rgcore.model.records import RGMap

if TYPE_CHECKING:
    from rgcore.model.rebase import Source

MOST = 3
"""Candidates that are offered for one thing."""
LET_GO = Remedy(name="let it go")


def remedies(outcome: Outcome, source: Source, after: History) -> tuple[Remedy, ...]:
    """The remedies of an edit that waits, the likeliest first; the last one lets it go."""
    edit = outcome.entry.edit
    if edit is None or not source.drift.known:
        return (LET_GO,)
    out = [r for r in (*_to_candidates(edit, source, after.map), *_anew(edit, source, after.map)) if _works(r, after)]
    return (*out, LET_GO)


def _works(remedy: Remedy, after: History) -> bool:
    assert remedy.edit is not None
    try:
        return remedy.edit.apply(after.map, after.base) is not after.map
    except EditError:
        return False


def _to_candidates(edit: AnyEdit, source: Source, map: RGMap) -> Iterator[Remedy]:
    """The same edit on the things that are most like those which are missing."""
    here = {id for kind in TABLES for id in getattr(map, kind)}
    missing = [id for id in sorted(ids_of(edit)) if id not in source.ids and _old(source, id)]
    likely = {id: [c for c, _ in source.matcher.candidates(_old(source, id)) if c in here][:MOST] for id in missing}
    if not all(likely.values()):
        return
    for n in range(MOST if len(missing) == 1 else 1):
        chosen = {id: found[n] for id, found in likely.items() if n < len(found)}
        if len(chosen) < len(missing):
            return
        try:
            carried = carry(edit, source.ids | chosen, source.drift, source.pieces)
        except Stale:
            return
        yield Remedy(name=f"apply to {', '.join(chosen.values())}" if chosen else "make it all the same", edit=carried)


def _old(source: Source, id: str) -> Any:
    return next((t[id] for kind in TABLES if id in (t := getattr(source.history.base, kind))), None)


def _anew(edit: AnyEdit, source: Source, map: RGMap) -> Iterator[Remedy]:
    """What the edit made, drawn anew at the place where it would be now."""
    made: AnyEdit | None = None
    if isinstance(edit, ReshapeRegion):
        old = source.history.map.regions.get(edit.region) or source.history.base.regions.get(edit.region)
        named = {"name": old.name, "class_": old.class_} if old else {}
        made = AddRegion(id=new_id(map, "regions"), boundary=edit.boundary, holes=edit.holes, **named)
    elif isinstance(edit, MoveLine):
        made = DrawLine(id=new_id(map, "lines"), start=edit.start, end=edit.end)
    elif isinstance(edit, DrawLine):
        made = DrawLine(id=edit.id, start=edit.start, end=edit.end)
    elif isinstance(edit, MoveObject | SeedObject | AddObject):
        id = edit.id if not isinstance(edit, MoveObject) else new_id(map, "objects")
        label = "" if isinstance(edit, MoveObject) else edit.label
        made = AddObject(id=id, center=edit.center, size=edit.size, yaw=edit.yaw, label=label)
    elif isinstance(edit, MoveGateway | AddGateway):
        posts = source.drift.points(edit.posts)  # type: ignore[arg-type]
        try:
            class_ = edit.class_ if isinstance(edit, AddGateway) else None
            drawn = draft.add_gateway(map, (tuple(posts[0]), tuple(posts[1])), class_=class_)
            yield Remedy(name="draw it anew there", edit=drawn)
        except EditError:
            return
    if made is not None:
        yield Remedy(name="draw it anew there", edit=carry(made, source.ids, source.drift))
