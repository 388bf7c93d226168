"""What is different between two maps, in the words of a person: rooms, doors, walls. By the matcher of the re-run.

Two maps that hold common scans are matched through these; how far a wall moved is measured after the one rigid motion
that fits all common scans. Maps without a common scan are laid onto one another by their walls (``align.py``).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import msgspec
import numpy as np

from rgcore.errors import RgError
from rgcore.geometry import cutting, se2
from rgcore.model.align import align
from rgcore.model.assemble import NAMES
from rgcore.model.difference import Difference, What, made, mean, point
from rgcore.model.drift import Drift
from rgcore.model.effect import LEAST, OFF, SHAPE, SIGMAS, deviation
from rgcore.model.identify import TABLES, Matcher, Move, beside, common_spans
from rgcore.model.records import Gateway, Line, Point, Region, RGMap, rounded
from rgcore.slam.trajectory import Trajectory

WALL = 0.19
"""m: a wall that has another one of its direction so near is there still; one farther off is not recognised either"""
PIECE = 0.4
"""m: shorter pieces of walls are noise of where lines end"""
DOOR = 0.25
"""m: a gateway whose middle or width changed by less is the same opening"""
PART = 0.6
"""share of a region that must lie in another one to be a part of it"""
LEAST_FIT = 0.3
"""share of walls that must lie on one another before two maps are taken for the same building"""


class Diff(msgspec.Struct, frozen=True, kw_only=True):
    """All differences; ``frame``: how the frames were joined, by ``new_from_old`` (x, y, theta); wall lengths [m]."""

    frame: str
    new_from_old: tuple[float, float, float]
    walls_added: float = 0.0
    walls_removed: float = 0.0
    differences: tuple[Difference, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.differences)

    def count(self, kind: str, what: str) -> int:
        return sum(d.kind == kind and d.what == what for d in self.differences)


class Frames(NamedTuple):
    """How an old map lies in a new one: ``move`` for recognising, ``rigid`` (3,) for measuring, and in words."""

    move: Move
    rigid: np.ndarray
    words: str


def diff(old: RGMap, new: RGMap, frames: Frames | None = None) -> Diff:
    """What is different in ``new``. Without ``frames``: those of :func:`join` without poses."""
    f = frames or join(old, new)
    work = _Work(old, new, f)
    found = [*work.regions(), *work.gateways(), *work.walls(), *work.objects()]
    lengths = [sum(math.dist(*p) for d in found for p in d.pieces if d.what == what) for what in ("added", "removed")]
    x, y, theta = (rounded(v) for v in f.rigid)
    return Diff(
        frame=f.words,
        new_from_old=(x, y, theta),
        walls_added=round(lengths[0], 2),
        walls_removed=round(lengths[1], 2),
        differences=tuple(found),
    )


def join(old: RGMap, new: RGMap, before: Trajectory | None = None, after: Trajectory | None = None) -> Frames:
    """How the frame of one map lies in that of the other: by common scans, else by walls. Raises RgError if neither."""
    if before is not None and after is not None:
        drift = Drift(before, after, bool(old.source.sha256) and old.source.sha256 == new.source.sha256)
        if drift.known:
            return Frames(drift.points, drift.rigid, "joined by the scans that both hold")
    found = align(old, new)
    if found is None or found.share < LEAST_FIT:
        fit = "" if found is None else f": at best {100 * found.share:.0f} % of their walls lie on one another"
        raise RgError(f"the two maps share no known scan and their walls do not fit{fit}; compare maps of one building")
    pose = found.new_from_old
    words = f"no common scan known: laid onto one another by their walls, {100 * found.share:.0f} % of which fit"
    return Frames(lambda points: se2.transform(pose, np.asarray(points, float)), pose, words)


class _Work:
    def __init__(self, old: RGMap, new: RGMap, frames: Frames) -> None:
        self.old, self.new, self.frames = old, new, frames
        self.matcher = Matcher(old, new, frames.move)
        self.ids = {id: found for kind in TABLES for id in getattr(old, kind) if (found := self._same(kind, id))}
        self.known = set(self.ids.values())

    def _same(self, kind: str, id: str) -> str | None:
        """The counterpart: the thing of this id where it lies on the old one, else the clear one."""
        here = getattr(self.new, kind).get(id)
        if here is not None and self.matcher.likeness(getattr(self.old, kind)[id], here) > 0.999:
            return id
        return self.matcher(id)

    def _pairs(self, kind: str) -> Iterator[tuple[Any, Any]]:
        table, other = getattr(self.old, kind), getattr(self.new, kind)
        yield from ((table[a], other[b]) for a, b in self.ids.items() if a in table)

    def _gone(self, kind: str) -> list[Any]:
        return [v for id, v in getattr(self.old, kind).items() if id not in self.ids]

    def _come(self, kind: str) -> list[Any]:
        return [v for id, v in getattr(self.new, kind).items() if id not in self.known]

    def regions(self) -> Iterator[Difference]:
        gone, come = self._gone("regions"), self._come("regions")
        was = {r.id: self.matcher.outline(r) for r in self.old.regions.values()}
        now = {r.id: self.matcher.outline_now(r) for r in self.new.regions.values()}
        told: set[str] = set()
        for r in gone:
            into = [n for n in now if _inside(now[n], was[r.id])]
            if len(into) > 1:
                told |= {r.id, *into}
                yield _region("split", was[r.id], (r,), [self.new.regions[n] for n in into])
        for n in come:
            parts = [r for r in was if _inside(was[r], now[n.id])]
            if len(parts) > 1:
                told |= {n.id, *parts}
                yield _region("merged", now[n.id], [self.old.regions[p] for p in parts], (n,))
        yield from (_region("removed", was[r.id], (r,), ()) for r in gone if r.id not in told)
        yield from (_region("added", now[r.id], (), (r,)) for r in come if r.id not in told)
        for a, b in self._pairs("regions"):
            score = self.matcher.likeness(a, b)
            if a.class_ != b.class_:
                yield _region("reclassed", now[b.id], (a,), (b,), f"{_called(b)}: {a.class_} is {b.class_} now")
            if a.name != b.name and not (_automatic(a.name) and _automatic(b.name)):
                yield _region("renamed", now[b.id], (a,), (b,), f"{b.id}: {a.name} is called {b.name} now")
            if score < SHAPE:
                text = f"{_called(b)}: {100 * score:.0f} % of its outline as before, {was[a.id].area:.1f} m² -> "
                yield _region("reshaped", now[b.id], (a,), (b,), f"{text}{now[b.id].area:.1f} m²", score)

    def gateways(self) -> Iterator[Difference]:
        for g in self._gone("gateways"):
            place = self._middle(g)
            yield made("gateways", "closed", place, (g,), (), f"{g.id} ({g.class_}, {g.width:.2f} m)", g.width)
        for g in self._come("gateways"):
            place = mean(g.posts)
            yield made("gateways", "opened", place, (), (g,), f"{g.id} ({g.class_}, {g.width:.2f} m)", g.width)
        for a, b in self._pairs("gateways"):
            off = math.dist(self._middle(a), mean(b.posts))
            if a.class_ != b.class_:
                yield made("gateways", "reclassed", mean(b.posts), (a,), (b,), f"{b.id}: {a.class_} is {b.class_} now")
            if a.name != b.name:
                text = f"{b.id}: {a.name or 'without a name'} is called {b.name or 'nothing'} now"
                yield made("gateways", "renamed", mean(b.posts), (a,), (b,), text)
            if off > DOOR:
                yield made("gateways", "moved", mean(b.posts), (a,), (b,), f"{b.id} by {off:.2f} m", off)
            elif abs(a.width - b.width) > DOOR:
                text, by = f"{b.id}: {a.width:.2f} m wide, now {b.width:.2f} m", abs(a.width - b.width)
                yield made("gateways", "reshaped", mean(b.posts), (a,), (b,), text, by)

    def walls(self) -> Iterator[Difference]:
        old = [v for v in self.old.lines.values() if not v.clutter]
        new = [v for v in self.new.lines.values() if not v.clutter]
        was = [self.matcher.outline(v) for v in old]
        now = [np.array([v.start, v.end]) for v in new]
        yield from _uncovered("removed", old, was, now)
        yield from _uncovered("added", new, now, was)
        for a, b in self._pairs("lines"):
            if a.clutter or b.clutter:
                continue
            rigid = se2.transform(self.frames.rigid, np.array([a.start, a.end]))
            off, sigma = _aside(rigid, np.array([b.start, b.end])), deviation(a, b)
            if off > max(SIGMAS * sigma, LEAST):
                text = f"{b.id} by {off:.2f} m ({off / sigma:.1f} sigma)"
                yield made("lines", "moved", mean((b.start, b.end)), (a,), (b,), text, off)

    def objects(self) -> Iterator[Difference]:
        for o in self._gone("objects"):
            yield made("objects", "removed", self._at(o.center[:2]), (o,), (), f"{o.id} {o.label}".strip())
        for o in self._come("objects"):
            yield made("objects", "added", o.center[:2], (), (o,), f"{o.id} {o.label}".strip())
        for a, b in self._pairs("objects"):
            off = math.dist(self._at(a.center[:2]), b.center[:2])
            if off > OFF:
                yield made("objects", "moved", b.center[:2], (a,), (b,), f"{b.id} by {off:.2f} m", off)
            by_hand = a.provenance.source != "auto" or b.provenance.source != "auto"
            if a.label != b.label and by_hand:  # the mapper numbers its guesses anew in every run
                text = f"{b.id}: {a.label or 'without a label'} is {b.label or 'without a label'} now"
                yield made("objects", "renamed", b.center[:2], (a,), (b,), text)

    def _at(self, place: Point) -> Point:
        return point(self.frames.move(np.array([place]))[0])

    def _middle(self, g: Gateway) -> Point:
        return mean(self.matcher.outline(g))


def _uncovered(what: What, lines: list[Line], ends: list[np.ndarray], others: list[np.ndarray]) -> Iterator[Difference]:
    """The stretches of walls that no wall of the other map lies on."""
    there = np.array(others).reshape(-1, 2, 2)
    for v, e in zip(lines, ends, strict=True):
        length = float(np.hypot(*(e[1] - e[0])))
        free = _rest(length, common_spans(e, there, WALL)) if length > 1e-6 else []
        pieces = tuple((point(e[0] + (e[1] - e[0]) * a), point(e[0] + (e[1] - e[0]) * b)) for a, b in free)
        if pieces:
            total = sum(math.dist(*p) for p in pieces)
            before, after = ((v,), ()) if what == "removed" else ((), (v,))
            text = f"{total:.2f} m of {v.id}" if total < 0.95 * length else f"{v.id} ({total:.2f} m)"
            yield made("lines", what, mean(pieces[0]), before, after, text, total, pieces)


def _rest(length: float, spans: np.ndarray) -> list[tuple[float, float]]:
    """Shares (from, to) of a line of some length that no span (K, 2) [m] covers, those long enough to count."""
    out, at = [], 0.0
    for low, high in [*sorted(map(tuple, spans)), (length, length)]:
        if low - at >= PIECE:
            out.append((at / length, low / length))
        at = max(at, high)
    return out


def _aside(a: np.ndarray, b: np.ndarray) -> float:
    """How far a line lies beside another one; where they have nothing in common, how far the middle lies off it."""
    off = beside(a, b)
    if math.isfinite(off):
        return off
    d = (b[1] - b[0]) / max(float(np.hypot(*(b[1] - b[0]))), 1e-9)
    m = a.mean(0) - b[0]
    return float(abs(d[0] * m[1] - d[1] * m[0]))


def _inside(part: Any, whole: Any) -> bool:
    return bool(part.intersects(whole) and cutting.overlap(part, whole).area > PART * part.area)


def _automatic(name: str) -> bool:
    """Whether the mapper gave a name; it numbers anew in every run."""
    words, _, number = name.rpartition(" ")
    return number.isdigit() and words in {*NAMES.values(), "Region"}


def _called(r: Region) -> str:
    return f"{r.id} {r.name}"


def _region(what: What, shape: Any, old: Any, new: Any, text: str = "", amount: float | None = None) -> Difference:
    if not text:
        names = [", ".join(_called(r) for r in side) for side in (old, new)]
        text = " -> ".join(n for n in names if n) + ("" if old and new else f" ({shape.area:.1f} m²)")
    return made("regions", what, cutting.inner_point(shape), old, new, text, amount)
