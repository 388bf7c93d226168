"""Random edits of all kinds, such as a person may make: most are sound, some a map refuses."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import msgspec

from rgcore.errors import EditError
from rgcore.model import draft
from rgcore.model.edits import (
    AddBackdrop,
    AddNote,
    AddObject,
    AddRegion,
    AlignBackdrop,
    AssignGateway,
    AssignLines,
    ClassifyGateway,
    ClassifyRegion,
    Confirm,
    ConfirmObject,
    DeleteBackdrop,
    DeleteGateway,
    DeleteLines,
    DeleteNote,
    DeleteObject,
    DeleteRegion,
    Edit,
    HeedFinding,
    IgnoreFinding,
    JoinLines,
    LabelObject,
    MarkClutter,
    MergeRegions,
    MoveGateway,
    MoveGatewayPoints,
    MoveLine,
    MoveNote,
    MoveObject,
    RejectObject,
    RenameGateway,
    RenameRegion,
    ReshapeRegion,
    RevertToAutomatic,
    Several,
    SplitLine,
    Unconfirm,
    WriteNote,
)
from rgcore.model.fields import PREFIX
from rgcore.model.records import RGMap


def random_edit(map: RGMap, base: RGMap, rng: random.Random) -> Edit:
    """An edit of a random kind on random things of a map. Raises EditError where the map has none of its kind."""
    return rng.choice(MAKERS)(_Chance(map, base, rng))


class _Chance:
    """What a maker draws from."""

    def __init__(self, map: RGMap, base: RGMap, rng: random.Random) -> None:
        self.map, self.base, self.rng = map, base, rng

    def one(self, kind: str) -> str:
        ids = list(getattr(self.map, kind))
        if not ids:
            raise EditError(f"no {kind} left")
        return self.rng.choice(ids)

    def some(self, kind: str) -> tuple[str, ...]:
        ids = list(getattr(self.map, kind))
        return tuple(self.rng.sample(ids, min(len(ids), self.rng.randint(1, 3)))) or (self.one(kind),)

    def any(self) -> str:
        return self.one(self.rng.choice(["lines", "regions", "gateways", "objects"]))

    def new(self, kind: str) -> str:
        return f"{PREFIX[kind]}u{self.rng.getrandbits(32):08x}"

    def near(self, id: str | None = None, spread: float = 1.5) -> tuple[float, float]:
        x, y = draft.place_of(self.map, self.any() if id is None else id)
        return round(x + self.rng.gauss(0, spread), 3), round(y + self.rng.gauss(0, spread), 3)

    def box(self) -> dict[str, Any]:
        x, y = self.near()
        return {"center": (x, y, 0.5), "size": (1.0, 0.5, 1.0), "yaw": round(self.rng.uniform(-3, 3), 3)}

    def laid(self) -> dict[str, Any]:
        return {"center": self.near(), "yaw": round(self.rng.uniform(-3, 3), 3), "length": 12.5}

    def rectangle(self) -> tuple[tuple[float, float], ...]:
        (x, y), w, h = self.near(), self.rng.uniform(0.5, 4), self.rng.uniform(0.5, 4)
        return ((x, y), (x + w, y), (x + w, y + h), (x, y + h))

    def nudged(self, ring: tuple) -> tuple:
        i, by = self.rng.randrange(len(ring)), self.rng.choice([0.1, 0.5, 1.5])
        x, y = ring[i]
        return (*ring[:i], (x + self.rng.uniform(-by, by), y + self.rng.uniform(-by, by)), *ring[i + 1 :])


def _split(c: _Chance) -> Edit:
    r = c.one("regions")
    edit = draft.split_region(c.map, r, [c.near(r), c.near(r)], gateway=c.rng.random() < 0.5)
    return _seeded(edit, c)


def _seeded(edit: Any, c: _Chance) -> Any:
    """The edit with ids of the random generator instead of chance, so that a failure can be seen again."""
    new = {"id": c.new({"l": "lines", "r": "regions", "g": "gateways", "o": "objects", "n": "notes"}[edit.id[0]])}
    if getattr(edit, "gateway", None):
        new["gateway"] = c.new("gateways")
    return msgspec.structs.replace(edit, **new)


def _reshape(c: _Chance) -> Edit:
    r = c.map.regions[c.one("regions")]
    return ReshapeRegion(region=r.id, boundary=c.nudged(r.boundary), holes=r.holes)


def _merge(c: _Chance) -> Edit:
    if c.map.gateways and c.rng.random() < 0.7:
        return MergeRegions(regions=c.map.gateways[c.one("gateways")].regions)
    return MergeRegions(regions=(c.one("regions"), c.one("regions")))


def _several(c: _Chance) -> Edit:
    edits = [m(c) for m in c.rng.choices(MAKERS[:-1], k=2)]
    return Several(name="both", edits=tuple(edits))


MAKERS: list[Callable[[_Chance], Edit]] = [
    lambda c: ClassifyRegion(region=c.one("regions"), class_=c.rng.choice(["CC", "TOMA", "lab"])),
    lambda c: RenameRegion(region=c.one("regions"), name=c.rng.choice(["Lab", "Room 1", "Küche"])),
    _reshape,
    _reshape,
    _split,
    _split,
    _merge,
    lambda c: AddRegion(id=c.new("regions"), boundary=c.rectangle()),
    lambda c: DeleteRegion(region=c.one("regions")),
    lambda c: ClassifyGateway(gateway=c.one("gateways"), class_=c.rng.choice(["opening", "junction_T"])),
    lambda c: RenameGateway(gateway=c.one("gateways"), name=c.rng.choice(["", "Main door"])),
    lambda c: MoveGateway(gateway=(g := c.one("gateways")), posts=(c.near(g, 0.5), c.near(g, 0.5))),
    lambda c: MoveGatewayPoints(gateway=(g := c.one("gateways")), crossing_points=(c.near(g, 0.2),)),
    lambda c: _seeded(draft.add_gateway(c.map, (c.near(), c.near())), c),
    lambda c: AssignGateway(gateway=(g := c.one("gateways")), regions=c.map.gateways[g].regions[::-1]),
    lambda c: AssignGateway(gateway=c.one("gateways"), regions=c.some("regions")),
    lambda c: DeleteGateway(gateway=c.one("gateways")),
    lambda c: _seeded(draft.draw_wall(c.map, c.near(), c.near()), c),
    lambda c: MoveLine(line=(v := c.one("lines")), start=c.near(v), end=c.near(v)),
    lambda c: JoinLines(lines=c.some("lines")),
    lambda c: SplitLine(line=(v := c.one("lines")), at=c.near(v, 0.3), id=c.new("lines")),
    lambda c: draft.align_lines(c.map, c.some("lines")),
    lambda c: MarkClutter(lines=c.some("lines"), clutter=c.rng.random() < 0.7),
    lambda c: AssignLines(lines=c.some("lines"), region=c.rng.choice([None, c.one("regions")])),
    lambda c: DeleteLines(lines=c.some("lines")),
    lambda c: _seeded(draft.object_from_lines(c.map, c.some("lines")), c),
    lambda c: AddObject(id=c.new("objects"), region=c.one("regions"), **c.box()),
    lambda c: MoveObject(object=c.one("objects"), **c.box()),
    lambda c: LabelObject(object=c.one("objects"), label="shelf"),
    lambda c: ConfirmObject(object=c.one("objects")),
    lambda c: RejectObject(object=c.one("objects")),
    lambda c: DeleteObject(object=c.one("objects")),
    lambda c: AddNote(id=c.new("notes"), text="look", place=c.near(), item=c.any()),
    lambda c: _seeded(draft.note_on(c.map, "look", c.any()), c),
    lambda c: WriteNote(note=c.one("notes"), text="again"),
    lambda c: MoveNote(note=c.one("notes"), place=c.near()),
    lambda c: DeleteNote(note=c.one("notes")),
    lambda c: AddBackdrop(id=c.new("backdrops"), name="plan.png", sha256="0" * 64, form="png", size=(4, 3), **c.laid()),
    lambda c: AlignBackdrop(backdrop=c.one("backdrops"), **c.laid()),
    lambda c: DeleteBackdrop(backdrop=c.one("backdrops")),
    lambda c: Confirm(items=(c.any(), c.any())),
    lambda c: Unconfirm(items=(c.any(),)),
    lambda c: RevertToAutomatic(item=c.rng.choice([k for t in ("regions", "gateways") for k in getattr(c.base, t)])),
    lambda c: RevertToAutomatic(item=c.rng.choice([k for t in ("lines", "objects") for k in getattr(c.base, t)])),
    lambda c: IgnoreFinding(code="duplicate-name", items=(c.one("regions"),)),
    lambda c: HeedFinding(code=(f := c.map.ignored[c.one("ignored")]).code, items=f.items),
    _several,
]
