"""What a person corrected may come out right in the new map by itself: then it is not made twice."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from rgcore.model.carry import ids_of
from rgcore.model.edits import AnyEdit, Several
from rgcore.model.edits_gateways import ClassifyGateway, RenameGateway
from rgcore.model.edits_objects import ConfirmObject, LabelObject
from rgcore.model.edits_regions import AddRegion, ClassifyRegion, RenameRegion
from rgcore.model.history import Change, Done, History
from rgcore.model.identify import CLEAR, REACH, TABLES
from rgcore.model.records import Gateway, Line, MapObject, Region

if TYPE_CHECKING:
    from rgcore.model.rebase import Source

FOUND = {"lines": 0.6, "regions": 0.75, "gateways": 0.7, "objects": 0.6}
"""Score from which on an automatic thing of the new map is what a person made."""
TRACE = {"lines": 0.05, "regions": 0.2, "gateways": 0.2}
"""Score from which on a thing that a person took away may be there still."""
CRUMBS = 0.4
"""Share of a line along which there are lines in the new map, however small: then it may be there still."""


class Already(NamedTuple):
    """``ids``: new id by old id of what the edit left; ``edit``: what is still to be done (a name), or None."""

    ids: dict[str, str]
    edit: AnyEdit | None


def already(source: Source, done: Done, after: History, only_new: bool = False) -> Already | None:
    """Whether the new map holds by itself all that an edit made of the old one; None if not.

    ``only_new``: only for edits that make something, which would then be there twice.
    """
    edit = done.entry.edit
    if edit is None or not source.drift.known or isinstance(edit, Several):
        return None
    about = ids_of(edit)
    changes = [c for c in done.patch if c.kind in TABLES and (c.id in about or c.before is None)]
    made = [c for c in changes if c.before is None]
    if not changes or (only_new and not made) or not _shaping(changes):
        return None
    taken = {new: old for old, new in source.ids.items()}
    ids: dict[str, str] = {}
    for c in (c for c in changes if c.after is not None):
        found = _counterpart(source, c, after, taken)
        if found is None or found in ids.values():
            return None
        ids[c.id] = found
    for c in (c for c in changes if c.after is None):
        if any(id not in ids.values() for id in _traces(source, c)):
            return None
    return Already(ids, _named(edit, made, ids, after))


def _traces(source: Source, change: Change) -> list[str]:
    """The things of the new map that may be what a person took away."""
    if isinstance(change.before, MapObject):
        x, y = source.matcher.outline(change.before)[:2]
        return [o.id for o in source.matcher.new.objects.values() if math.dist((x, y), o.center[:2]) < REACH]
    if isinstance(change.before, Line) and source.matcher.covered(change.before) >= CRUMBS:
        return [change.id]  # of many: none of them alone is a counterpart
    return [id for id, _ in source.matcher.candidates(change.before, TRACE[change.kind])]


def _shaping(changes: list[Change]) -> bool:
    """Whether the changes are such as a mapper makes by itself: of shapes, not of what a person calls a thing."""
    return all(c.before is None or c.after is None or _shape(c.before) != _shape(c.after) for c in changes)


def _shape(item: Any) -> Any:
    if isinstance(item, Region):
        return item.boundary, item.holes
    if isinstance(item, Gateway):
        return item.posts
    return (item.center, item.size) if isinstance(item, MapObject) else (item.start, item.end)


def _counterpart(source: Source, change: Change, after: History, taken: Mapping[str, str]) -> str | None:
    """The automatic thing of the new map that is what an edit made; None if that is another thing's counterpart."""
    likely = [(id, score) for id, score in source.matcher.candidates(change.after) if score > 0]
    if not likely or likely[0][1] < FOUND[change.kind]:
        return None
    if len(likely) > 1 and likely[0][1] - likely[1][1] < CLEAR:
        return None
    id = likely[0][0]
    if id not in getattr(after.map, change.kind) or taken.get(id, change.id) != change.id:
        return None
    if source.ids.get(change.id, id) != id:
        return None
    if change.before is None and _claimed(source, change, id):
        return None
    return id


def _claimed(source: Source, change: Change, id: str) -> bool:
    """Whether the automatic thing is one that the old map had as well, beside what the person made."""
    new = getattr(source.matcher.new, change.kind)[id]
    olds = getattr(source.history.base, change.kind).values()
    return any(source.matcher.likeness(old, new) >= FOUND[change.kind] for old in olds if _near(source, old, new))


def _near(source: Source, old: Any, new: Any) -> bool:
    """Whether two things may have anything in common (a cheap look before the exact one)."""
    a = source.matcher.bounds(old)
    b = source.matcher.bounds(new, moved=False)
    return bool((a[0] <= b[1] + 1.0).all() and (b[0] <= a[1] + 1.0).all())


def _named(edit: AnyEdit, made: list[Change], ids: Mapping[str, str], after: History) -> AnyEdit | None:
    """The edits that give the automatic things the names and classes that a person gave."""
    out: list[Any] = []
    for c in made:
        new = getattr(after.map, c.kind)[ids[c.id]]
        name = getattr(edit, "name", "")
        if isinstance(c.after, Region) and name and new.name != name:
            out.append(RenameRegion(region=new.id, name=name))
        if isinstance(edit, AddRegion) and new.class_ != edit.class_:
            out.append(ClassifyRegion(region=new.id, class_=edit.class_))
        if isinstance(c.after, Gateway) and new.class_ != c.after.class_:
            out.append(ClassifyGateway(gateway=new.id, class_=c.after.class_))
        if isinstance(c.after, Gateway) and c.after.name and new.name != c.after.name:
            out.append(RenameGateway(gateway=new.id, name=c.after.name))
        if isinstance(c.after, MapObject):
            if c.after.label and new.label != c.after.label:
                out.append(LabelObject(object=new.id, label=c.after.label))
            out.append(ConfirmObject(object=new.id))
    if len(out) > 1:
        return Several(name="as it was corrected", edits=tuple(out))
    return out[0] if out else None
