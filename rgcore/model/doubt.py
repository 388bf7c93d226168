"""Doubt: the work list of a review. What is least sure comes first, with the reason; what is confirmed is off it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from rgcore.model.draft import place_of
from rgcore.model.lint import Finding
from rgcore.model.records import Gateway, Line, MapObject, Point, Region, RGMap

SURE = 0.9
"""Class score, confidence of a gateway or object: above it there is little doubt."""
AMBIGUOUS = 0.2
"""By how much the best class leads where the runner-up is no rival."""
COARSE = 0.15
"""m: acc(R) of a region that is drawn well lies below it"""
ROUGH = 0.05
"""m: residual of a line that is one straight wall lies below it"""
LINT = 0.7
"""Doubt about what the lint found something about,"""
SLIGHT = {"stray-line": 0.15, "duplicate-name": 0.3}
"""and where it matters less: a scrap of wall outside of all regions waits until the rooms are right."""


@dataclass(frozen=True)
class Doubt:
    """An item to check: ``score`` in (0, 1], 1 = surely wrong; ``reasons`` in words, the weightiest first."""

    item: str
    kind: str
    score: float
    reasons: tuple[str, ...]
    place: Point


def work_list(map: RGMap, findings: Iterable[Finding] = (), everything: bool = False) -> list[Doubt]:
    """Items that are to be checked, the most doubtful first; equals in the order of the map.

    ``findings``: of the lint. ``everything``: regions, gateways and objects without any doubt as well, at the end.
    """
    said: dict[str, list[tuple[float, str]]] = defaultdict(list)
    for f in findings:
        said[f.items[0]].append((SLIGHT.get(f.code, LINT), f.text))
    out = []
    for kind in ("regions", "gateways", "objects", "lines"):
        for item in getattr(map, kind).values():
            reasons = sorted([*_reasons(item), *said.get(item.id, ())], key=lambda r: -r[0])
            if item.provenance.confirmed or not (reasons or (everything and kind != "lines")):
                continue
            out.append(
                Doubt(
                    item=item.id,
                    kind=kind,
                    score=_together([score for score, _ in reasons]),
                    reasons=tuple(text for _, text in reasons),
                    place=place_of(map, item.id),
                )
            )
    return sorted(out, key=lambda d: -d.score)


def next_after(doubts: Sequence[Doubt], item: str | None) -> Doubt | None:
    """The one to look at after an item: the next of the list, the first after the last or an item that is not on it."""
    ids = [d.item for d in doubts]
    at = ids.index(item) + 1 if item in ids else 0
    return doubts[at % len(doubts)] if doubts else None


def _together(scores: Sequence[float]) -> float:
    """The chance that any of several independent doubts is right."""
    right = 1.0
    for s in scores:
        right *= 1 - s
    return round(1 - right, 4)


def _reasons(item: Region | Gateway | MapObject | Line) -> list[tuple[float, str]]:
    if isinstance(item, Region):
        return [*_class_doubt(item), *_accuracy_doubt(item)]
    if isinstance(item, Gateway):
        return _confidence_doubt(item.confidence, f"a gateway with {100 * item.confidence:.0f} % only") + (
            [] if item.passed or item.provenance.source == "human" else [(0.1, "seen but never driven through")]
        )
    if isinstance(item, MapObject):
        return _confidence_doubt(item.confidence, f"an object with {100 * item.confidence:.0f} % only")
    if item.residual is not None and item.residual > ROUGH:
        return [(0.3, f"its segments lie {100 * item.residual:.0f} cm off: more than one wall?")]
    return []


def _class_doubt(region: Region) -> list[tuple[float, str]]:
    """How unsure the mapper's class is; none where a person gave another one."""
    ranked = sorted(region.class_scores.items(), key=lambda s: -s[1])
    if not ranked or ranked[0][0] != region.class_:
        return []
    (best, score), (rival, other) = ranked[0], ranked[1] if len(ranked) > 1 else ("", 0.0)
    if score - other < AMBIGUOUS:
        return [(1 - score, f"{best} ({100 * score:.0f} %) or {rival} ({100 * other:.0f} %)?")]
    return [(1 - score, f"{best} with {100 * score:.0f} % only")] if score < SURE else []


def _accuracy_doubt(region: Region) -> list[tuple[float, str]]:
    if region.provenance.source == "human":
        return []
    if region.accuracy is None:
        return [(0.2, "never driven: seen from outside only")]
    if region.accuracy <= COARSE:
        return []
    return [(min(0.6, region.accuracy), f"drawn to {100 * region.accuracy:.0f} cm only")]


def _confidence_doubt(confidence: float, text: str) -> list[tuple[float, str]]:
    return [(1 - confidence, text)] if confidence < SURE else []
