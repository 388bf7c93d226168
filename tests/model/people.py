"""Edits as people make them: sound, on things that one sees and clicks, of every kind."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np

from rgcore.errors import EditError
from rgcore.model import draft, edits
from rgcore.model.edits import Edit, Several
from rgcore.model.fields import PREFIX
from rgcore.model.history import Do, History, step
from rgcore.model.lint import lint
from rgcore.model.records import Line, RGMap

AT = "2026-01-01T00:00:00Z"


def edits_by_people(base: RGMap, rng: random.Random, count: int) -> History:
    """A history of ``count`` edits that the map took, of all kinds in turn."""
    history, order = History.of(base), list(MAKERS)
    tries = 0
    while len(history.done) < count and tries < 50 * count:
        if tries % len(order) == 0:
            rng.shuffle(order)
        tries += 1
        try:
            edit = order[tries % len(order)](_Person(history.map, base, rng)).checked()
            after = step(history, Do(number=len(history.done) + 1, at=AT, by="ann", edit=edit))  # type: ignore[arg-type]
        except (EditError, IndexError):
            continue
        if after.done[-1].patch:
            history = after
    return history


class _Person:
    def __init__(self, map: RGMap, base: RGMap, rng: random.Random) -> None:
        self.map, self.base, self.rng = map, base, rng

    def one(self, kind: str) -> Any:
        """A thing: long lines and large regions are clicked more often."""
        items = list(getattr(self.map, kind).values())
        if kind == "lines":
            return self.rng.choices(items, [length(v) ** 1.0 for v in items])[0]
        return self.rng.choice(items)

    def new(self, kind: str) -> str:
        return f"{PREFIX[kind]}u{self.rng.getrandbits(32):08x}"

    def by(self, p: Any, spread: float) -> tuple[float, float]:
        return p[0] + self.rng.gauss(0, spread), p[1] + self.rng.gauss(0, spread)

    def beside(self, line: Line, count: int) -> tuple[str, ...]:
        """The lines nearest to one, that first: what a rectangle catches."""
        a = middle(line)
        near = sorted(self.map.lines.values(), key=lambda v: math.dist(middle(v), a))
        return tuple(v.id for v in near[:count])

    def named(self, edit: Any) -> Any:
        """The edit of a draft with ids of the random generator."""
        kinds = {v: k for k, v in PREFIX.items()}
        new = {"id": self.new(kinds[edit.id[0]])}
        if getattr(edit, "gateway", None):
            new["gateway"] = self.new("gateways")
        return msgspec.structs.replace(edit, **new)


def length(line: Line) -> float:
    return math.dist(line.start, line.end)


def middle(line: Line) -> tuple[float, float]:
    return (line.start[0] + line.end[0]) / 2, (line.start[1] + line.end[1]) / 2


def _split(p: _Person) -> Edit:
    r = p.one("regions")
    (x, y), yaw, half = r.box.center, r.box.yaw, r.box.size[1] / 2 + 0.5
    s = p.rng.uniform(-0.25, 0.25) * r.box.size[0]
    c, t = math.cos(yaw), math.sin(yaw)
    a, b = ((x + s * c - e * t, y + s * t + e * c) for e in (half, -half))
    return p.named(draft.split_region(p.map, r.id, [a, b], gateway=p.rng.random() < 0.5))


def _reshape(p: _Person) -> Edit:
    r = p.one("regions")
    i = p.rng.randrange(len(r.boundary))
    ring = (*r.boundary[:i], p.by(r.boundary[i], 0.3), *r.boundary[i + 1 :])
    return edits.ReshapeRegion(region=r.id, boundary=ring, holes=r.holes)


def _merge(p: _Person) -> Edit:
    return edits.MergeRegions(regions=p.one("gateways").regions)


def _niche(p: _Person) -> Edit:
    """A closet that the laser saw little of, on the far side of a wall."""
    v = p.one("lines")
    if length(v) < 1:
        raise EditError("too short")
    a, b = np.array(v.start), np.array(v.end)
    u = (b - a) / length(v)
    n = np.array([u[1], -u[0]])
    ring = tuple(tuple(map(float, q)) for q in (a + 0.1 * n, a + 1.5 * n, b + 1.5 * n, b + 0.1 * n))
    return edits.AddRegion(id=p.new("regions"), boundary=ring, name="Closet")


def _move_gateway(p: _Person) -> Edit:
    g = p.one("gateways")
    return edits.MoveGateway(gateway=g.id, posts=(p.by(g.posts[0], 0.15), p.by(g.posts[1], 0.15)))


def _second_door(p: _Person) -> Edit:
    g = p.one("gateways")
    (ax, ay), (bx, by) = g.posts
    d = np.array([bx - ax, by - ay]) / max(g.width, 1e-9)
    a, b = np.array(g.posts[1]) + 0.8 * d, np.array(g.posts[1]) + 1.7 * d
    return p.named(draft.add_gateway(p.map, (tuple(a), tuple(b)), regions=g.regions))


def _wall(p: _Person) -> Edit:
    v, w = p.one("lines"), p.one("lines")
    near = [w for w in p.map.lines.values() if 0.5 < math.dist(v.end, w.start) < 3]
    return p.named(draft.draw_wall(p.map, v.end, p.rng.choice(near or [w]).start))


def _move_line(p: _Person) -> Edit:
    v = p.one("lines")
    d = np.subtract(v.end, v.start) / max(length(v), 1e-9)
    end = tuple(np.array(v.end) + p.rng.uniform(-0.2, 0.5) * d)
    return edits.MoveLine(line=v.id, start=v.start, end=end)


def _join(p: _Person) -> Edit:
    v = p.one("lines")
    for id in p.beside(v, 12)[1:]:
        try:
            edit = edits.JoinLines(lines=(v.id, id))
            edit.apply(p.map, p.base)
            return edit
        except EditError:
            continue
    raise EditError("none to join")


def _box(p: _Person) -> dict[str, Any]:
    x, y = draft.place_of(p.map, p.one("regions").id)
    return {"center": (*p.by((x, y), 0.5), 0.5), "size": (1.0, 0.5, 1.0), "yaw": p.rng.uniform(-1.5, 1.5)}


def _seed(p: _Person) -> Edit:
    v = p.one("lines")
    return p.named(draft.object_from_lines(p.map, p.beside(v, p.rng.randint(1, 3)), label="desk"))


def _revert(p: _Person) -> Edit:
    touched = [
        id
        for k in ("regions", "gateways", "lines")
        for id, v in getattr(p.base, k).items()
        if getattr(p.map, k).get(id) is not v
    ]
    return edits.RevertToAutomatic(item=p.rng.choice(touched))


def _ignore(p: _Person) -> Edit:
    f = p.rng.choice(lint(p.map))
    return edits.IgnoreFinding(code=f.code, items=f.items)


def _relabel(p: _Person) -> Edit:
    some = p.rng.sample(sorted(p.map.regions), 3)
    return Several(name="relabel", edits=tuple(edits.ClassifyRegion(region=r, class_="office") for r in some))


def _room(p: _Person) -> Edit:
    r = p.one("regions").id
    made = edits.RenameRegion(region=r, name="Lab"), edits.ClassifyRegion(region=r, class_="lab")
    return Several(name="make it a lab", edits=made)


def _any(p: _Person) -> str:
    return p.one(p.rng.choice(["regions", "gateways", "lines", "objects"])).id


MAKERS: list[Callable[[_Person], Edit]] = [
    *[lambda p: edits.RenameRegion(region=p.one("regions").id, name=f"Room {p.rng.randrange(400)}")] * 3,
    *[lambda p: edits.ClassifyRegion(region=p.one("regions").id, class_=p.rng.choice(["office", "lab", "CC"]))] * 3,
    *[_split, _split, _merge, _merge, _reshape, _niche],
    lambda p: edits.DeleteRegion(region=p.one("regions").id),
    *[lambda p: edits.ClassifyGateway(gateway=p.one("gateways").id, class_=p.rng.choice(["opening", "door"]))] * 2,
    lambda p: edits.RenameGateway(gateway=p.one("gateways").id, name="Main door"),
    *[_move_gateway, _second_door],
    lambda p: edits.MoveGatewayPoints(gateway=(g := p.one("gateways")).id, crossing_points=(p.by(g.posts[0], 0.2),)),
    lambda p: edits.AssignGateway(gateway=(g := p.one("gateways")).id, regions=g.regions[::-1]),
    *[lambda p: edits.DeleteGateway(gateway=p.one("gateways").id)] * 2,
    *[_wall, _wall, _move_line, _join],
    lambda p: edits.SplitLine(line=(v := p.one("lines")).id, at=p.by(middle(v), 0.1), id=p.new("lines")),
    lambda p: draft.align_lines(p.map, p.beside(p.one("lines"), 2)),
    *[lambda p: edits.MarkClutter(lines=p.beside(p.one("lines"), p.rng.randint(1, 3)))] * 2,
    lambda p: edits.AssignLines(lines=(p.one("lines").id,), region=p.one("regions").id),
    *[lambda p: edits.DeleteLines(lines=p.beside(p.one("lines"), p.rng.randint(1, 3)))] * 2,
    *[_seed, _seed],
    lambda p: edits.AddObject(id=p.new("objects"), label="plant", **_box(p)),
    lambda p: edits.MoveObject(object=(o := p.one("objects")).id, center=o.center, size=o.size, yaw=o.yaw + 0.1),
    *[lambda p: edits.LabelObject(object=p.one("objects").id, label="shelf")] * 2,
    lambda p: edits.ConfirmObject(object=p.one("objects").id),
    lambda p: edits.RejectObject(object=p.one("objects").id),
    lambda p: edits.DeleteObject(object=p.one("objects").id),
    *[lambda p: p.named(draft.note_on(p.map, "look here", _any(p)))] * 2,
    lambda p: edits.AddNote(id=p.new("notes"), text="rewire", place=p.by(draft.place_of(p.map, _any(p)), 1.0)),
    lambda p: edits.WriteNote(note=p.one("notes").id, text="done"),
    lambda p: edits.MoveNote(note=(n := p.one("notes")).id, place=p.by(n.place, 0.5)),
    lambda p: edits.DeleteNote(note=p.one("notes").id),
    *[lambda p: edits.Confirm(items=tuple({p.one("regions").id, p.one("gateways").id}))] * 3,
    lambda p: edits.Confirm(items=(p.one("lines").id,)),
    lambda p: edits.Unconfirm(items=(p.rng.choice([r.id for r in p.map.regions.values() if r.provenance.confirmed]),)),
    *[_revert, _ignore, _relabel, _room],
    lambda p: edits.HeedFinding(code=(f := p.one("ignored")).code, items=f.items),
]
