"""Which thing of one map is which thing of another? By geometry, one to one, and only where there is no doubt."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from rgcore.geometry.polygons import polygon
from rgcore.model.records import Gateway, Line, MapObject, Record, Region, RGMap

Move = Callable[[np.ndarray], np.ndarray]
"""Takes points (K, 2) [m] of the old map to where they lie in the new one."""

SAME = 0.5
"""Score from which on two things may be the same; 1 = equal."""
CLEAR = 0.2
"""By how much the best score must lead the next one."""
REACH = 1.0
"""m: posts of a gateway, or boxes of objects, that lie so far apart score 0"""
ASIDE = 0.4
"""m: lines that lie so far beside each other score 0"""
ASKEW = math.radians(15)
"""rad: lines that differ so much in direction score 0"""


def match(old: RGMap, new: RGMap, ids: Iterable[str], move: Move = lambda points: points) -> dict[str, str]:
    """New id by old id, for those of ``ids`` with one clear counterpart, whose own clear counterpart they are."""
    found: dict[str, str] = {}
    wanted = set(ids)
    for kind in _SCORES:
        before, after = getattr(old, kind), getattr(new, kind)
        if not after or wanted.isdisjoint(before):
            continue
        old_ids, new_ids = list(before), list(after)
        olds = [_outline(item, move) for item in before.values()]
        news = [_outline(item, lambda points: points) for item in after.values()]
        for i, id in enumerate(old_ids):
            if id not in wanted:
                continue
            j = _clear(_SCORES[kind](olds[i], news))
            if j is not None and _clear(_SCORES[kind](news[j], olds)) == i:
                found[id] = new_ids[j]
    return found


def _clear(scores: np.ndarray) -> int | None:
    """Index of the best score; None if it is low or another one comes near it."""
    best = int(np.argmax(scores))
    rest = float(np.delete(scores, best).max(initial=0.0))
    return best if scores[best] >= SAME and scores[best] - rest >= CLEAR else None


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


def _region_scores(one: Any, others: Sequence[Any]) -> np.ndarray:
    """Intersection over union of polygons."""
    overlap = np.array([one.intersection(other).area for other in others])
    whole = np.array([one.area + other.area for other in others]) - overlap
    return overlap / np.maximum(whole, 1e-9)


def _line_scores(one: np.ndarray, others: Sequence[np.ndarray]) -> np.ndarray:
    """Common part of two lines over all of both, less where they lie aside. Direction counts: a wall has two faces."""
    a, b = one, np.stack(others)
    d = a[1] - a[0]
    length = max(float(np.hypot(*d)), 1e-9)
    u, n = d / length, np.array([-d[1], d[0]]) / length
    e = b[:, 1] - b[:, 0]
    askew = np.abs(np.arctan2(e @ n, e @ u))
    along, aside = (b - a[0]) @ u, np.abs((b - a[0]) @ n).mean(1)
    low, high = along.min(1), along.max(1)
    common = np.clip(np.minimum(high, length) - np.maximum(low, 0.0), 0.0, None)
    share = common / np.maximum(np.maximum(high, length) - np.minimum(low, 0.0), 1e-9)
    return share * np.clip(1 - aside / ASIDE, 0, 1) * (askew < ASKEW)


def _gateway_scores(one: np.ndarray, others: Sequence[np.ndarray]) -> np.ndarray:
    """Mean distance of the posts, whichever of them comes first."""
    b = np.stack(others)
    straight, crossed = (np.hypot(*(b[:, order] - one).transpose(2, 0, 1)).mean(1) for order in ([0, 1], [1, 0]))
    return np.clip(1 - np.minimum(straight, crossed) / REACH, 0, 1)


def _object_scores(one: np.ndarray, others: Sequence[np.ndarray]) -> np.ndarray:
    """Distance of the centres and half of the difference in size."""
    d = np.stack(others) - one
    return np.clip(1 - (np.hypot(d[:, 0], d[:, 1]) + np.hypot(d[:, 2], d[:, 3]) / 2) / REACH, 0, 1)


_SCORES: dict[str, Callable[[Any, Sequence[Any]], np.ndarray]] = {
    "lines": _line_scores,
    "regions": _region_scores,
    "gateways": _gateway_scores,
    "objects": _object_scores,
}
