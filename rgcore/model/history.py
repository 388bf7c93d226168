"""History: a value that entries (do, undo, redo) step forward. Living and replaying are the same function."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime, timezone
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from rgcore.errors import EditError
from rgcore.model.edits import AnyEdit
from rgcore.model.records import Provenance, RGMap, replace

KINDS = ("lines", "regions", "gateways", "objects", "notes", "ignored", "backdrops")
"""The tables of a map that edits change."""

By = Annotated[str, Meta(max_length=80, pattern=r"^[^\x00-\x1f\x7f]*\Z")]


def now() -> str:
    """The time, as it stands in a journal: UTC, ISO 8601, whole seconds."""
    return datetime.now(timezone.utc).isoformat(timespec="seconds").replace("+00:00", "Z")


class Entry(msgspec.Struct, frozen=True, kw_only=True, tag_field="type"):
    """One line of the journal: its number (rising from 1), when (UTC, ISO 8601) and by whom."""

    number: int
    at: str
    by: By | None = None


class Do(Entry, frozen=True, tag="do"):
    """An edit was made."""

    edit: AnyEdit


class Undo(Entry, frozen=True, tag="undo"):
    """The last standing edit was taken back."""


class Redo(Entry, frozen=True, tag="redo"):
    """The edit taken back last was made again."""


class Settle(Entry, frozen=True, tag="settle"):
    """An edit of an older run that waited was settled: by the edit here, or let go (``edit`` None).

    ``run``, ``conflict``: the run in whose journal it stands, and its number there. While this entry stands, it waits
    no more; when it is undone, it does again.
    """

    run: str
    conflict: int
    name: str = msgspec.field(name="title")
    edit: AnyEdit | None = None


AnyEntry = Do | Settle | Undo | Redo


class Change(msgspec.Struct, frozen=True):
    """One item before and after; None = not there. ``place``: where a removed one stood among those of its kind."""

    kind: str
    id: str
    before: Any
    after: Any
    place: int = -1


Patch = tuple[Change, ...]


class Done(msgspec.Struct, frozen=True):
    """An edit in the history: its entry, its name for a person, what it changed (perhaps nothing)."""

    entry: Do | Settle
    title: str
    patch: Patch


@dataclass(frozen=True)
class History:
    """``map`` = ``base`` with the edits of ``done``; ``undone``: those that can be made again, the next one last."""

    base: RGMap
    map: RGMap
    done: tuple[Done, ...] = ()
    undone: tuple[Done, ...] = ()

    @classmethod
    def of(cls, base: RGMap) -> History:
        return cls(base, base)

    @property
    def undo_title(self) -> str | None:
        """What undo would take back; None if nothing."""
        return self.done[-1].title if self.done else None

    @property
    def redo_title(self) -> str | None:
        """What redo would make again; None if nothing."""
        return self.undone[-1].title if self.undone else None

    @property
    def settled(self) -> frozenset[tuple[str, int]]:
        """Run and number of the edits of older runs that were settled here."""
        return frozenset((d.entry.run, d.entry.conflict) for d in self.done if isinstance(d.entry, Settle))


def step(history: History, entry: AnyEntry) -> History:
    """The history after one more entry. Every item that an edit changes gets its provenance here.

    Raises EditError if the map refuses the edit, or if there is nothing to undo or redo.
    """
    if isinstance(entry, Do | Settle):
        return _do(history, entry)
    if isinstance(entry, Undo):
        if not history.done:
            raise EditError("there is nothing to undo")
        *rest, last = history.done
        return History(history.base, patched(history.map, last.patch, back=True), tuple(rest), (*history.undone, last))
    if not history.undone:
        raise EditError("there is nothing to redo")
    *rest, last = history.undone
    return History(history.base, patched(history.map, last.patch), (*history.done, last), tuple(rest))


def replay(base: RGMap, entries: Iterable[AnyEntry]) -> tuple[History, list[str]]:
    """The fold of a journal over its base, and a note for each entry that the map refuses (a damaged or foreign base).

    A refused edit keeps its place in the history with nothing changed, so that later undo entries mean what they meant.
    """
    history, notes = History.of(base), []
    for entry in entries:
        try:
            history = step(history, entry)
        except EditError as e:
            notes.append(f"edit {entry.number} has no effect: {e}")
            if isinstance(entry, Do | Settle):
                done = Done(entry, _title(history.map, entry), ())
                history = History(history.base, history.map, (*history.done, done))
    return history, notes


def difference(before: RGMap, after: RGMap) -> Patch:
    """What changed between two maps, by identity: parts that an edit left alone cost nothing."""
    out: list[Change] = []
    for kind in KINDS:
        a, b = getattr(before, kind), getattr(after, kind)
        if a is b:
            continue
        out += [Change(kind, k, was, v) for k, v, was in zip(b, b.values(), map(a.get, b), strict=True) if was is not v]
        if a.keys() - b.keys():
            out += [Change(kind, k, v, None, i) for i, (k, v) in enumerate(a.items()) if k not in b]
    return tuple(out)


def patched(map: RGMap, patch: Patch, back: bool = False) -> RGMap:
    """The map with a patch applied, or taken back: the items then stand in their old order again."""
    for kind in {c.kind for c in patch}:
        items = dict(getattr(map, kind))
        returning = []
        for c in (c for c in patch if c.kind == kind):
            value = c.before if back else c.after
            if value is None:
                items.pop(c.id, None)
            elif back and c.after is None:
                returning.append(c)
            else:
                items[c.id] = value
        if returning:
            rows = list(items.items())
            for c in returning:  # in rising order of place, as `difference` lists them
                rows.insert(c.place, (c.id, c.before))
            items = dict(rows)
        map = replace(map, **{kind: items})
    return map


def _do(history: History, entry: Do | Settle) -> History:
    after = history.map if entry.edit is None else entry.edit.apply(history.map, history.base)
    raw = difference(history.map, after)
    patch = tuple(c if c.after is None else msgspec.structs.replace(c, after=_signed(c, entry, history)) for c in raw)
    done = Done(entry, _title(history.map, entry), patch)
    return History(history.base, patched(history.map, patch), (*history.done, done))


def _title(map: RGMap, entry: Do | Settle) -> str:
    return entry.name if isinstance(entry, Settle) else entry.edit.title(map)


def _signed(change: Change, entry: Do | Settle, history: History) -> Any:
    """The changed item with its provenance. What stands as the pipeline made it is the pipeline's, whatever happened
    to it before; an edit that only reviews an item leaves its source alone."""
    was: Provenance | None = None if change.before is None else change.before.provenance
    automatic = getattr(history.base, change.kind).get(change.id)
    bare = replace(change.after, provenance=Provenance())
    if automatic is None:
        source: Literal["auto", "human", "edited"] = "human"
    else:
        source = "auto" if bare == replace(automatic, provenance=Provenance()) else "edited"
    made = Provenance(
        source=source,
        by=entry.by,
        at=entry.at,
        edits=(*(was.edits if was else ()), entry.number),
        confirmed=change.after.provenance.confirmed,
    )
    return replace(change.after, provenance=made)
