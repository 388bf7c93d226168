"""Items as a drawing has them: what comes back from a file that was edited elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from rgcore.exports.cells import footprint
from rgcore.model.records import RGMap


@dataclass(frozen=True, eq=False)
class Drawn:
    """One item of a drawing.

    kind    region, gateway, line, object or note
    id      None for what was drawn elsewhere
    rings   m, map frame: outline and holes of a region; two ends; footprint (4, 2); place (1, 2)
    name, class_, text   None where the drawing does not say
    height, floor        m, of an object
    """

    kind: str
    id: str | None
    rings: tuple[np.ndarray, ...]
    name: str | None = None
    class_: str | None = None
    text: str | None = None
    height: float | None = None
    floor: float | None = None

    @property
    def points(self) -> np.ndarray:
        """(K, 2) the outline, or all there is."""
        return self.rings[0]


def drawn(map: RGMap) -> Iterator[Drawn]:
    """A map as a drawing."""
    for r in map.regions.values():
        yield Drawn("region", r.id, tuple(np.array(ring, float) for ring in (r.boundary, *r.holes)), r.name, r.class_)
    for g in map.gateways.values():
        yield Drawn("gateway", g.id, (np.array(g.posts),), g.name, g.class_)
    for v in map.lines.values():
        yield Drawn("line", v.id, (np.array([v.start, v.end]),))
    for o in map.objects.values():
        high = o.size[2]
        yield Drawn("object", o.id, (footprint(o),), o.label, height=high, floor=o.center[2] - high / 2)
    for n in map.notes.values():
        yield Drawn("note", n.id, (np.array([n.place]),), text=n.text)


def same_place(a: Drawn, b: Drawn, within: float) -> bool:
    """Whether two items of a kind stand at the same place, to ``within`` [m]; where a ring begins does not matter."""
    if len(a.rings) != len(b.rings):
        return False
    if a.kind in ("line", "gateway", "note"):
        return a.points.shape == b.points.shape and bool(np.abs(a.points - b.points).max() <= within)
    return all(any(_same_ring(x, y, within) for y in b.rings) for x in a.rings)


def _same_ring(a: np.ndarray, b: np.ndarray, within: float) -> bool:
    if len(a) != len(b):
        return False
    b = b if _area(a) * _area(b) >= 0 else b[::-1]
    first = np.flatnonzero(np.abs(b - a[0]).max(1) <= within)
    return any(np.abs(np.roll(b, -k, axis=0) - a).max() <= within for k in first)


def _area(ring: np.ndarray) -> float:
    x, y = ring.T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def ring(points: Any) -> np.ndarray:
    """(K, 2) corners without the first one repeated."""
    out = np.asarray(points, float).reshape(-1, np.shape(points)[-1] if np.ndim(points) == 2 else 2)[:, :2]
    return out[:-1] if len(out) > 1 and np.abs(out[0] - out[-1]).max() < 1e-9 else out
