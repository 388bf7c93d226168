"""One difference between two maps, and how it is told."""

from __future__ import annotations

from typing import Any, Literal

import msgspec
import numpy as np

from rgcore.model.records import Point, rounded

What = Literal["added", "removed", "split", "merged", "reclassed", "renamed", "reshaped", "moved", "opened", "closed"]
ADDED, REMOVED = ("added", "opened"), ("removed", "closed")


class Difference(msgspec.Struct, frozen=True, kw_only=True):
    """One difference.

    old, new  ids in either map; place: [m] in the frame of the new one, as are pieces
    amount    metres, or the share that is alike (reshaped regions)
    pieces    the stretches of a wall that are added or removed
    """

    kind: str
    what: What
    old: tuple[str, ...] = ()
    new: tuple[str, ...] = ()
    place: Point
    amount: float | None = None
    text: str
    pieces: tuple[tuple[Point, Point], ...] = ()

    @property
    def colour(self) -> Literal["green", "red", "amber"]:
        """How a view shows it: green what came, red what went, amber what changed."""
        return "green" if self.what in ADDED else "red" if self.what in REMOVED else "amber"


def made(
    kind: str,
    what: What,
    place: Any,
    old: Any,
    new: Any,
    text: str,
    amount: float | None = None,
    pieces: tuple[tuple[Point, Point], ...] = (),
) -> Difference:
    """A difference between records of the old map and of the new one; ``place`` (2,) [m]."""
    before, after = (tuple(v.id for v in side) for side in (old, new))
    by = None if amount is None else round(amount, 3)
    return Difference(
        kind=kind, what=what, place=point(place), old=before, new=after, text=text, amount=by, pieces=pieces
    )


def point(p: Any) -> Point:
    """A place as records hold it."""
    return rounded(p[0]), rounded(p[1])


def mean(points: Any) -> Point:
    """The middle of some points (K, 2) [m]."""
    return point(np.mean(points, 0))
