"""Carrying edits to a new run: ids by matching the old base with the new one, places with the poses near them.

``carry`` walks an edit by the types of its fields (``fields.py``), so a new edit needs no code here. Each edit ends as
applied or as a conflict that is kept and told: nothing is guessed, nothing vanishes.
"""

from __future__ import annotations

import types
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import msgspec
import numpy as np
from msgspec import Meta
from scipy.spatial import cKDTree

from rgcore.errors import EditError
from rgcore.geometry import se2
from rgcore.model.conflict import Conflict
from rgcore.model.edits import AnyEdit, Edit, Several
from rgcore.model.fields import is_human_id
from rgcore.model.history import Do, History, step
from rgcore.model.identify import match
from rgcore.model.records import RGMap, rounded
from rgcore.slam.trajectory import Trajectory


class Drift:
    """How the places of an old run lie in a new one: each moves with the scans that were taken near it.

    ``known``: whether the runs share scans; without, nothing is known. ``same_log``: both were made from one log.
    """

    NEAR = 8

    def __init__(self, old: Trajectory, new: Trajectory, same_log: bool = False) -> None:
        a, b = _same_scans(old, new, same_log)
        self.known = len(a) > 0
        if self.known:
            self._from, self._to = old.map_from_base[a], new.map_from_base[b]
            self._tree = cKDTree(self._from[:, :2])

    def points(self, points: np.ndarray) -> np.ndarray:
        """Points (K, 2) [m] of the old map in the new one."""
        points = np.asarray(points, float).reshape(-1, 2)
        if not self.known or not len(points):
            return points
        weight, near = self._near(points)
        moved = se2.transform(self._motion(near), points[:, None, :])
        return (weight[..., None] * moved).sum(1)

    def turn(self, point: np.ndarray) -> float:
        """By how much directions at a point (2,) turn [rad]."""
        if not self.known:
            return 0.0
        weight, near = self._near(np.asarray(point, float).reshape(1, 2))
        return float((weight * self._motion(near)[..., 2]).sum())

    def _near(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        distance, near = self._tree.query(points, k=min(self.NEAR, self._tree.n))
        distance, near = distance.reshape(len(points), -1), near.reshape(len(points), -1)
        weight = 1.0 / (0.5 + distance)
        return weight / weight.sum(1, keepdims=True), near

    def _motion(self, scans: np.ndarray) -> np.ndarray:
        """``new_from_old`` (..., 3) at scans."""
        return se2.compose(self._to[scans], se2.invert(self._from[scans]))


def _same_scans(old: Trajectory, new: Trajectory, same_log: bool) -> tuple[np.ndarray, np.ndarray]:
    """Indices of scans that both runs hold: by order where one log begins like the other, else by unique stamps."""
    n = min(len(old), len(new))
    alike = bool(n) and np.array_equal(old.stamps[:n], new.stamps[:n])
    telling = len(np.unique(old.stamps[:n])) > n / 2  # some logs carry one stamp for all scans
    if alike and (telling or (same_log and len(old) == len(new))):
        return np.arange(n), np.arange(n)
    (s, i, k), (t, j, m) = (np.unique(x.stamps, return_index=True, return_counts=True) for x in (old, new))
    s, i, t, j = s[k == 1], i[k == 1], t[m == 1], j[m == 1]
    _, a, b = np.intersect1d(s, t, assume_unique=True, return_indices=True)
    return i[a], j[b]


class Stale(Exception):
    """What an edit is about is not to be found in the new map."""


def carry(edit: AnyEdit, ids: Mapping[str, str], drift: Drift) -> AnyEdit:
    """The same edit for the new map. Raises Stale if one of its ids has no counterpart, or its places none."""
    if isinstance(edit, Several):
        return Several(name=edit.name, edits=tuple(carry(e, ids, drift) for e in edit.edits))  # type: ignore[misc]
    hints = get_type_hints(type(edit), include_extras=True)
    names = [f.name for f in msgspec.structs.fields(edit)]
    places = [p for name in names for p in _found("point", getattr(edit, name), hints[name])]
    if places and not drift.known:
        raise Stale("the two runs share no scan")
    carrier = _Carrier(ids, drift, drift.turn(np.mean([p[:2] for p in places], 0)) if places else 0.0)
    return type(edit)(**{name: _walk(getattr(edit, name), hints[name], carrier) for name in names})


@dataclass(frozen=True)
class _Carrier:
    """What becomes of a single value, by what its type says of it."""

    ids: Mapping[str, str]
    drift: Drift
    turn: float

    def __call__(self, extra: dict[str, str], value: Any) -> Any:
        if "id" in extra:
            if value in self.ids:
                return self.ids[value]
            if is_human_id(value):
                return value
            if not self.drift.known:
                raise Stale("the two runs share no scan")
            raise Stale(f"{value} has no clear counterpart in the new map")
        if extra.get("place") == "angle":
            return value if abs(self.turn) < 1e-6 else rounded(float(se2.wrap(value + self.turn)))
        if extra.get("place") in ("point", "point3"):
            moved = self.drift.points(np.array(value[:2]))[0]
            if np.abs(moved - value[:2]).max() < 1e-6:
                return value
            return (rounded(moved[0]), rounded(moved[1]), *value[2:])
        return value


def _walk(value: Any, hint: Any, act: Callable[[dict[str, str], Any], Any]) -> Any:
    """``value`` with ``act`` done to every part whose type carries an ``extra``."""
    if value is None:
        return None
    extra = _extra(hint)
    if extra:
        return act(extra, value)
    inner = _inner(hint, value)
    if inner is None:
        return value
    return tuple(_walk(v, h, act) for v, h in zip(value, inner, strict=True))


def _found(what: str, value: Any, hint: Any) -> Iterator[Any]:
    """All parts of ``value`` whose type says that they are such a place (point also means point3)."""
    extra = _extra(hint)
    if value is not None and extra.get("place", "").startswith(what):
        yield value
    elif value is not None and not extra:
        for v, h in zip(value, inner, strict=True) if (inner := _inner(hint, value)) is not None else ():
            yield from _found(what, v, h)


def _extra(hint: Any) -> dict[str, str]:
    if get_origin(hint) in (Union, types.UnionType):
        return next((e for a in get_args(hint) if (e := _extra(a))), {})
    if get_origin(hint) is Annotated:
        return next((a.extra for a in get_args(hint) if isinstance(a, Meta) and a.extra), {})
    return {}


def _inner(hint: Any, value: Any) -> list[Any] | None:
    """The types of the parts of a tuple; None for anything else."""
    if get_origin(hint) in (Union, types.UnionType):
        return next((i for a in get_args(hint) if (i := _inner(a, value)) is not None), None)
    if get_origin(hint) is Annotated:
        return _inner(get_args(hint)[0], value)
    if get_origin(hint) is not tuple or not isinstance(value, tuple):
        return None
    args = get_args(hint)
    return [args[0]] * len(value) if len(args) == 2 and args[1] is Ellipsis else list(args)


def ids_of(edit: Edit) -> set[str]:
    """Ids of the things that an edit is about (not of those that it makes)."""
    if isinstance(edit, Several):
        return {id for e in edit.edits for id in ids_of(e)}
    found: set[str] = set()

    def note(extra: dict[str, str], value: Any) -> Any:
        if "id" in extra:
            found.add(value)
        return value

    hints = get_type_hints(type(edit), include_extras=True)
    for f in msgspec.structs.fields(edit):
        _walk(getattr(edit, f.name), hints[f.name], note)
    return found


def rebase(run: str, history: History, new: RGMap, drift: Drift) -> tuple[list[Do], list[Conflict]]:
    """Entries for the journal of a new run, numbered from 1, and the edits that it could not take over.

    ``run``, ``history``: the old run. Its *base* is matched with ``new``, the base of the new one. Runs that share no
    scan lie in frames of their own: then nothing is carried.
    """
    wanted = {id for done in history.done for id in ids_of(done.entry.edit)}
    ids = match(history.base, new, wanted, drift.points) if drift.known else {}
    after, taken, lost = History.of(new), list[Do](), list[Conflict]()
    for done in history.done:
        old = done.entry
        try:
            entry = Do(number=len(taken) + 1, at=old.at, by=old.by, edit=carry(old.edit, ids, drift))
            after = step(after, entry)
            taken.append(entry)
        except (Stale, EditError) as e:
            outcome: Literal["stale", "conflict"] = "stale" if isinstance(e, Stale) else "conflict"
            lost.append(Conflict(run=run, entry=old, title=done.title, outcome=outcome, reason=str(e)))
    return taken, lost
