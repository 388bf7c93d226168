"""Does an edit do in the new map what it did in the old one? What it is about and what it made are compared."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from rgcore.model.carry import ids_of, places_of
from rgcore.model.edits import AnyEdit, Several
from rgcore.model.edits_gateways import AddGateway, AssignGateway
from rgcore.model.edits_lines import AssignLines
from rgcore.model.edits_notes import AddNote
from rgcore.model.edits_objects import AddObject, SeedObject
from rgcore.model.edits_regions import ClassifyRegion, RenameRegion
from rgcore.model.ground import shape_of
from rgcore.model.history import Change, Done, History
from rgcore.model.identify import TABLES, beside
from rgcore.model.records import Gateway, Line, MapObject, Region

if TYPE_CHECKING:
    from rgcore.model.rebase import Source

ALIKE = 0.5
"""Score below which what an edit makes is another thing."""
GONE = 0.6
"""The same of what an edit takes away: more care."""
GROUND = 0.25
"""Share of its ground that an edit may take from a region from which it took none in the old map."""
SIGMAS = 3.0
"""A line that lies more deviations beside the place that the poses say has moved."""
LEAST = 0.05
"""m: less is no move, whatever the deviation"""
UNKNOWN = 0.02
"""m: deviation of a line that no scan tells of"""
SHAPE = 0.75
"""Score below which the outline of a region is another one."""
NAMED = 0.6
"""The same where only a name or class is given to the region: a room whose niche was cut off is still that room."""
EXTENT = 0.6
"""The same of lines: their ends are seen less often than their middle."""
UNSURE = 0.25
"""m: a place about which the scans that saw it disagree more is told"""
NAMING = (ClassifyRegion, RenameRegion, AddNote)
"""Edits that say something of a region as a whole."""
BESIDE_IT = (AssignGateway, AssignLines, AddGateway, SeedObject, AddObject)
"""Edits to which regions are neighbours: their outlines elsewhere are no matter."""
OFF = 0.3
"""m: gateways and objects that stand farther off have moved"""


def contradiction(source: Source, done: Done, after: History) -> str | None:
    """Why the last edit of ``after`` is not what ``done`` was in the old map; None if it is."""
    assert done.entry.edit is not None
    about = ids_of(done.entry.edit)
    patch = {(c.kind, c.id): c for c in after.done[-1].patch}
    if done.patch and not patch:
        return None  # the new map says so already
    for c in done.patch:
        if c.kind not in TABLES or (c.id not in about and c.before is not None) or c.id in source.pieces:
            continue
        id = source.ids.get(c.id, c.id)
        new = patch.get((c.kind, id))
        reason = _other(source, c, id, new)
        if reason:
            return reason
    return _ground(source, done, after)


def _other(source: Source, old: Change, id: str, new: Change | None) -> str | None:
    """Why a change is another one than in the old map."""
    if new is None:
        return None  # it is so already
    if (old.after is None) != (new.after is None):
        return f"{id} would {'stay' if old.after is None else 'go'}"
    least = GONE if old.after is None else ALIKE
    before, now = (old.before, new.before) if old.after is None else (old.after, new.after)
    score = source.matcher.likeness(before, now)
    if isinstance(now, MapObject):
        least = ALIKE
    if isinstance(now, Line) and old.after is None and _length(now) < _length(before):
        least = ALIKE  # it takes away less than before
    return f"{id} would be another one: {100 * score:.0f} % alike" if score < least else None


def _ground(source: Source, done: Done, after: History) -> str | None:
    """Whether the edit takes ground from a region that it did not take before."""
    lost_before = {source.ids.get(c.id, c.id): _lost(c) for c in done.patch if c.kind == "regions"}
    for c in after.done[-1].patch:
        if c.kind == "regions" and _lost(c) > lost_before.get(c.id, 0.0) + GROUND:
            return f"it would take {100 * _lost(c):.0f} % of the ground of {c.id}"
    return None


def _lost(c: Change) -> float:
    """Share of its ground that a region loses by a change; 0 of one that grows."""
    if c.before is None or c.before.boundary is getattr(c.after, "boundary", None):
        return 0.0
    area = shape_of(c.before).area
    return 1.0 if c.after is None else max(0.0, 1.0 - shape_of(c.after).area / max(area, 1e-9))


def shift(source: Source, edit: AnyEdit) -> str:
    """By how much the things that an edit is about lie or look other than the poses say; "" if they do not."""
    least = _least_alike(edit)
    found = [s for id in sorted(ids_of(edit)) if id in source.ids and (s := shift_of(source, id, least))]
    apart = max(source.drift.spread(np.array(places_of(edit))), default=0.0) if source.drift.known else 0.0
    if apart > UNSURE:
        found.append(f"where it is now is known to {apart:.2f} m only: the scans near it moved apart")
    return "; ".join(found[:3]) + (f" and {len(found) - 3} more" if len(found) > 3 else "")


def _least_alike(edit: AnyEdit) -> float:
    """How much the outline of a recognised region must be as before for an edit to mean the same there."""
    if isinstance(edit, Several):
        return max(map(_least_alike, edit.edits))
    return 0.0 if isinstance(edit, BESIDE_IT) else NAMED if isinstance(edit, NAMING) else SHAPE


def shift_of(source: Source, id: str, shape: float = SHAPE) -> str:
    """The same of one thing of the old map that was recognised; ``shape``: score of an outline that is the same."""
    for kind in TABLES:
        old = getattr(source.history.base, kind).get(id)
        new = getattr(source.matcher.new, kind).get(source.ids.get(id))
        if old is not None and new is not None:
            return _shift(source, old, new, shape)
    return ""


def _shift(source: Source, old: Any, new: Any, shape: float) -> str:
    score = source.matcher.likeness(old, new)
    if isinstance(old, Region):
        return f"{new.id} has another outline: {100 * score:.0f} % alike" if score < shape else ""
    was = source.matcher.outline(old)
    if isinstance(old, Line):
        off, sigma = beside(was, np.array([new.start, new.end])), deviation(old, new)
        if off > max(SIGMAS * sigma, LEAST):
            return f"{new.id} lies {off:.2f} m beside where it was ({off / sigma:.1f} sigma)"
        return f"{new.id} has other ends: {100 * score:.0f} % alike" if score < EXTENT else ""
    if isinstance(old, Gateway):
        off = math.dist(was.mean(0), np.mean(new.posts, 0))
    else:
        assert isinstance(old, MapObject)
        off = math.dist(was[:2], new.center[:2])
    return f"{new.id} stands {off:.2f} m from where it was" if off > OFF else ""


def deviation(*lines: Line) -> float:
    """Standard deviation [m] of the distance of lines from one another: each is as sure as its segments agree."""
    return math.hypot(*(v.residual if v.residual and v.support else UNKNOWN for v in lines), 0.005)


def _length(line: Line) -> float:
    return math.dist(line.start, line.end)
