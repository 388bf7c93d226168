"""Edits of a run on the map of another one: which hold, which are shifted, contradicted or without their object.

An edit is carried by the types of its fields (``carry.py``): ids by recognising the things of the old automatic map in
the new one (``identify.py``), places with the scans near them (``drift.py``). Then its *effect* is compared: what it
made of the old map, moved, with what it makes of the new one. An edit that would do something else is not made.
What the new map holds already by itself is not made twice. Nothing is guessed, nothing vanishes.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import msgspec

from rgcore.errors import EditError
from rgcore.model.already import Already, already
from rgcore.model.carry import Stale, carry, ids_of, places_of
from rgcore.model.drift import Drift
from rgcore.model.edits import AnyEdit
from rgcore.model.effect import contradiction, shift
from rgcore.model.history import AnyEntry, Do, Done, History, Settle, Undo, step
from rgcore.model.identify import Matcher
from rgcore.model.outcome import Key, Outcome
from rgcore.model.records import Point, RGMap, rounded
from rgcore.model.remedies import remedies
from rgcore.model.separate import doubtful_parts

__all__ = ["Drift", "Rebased", "Source", "Stale", "carry", "ids_of", "rebase"]


@dataclass
class Source:
    """A run that edits come from: its name, its history, and how its places lie in the new run."""

    run: str
    history: History
    drift: Drift
    ids: dict[str, str] = field(default_factory=dict)
    pieces: dict[str, tuple[str, ...]] = field(default_factory=dict)
    matcher: Matcher = None  # type: ignore[assignment]

    def recognise(self, new: RGMap, edits: Iterable[AnyEdit | None]) -> None:
        """Find the things that edits are about in the base of the new run."""
        self.matcher = Matcher(self.history.base, new, self.drift.points)
        if not self.drift.known:
            return
        for id in sorted({id for e in edits if e is not None for id in ids_of(e)}):
            found = self.matcher(id)
            if found is not None:
                self.ids[id] = found
            elif pieces := self.matcher.pieces(id):
                self.pieces[id] = pieces


class Rebased(NamedTuple):
    """``entries``: the journal of the new run; ``history``: what it gives; ``outcomes``: of every standing edit, in
    their order; ``lost``: edits taken back that can no more be made again."""

    entries: list[AnyEntry]
    history: History
    outcomes: list[Outcome]
    lost: list[Outcome]


def rebase(
    source: Source,
    new: RGMap,
    held: Sequence[tuple[Source, Done]] = (),
    leave: Collection[Key] = (),
) -> Rebased:
    """The edits of ``source`` on ``new``, the base of the new run.

    held   edits of earlier runs that wait; they are tried first: a third run may know again what the second did not
    leave  edits that are not to be made: they wait instead

    Runs that share no scan lie in frames of their own: then nothing is carried.
    """
    earlier: dict[str, tuple[Source, list[Done]]] = {}
    for s, done in held:
        earlier.setdefault(s.run, (s, []))[1].append(done)
    for s, some in earlier.values():
        s.recognise(new, (d.entry.edit for d in some))
    undone = source.history.undone[::-1]
    source.recognise(new, (d.entry.edit for d in (*source.history.done, *undone)))
    work = _Rebase(new, leave)
    for s, some in earlier.values():
        for done in some:
            work.carry(s, done)
    for done in source.history.done:
        work.carry(source, done)
    standing, outcomes = work.after, work.outcomes
    work.outcomes = []
    made = len(work.entries)
    for done in undone:
        work.carry(source, done)
    again = [e for e in work.entries[made:] if isinstance(e, Do | Settle)]
    undo = [Undo(number=len(work.entries) + 1 + i, at=e.at, by=e.by) for i, e in enumerate(again)]
    history = work.after
    for entry in undo:
        history = step(history, entry)
    lost = [o for o in work.outcomes if o.waits]
    return Rebased([*work.entries, *undo], history, _with_remedies(outcomes, standing, (source, *_sources(held))), lost)


class _Rebase:
    """The new history as it grows, and what became of each edit."""

    def __init__(self, new: RGMap, leave: Collection[Key]) -> None:
        self.after, self.leave = History.of(new), leave
        self.entries: list[AnyEntry] = []
        self.outcomes: list[Outcome] = []

    def carry(self, source: Source, done: Done) -> None:
        edit = done.entry.edit
        if (source.run, done.entry.number) in self.leave:
            return self._wait(source, done, "conflict", "left out when the run was accepted")
        if edit is None:
            return self._make(source, done, None, "")
        found = already(source, done, self.after, only_new=True)
        if found is not None:
            return self._adopt(source, done, found)
        part, rest, why = doubtful_parts(edit, source)
        if rest is not None:
            left = Done(msgspec.structs.replace(done.entry, edit=rest), done.title, done.patch)
            here = ids_of(rest) <= source.ids.keys()  # all are there, but look other than when they were confirmed
            if part is None and not here:
                return self._one(source, left, rest)
            if part is not None:
                self._one(source, done, part)
            return self._wait(source, left, "conflict" if here else "stale", why)
        self._one(source, done, part or edit, why)

    def _one(self, source: Source, done: Done, edit: AnyEdit, note: str = "") -> None:
        kind: Literal["conflict", "stale"] = "conflict"
        try:
            carried = carry(edit, source.ids, source.drift, source.pieces)
            after = step(self.after, self._entry(done, carried))
        except Stale as e:
            kind, reason = "stale", str(e)
        except EditError as e:
            reason = str(e)
        else:
            against = contradiction(source, done, after)
            if against is None:
                return self._make(source, done, carried, note or shift(source, edit), after)
            reason = against
        found = already(source, done, self.after)
        if found is not None:
            return self._adopt(source, done, found)
        self._wait(source, done, kind, reason)

    def _adopt(self, source: Source, done: Done, found: Already) -> None:
        """The new map holds by itself what the edit made: only what a person called it is to be set."""
        source.ids.update(found.ids)
        if found.edit is not None:
            try:
                after = step(self.after, self._entry(done, found.edit))
            except EditError as e:
                return self._wait(source, done, "conflict", str(e))
            return self._make(source, done, found.edit, "", after)
        self.outcomes.append(self._outcome(source, done, "applied", "the new map is so by itself"))

    def _make(self, source: Source, done: Done, edit: AnyEdit | None, note: str, after: History | None = None) -> None:
        self.after = step(self.after, self._entry(done, edit)) if after is None else after
        self.entries.append(self.after.done[-1].entry)
        made = self._outcome(source, done, "shifted" if note else "applied", note)
        self.outcomes.append(msgspec.structs.replace(made, edit=edit))

    def _wait(self, source: Source, done: Done, kind: Literal["conflict", "stale"], reason: str) -> None:
        self.outcomes.append(self._outcome(source, done, kind, reason))

    def _entry(self, done: Done, edit: AnyEdit | None) -> Do | Settle:
        return msgspec.structs.replace(done.entry, number=len(self.entries) + 1, edit=edit)

    def _outcome(self, source: Source, done: Done, kind: Any, reason: str) -> Outcome:
        place = _place(source, done)
        return Outcome(run=source.run, entry=done.entry, title=done.title, kind=kind, reason=reason, place=place)


def _place(source: Source, done: Done) -> Point | None:
    """Where the edit is in the new map: the places that it names, else the things that it is about."""
    edit = done.entry.edit
    if edit is None or not source.drift.known:
        return None
    points = places_of(edit) or [p for id in sorted(ids_of(edit)) if (p := _middle(source.history.base, id))]
    points = points or [p for c in done.patch if (p := _middle_of(c.before or c.after))]
    if not points:
        return None
    x, y = source.drift.points(points[:1])[0]  # type: ignore[arg-type]
    return rounded(x), rounded(y)


def _middle(map: RGMap, id: str) -> Point | None:
    kinds = ("regions", "gateways", "lines", "objects")
    return next((_middle_of(table[id]) for k in kinds if id in (table := getattr(map, k))), None)


def _middle_of(item: Any) -> Point | None:
    """A point of an item; None of one that lies nowhere (a finding)."""
    if hasattr(item, "box"):
        return item.box.center
    if hasattr(item, "center"):
        return item.center[:2]
    if hasattr(item, "place"):
        return item.place
    ends = getattr(item, "posts", None) or ((item.start, item.end) if hasattr(item, "start") else None)
    return None if ends is None else ((ends[0][0] + ends[1][0]) / 2, (ends[0][1] + ends[1][1]) / 2)


def _sources(held: Sequence[tuple[Source, Done]]) -> list[Source]:
    return list({s.run: s for s, _ in held}.values())


def _with_remedies(outcomes: Sequence[Outcome], after: History, sources: Sequence[Source]) -> list[Outcome]:
    by_run = {s.run: s for s in reversed(sources)}
    return [msgspec.structs.replace(o, remedies=remedies(o, by_run[o.run], after)) if o.waits else o for o in outcomes]
