"""Which thing of one map is which thing of another? By geometry, one to one, and only where there is no doubt."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from rgcore.geometry import cutting, se2
from rgcore.geometry.polygons import polygon
from rgcore.geometry.segments import distances
from rgcore.model.records import Gateway, Line, MapObject, Record, Region, RGMap

Move = Callable[[np.ndarray], np.ndarray]
"""Takes points (K, 2) [m] of the old map to where they lie in the new one."""
Outlines = Any
"""What things of a kind are recognised by, in their order: a list of polygons, or an array (N, ...)."""

SAME = 0.5
"""Score from which on two things may be the same; 1 = equal."""
CLEAR = 0.2
"""By how much the best score must lead the next one."""
REACH = 1.0
"""m: posts of a gateway, or boxes of objects, that lie so far apart score 0"""
ASIDE = 0.3
"""m: lines that lie so far beside each other score 0"""
BESIDE = 0.08
"""m: lines that lie so near beside each other lie on one another: poses are no better known"""
ASKEW = math.radians(15)
"""rad: lines that differ so much in direction score 0"""
ALONG = math.radians(30)
"""rad: lines that differ so much in direction do not run along one another"""
WITHIN = 0.8
"""share of a line that must lie on another one to be a piece of it"""
TABLES = ("lines", "regions", "gateways", "objects")


class Matcher:
    """The things of an old map, moved, against those of a new one."""

    def __init__(self, old: RGMap, new: RGMap, move: Move = lambda points: points) -> None:
        self.old, self.new, self._move = old, new, move
        self._kind = {id: kind for kind in TABLES for id in getattr(old, kind)}
        self._ids = {kind: (list(getattr(old, kind)), list(getattr(new, kind))) for kind in TABLES}
        self._row = {id: n for kind in TABLES for n, id in enumerate(getattr(old, kind))}
        self._shapes: dict[str, tuple[Outlines, Outlines]] = {}

    def __call__(self, id: str) -> str | None:
        """The one clear counterpart of a thing, whose own clear counterpart it is; None if there is none."""
        kind = self._kind.get(id)
        if kind is None or not self._ids[kind][1]:
            return None
        olds, news = self._outlines(kind)
        i = self._row[id]
        j = _clear(_SCORES[kind](olds[i], news))
        if j is None or _clear(_SCORES[kind](news[j], olds)) != i:
            return None
        return self._ids[kind][1][j]

    def pieces(self, id: str) -> tuple[str, ...]:
        """The lines that a line fell into: each lies on it nearly whole, together they are half of it or more."""
        if self._kind.get(id) != "lines" or not self._ids["lines"][1]:
            return ()
        olds, news = self._outlines("lines")
        one = olds[self._row[id]]
        common, aside, lengths = _common(one, np.asarray(news))
        on = (common >= WITHIN * np.maximum(lengths, 1e-9)) & (aside < ASIDE / 2)
        on &= np.array([_scored_best(news[j], olds, one) if on[j] else False for j in range(len(on))])
        if not on.any() or common[on].sum() < SAME * float(np.hypot(*(one[1] - one[0]))):
            return ()
        return tuple(self._ids["lines"][1][j] for j in np.flatnonzero(on))

    def candidates(self, item: Record, least: float = 0.1) -> list[tuple[str, float]]:
        """Things of the new map that are like a thing of the old one, with their scores, the best first."""
        kind = _kind_of(item)
        ids = self._ids[kind][1]
        if not ids:
            return []
        scores = _SCORES[kind](self.outline(item), self._outlines(kind)[1])
        order = np.argsort(-scores, kind="stable")
        return [(ids[j], float(scores[j])) for j in order if scores[j] >= least]

    def covered(self, line: Line) -> float:
        """Share of a line of the old map along which lines of the new one lie near, roughly in its direction."""
        (a, b), others = (
            self.outline(line),
            np.array([(v.start, v.end) for v in self.new.lines.values()]).reshape(-1, 2, 2),
        )
        d, e = b - a, others[:, 1] - others[:, 0]
        askew = np.abs(se2.wrap(np.arctan2(e[:, 1], e[:, 0]) - math.atan2(d[1], d[0])))
        others = others[askew < ALONG]
        points = a + np.linspace(0, 1, max(3, int(np.hypot(*d) / 0.05)))[:, None] * d
        return float((distances(points[:, None], others).min(1, initial=np.inf) < ASIDE).mean())

    def likeness(self, old: Record, new: Record) -> float:
        """How much a thing of the old map, moved, is like one of the new map: 0 to 1."""
        return float(_SCORES[_kind_of(old)](self.outline(old), [_outline(new, _stay)])[0])

    def outline(self, item: Record) -> Any:
        """What a thing of the old map is recognised by, where it lies in the new one."""
        kind = _kind_of(item)
        if getattr(self.old, kind).get(item.id) is item:  # type: ignore[attr-defined]
            return self._outlines(kind)[0][self._row[item.id]]
        return _outline(item, self._move)

    def outline_now(self, item: Record) -> Any:
        """The same of a thing of the new map."""
        return _outline(item, _stay)

    def bounds(self, item: Record, moved: bool = True) -> np.ndarray:
        """Lowest and highest coordinates (2, 2) of a thing of the old map, or of the new one, in the new one."""
        shape = _outline(item, self._move if moved else _stay)
        if isinstance(item, Region):
            return np.array(shape.bounds).reshape(2, 2)
        if isinstance(item, MapObject):
            return np.array([shape[:2], shape[:2]])
        return np.array([shape.min(0), shape.max(0)])

    def _outlines(self, kind: str) -> tuple[Outlines, Outlines]:
        if kind not in self._shapes:
            old, new = (list(getattr(map, kind).values()) for map in (self.old, self.new))
            self._shapes[kind] = _all_outlines(kind, old, self._move), _all_outlines(kind, new, _stay)
        return self._shapes[kind]


def match(old: RGMap, new: RGMap, ids: Iterable[str], move: Move = lambda points: points) -> dict[str, str]:
    """New id by old id, for those of ``ids`` with one clear counterpart, whose own clear counterpart they are."""
    matcher = Matcher(old, new, move)
    return {id: found for id in dict.fromkeys(ids) if (found := matcher(id)) is not None}


def beside(one: np.ndarray, other: np.ndarray) -> float:
    """How far a line (2, 2) lies beside another one [m], over what they have in common."""
    return float(_common(one, other[None])[1][0])


def common_spans(one: np.ndarray, others: np.ndarray, aside: float) -> np.ndarray:
    """(K, 2) [m] stretches along a line (2, 2) that those of others (N, 2, 2) cover that lie within ``aside`` of it."""
    if not len(others):
        return np.zeros((0, 2))
    common, off, _ = _common(one, others)
    d = one[1] - one[0]
    length = float(np.hypot(*d))
    on = (common > 0) & (off < aside)
    along = (others[on] - one[0]) @ (d / length)
    return np.stack([np.maximum(along.min(1), 0.0), np.minimum(along.max(1), length)], 1)


def _stay(points: np.ndarray) -> np.ndarray:
    return points


def _kind_of(item: Record) -> str:
    return {Line: "lines", Region: "regions", Gateway: "gateways", MapObject: "objects"}[type(item)]


def _clear(scores: np.ndarray) -> int | None:
    """Index of the best score; None if it is low or another one comes near it."""
    best = int(np.argmax(scores))
    rest = float(np.delete(scores, best).max(initial=0.0))
    return best if scores[best] >= SAME and scores[best] - rest >= CLEAR else None


def _scored_best(piece: np.ndarray, olds: Sequence[np.ndarray], one: np.ndarray) -> bool:
    """Whether a new line lies on no other old line as well as on this one."""
    common, aside, _ = _common(piece, np.asarray(olds))
    score = common * np.clip(1 - aside / ASIDE, 0, 1)
    best = int(np.argmax(score))
    rest = float(np.delete(score, best).max(initial=0.0))
    return bool(np.array_equal(olds[best], one)) and score[best] >= (1 + CLEAR) * rest


def _outline(item: Record, move: Move) -> Any:
    """What a thing is recognised by: a region's polygon, the two ends of a line or gateway, an object's box."""
    if isinstance(item, Line):
        return move(np.array([item.start, item.end]))
    if isinstance(item, Gateway):
        return move(np.array(item.posts))
    if isinstance(item, MapObject):
        return np.array([*move(np.array([item.center[:2]]))[0], *item.size[:2]])
    assert isinstance(item, Region)
    rings = [move(np.array(ring)) for ring in (item.boundary, *item.holes)]
    return polygon(rings[0], tuple(rings[1:]))  # type: ignore[arg-type]


def _all_outlines(kind: str, items: Sequence[Any], move: Move) -> Outlines:
    """The outlines of all things of a kind; those of lines and gateways (N, 2, 2) are moved at once."""
    if kind == "regions" or not items:
        return [_outline(item, move) for item in items]
    if kind == "objects":
        return np.stack([_outline(item, move) for item in items])
    ends = np.array([(v.start, v.end) if kind == "lines" else v.posts for v in items])
    return move(ends.reshape(-1, 2)).reshape(-1, 2, 2)


def _region_scores(one: Any, others: Sequence[Any]) -> np.ndarray:
    """Intersection over union of polygons."""
    overlap = np.array([cutting.overlap(one, o).area if one.intersects(o) else 0.0 for o in others])
    whole = np.array([one.area + other.area for other in others]) - overlap
    return overlap / np.maximum(whole, 1e-9)


def _common(one: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of a line (2, 2) and others (K, 2, 2): length in common [m], how far aside there [m], length of the others.

    Direction counts: a wall has two faces.
    """
    a, b = one, others
    d = a[1] - a[0]
    length = max(float(np.hypot(*d)), 1e-9)
    u, n = d / length, np.array([-d[1], d[0]]) / length
    e = b[:, 1] - b[:, 0]
    ahead, across = e @ u, e @ n
    along, off = (b - a[0]) @ u, (b - a[0]) @ n
    low, high = np.maximum(along.min(1), 0.0), np.minimum(along.max(1), length)
    common = np.clip(high - low, 0.0, None) * (np.abs(np.arctan2(across, ahead)) < ASKEW)
    slope = across / np.where(np.abs(ahead) < 1e-9, 1e-9, ahead)
    at = off[:, 0] + slope * ((low + high) / 2 - along[:, 0])
    return common, np.where(common > 0, np.abs(at), np.inf), np.hypot(e[:, 0], e[:, 1])


def _line_scores(one: np.ndarray, others: Sequence[np.ndarray]) -> np.ndarray:
    """Common part of two lines over all of both, less where they lie aside."""
    common, aside, lengths = _common(one, np.asarray(others))
    whole = float(np.hypot(*(one[1] - one[0]))) + lengths - common
    near = np.clip((ASIDE - aside) / (ASIDE - BESIDE), 0, 1)
    return np.clip(common / np.maximum(whole, 1e-9), 0, 1) * near


def _gateway_scores(one: np.ndarray, others: Sequence[np.ndarray]) -> np.ndarray:
    """Mean distance of the posts, whichever of them comes first; those of wide openings are known less well."""
    b = np.asarray(others)
    straight, crossed = (np.hypot(*(b[:, order] - one).transpose(2, 0, 1)).mean(1) for order in ([0, 1], [1, 0]))
    widths = np.hypot(*(b[:, 1] - b[:, 0]).T)
    reach = np.maximum(REACH, np.maximum(widths, np.hypot(*(one[1] - one[0]))) / 2)
    return np.clip(1 - np.minimum(straight, crossed) / reach, 0, 1)


def _object_scores(one: np.ndarray, others: Sequence[np.ndarray]) -> np.ndarray:
    """Distance of the centres and half of the difference in size, whichever side of the box is called its length."""
    b = np.asarray(others)
    away = np.hypot(b[:, 0] - one[0], b[:, 1] - one[1])
    straight, turned = (np.hypot(b[:, i] - one[2], b[:, j] - one[3]) for i, j in ((2, 3), (3, 2)))
    return np.clip(1 - (away + np.minimum(straight, turned) / 2) / REACH, 0, 1)


_SCORES: dict[str, Callable[[Any, Sequence[Any]], np.ndarray]] = {
    "lines": _line_scores,
    "regions": _region_scores,
    "gateways": _gateway_scores,
    "objects": _object_scores,
}
