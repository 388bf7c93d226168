"""Edits: each is a frozen value that says what shall be, and a function from a map to a map.

A new edit is one class here and one word in ``AnyEdit``: journal, undo, scripting, provenance and carrying to a new run
follow from its fields and their types (``fields.py``). Consistency of the map lives in the edit; to ask whether one is
allowed is to try it.
"""

from __future__ import annotations

import math
from typing import Any, TypeVar, get_args

import msgspec
import numpy as np

from rgcore.errors import EditError
from rgcore.model.boxes import fit_box
from rgcore.model.fields import (
    Angle,
    ClassName,
    GatewayId,
    LineIds,
    Name,
    NewObjectId,
    ObjectId,
    Place,
    Place3,
    Places,
    RegionId,
    Size3,
    Text,
    new_id,
    refusal,
)
from rgcore.model.records import Gateway, MapObject, Point, Region, RGMap, replace

E = TypeVar("E", bound="Edit")


class Edit(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag=True, tag_field="edit"):
    """Base of all edits: subclasses give ``change`` and ``title``."""

    def apply(self, map: RGMap) -> RGMap:
        """The map with this edit. Raises EditError with a sentence if a value is out of bounds or the map refuses."""
        return self.checked().change(map)

    def checked(self: E) -> E:
        """The same edit as the journal will give it back, every value within its bounds. Raises EditError."""
        try:
            return msgspec.json.decode(msgspec.json.encode(self, enc_hook=_plain), type=type(self))
        except msgspec.ValidationError as e:
            raise refusal(type(self), e) from e
        except (TypeError, ValueError) as e:
            raise EditError(f"{type(self).__name__}: {e}") from e

    def change(self, map: RGMap) -> RGMap:
        raise NotImplementedError

    def title(self, map: RGMap) -> str:
        """What the edit does, for the undo button; ``map`` is the one that it is applied to."""
        raise NotImplementedError


class ClassifyRegion(Edit, frozen=True):
    """A region is of this class: CDMA, ODMA, TOMA, CC or any other name."""

    region: RegionId
    class_: ClassName = msgspec.field(name="class")

    def change(self, map: RGMap) -> RGMap:
        return _with(map, "regions", replace(_region(map, self.region), class_=self.class_))

    def title(self, map: RGMap) -> str:
        return f"relabel {self.region} as {self.class_}"


class RenameRegion(Edit, frozen=True):
    """A region has this name."""

    region: RegionId
    name: Name

    def change(self, map: RGMap) -> RGMap:
        return _with(map, "regions", replace(_region(map, self.region), name=self.name))

    def title(self, map: RGMap) -> str:
        return f"rename {self.region} to {self.name}"


class ClassifyGateway(Edit, frozen=True):
    """A gateway is of this class: narrow_passage, junction_T, junction_L, junction_X, opening or any other name."""

    gateway: GatewayId
    class_: ClassName = msgspec.field(name="class")

    def change(self, map: RGMap) -> RGMap:
        return _with(map, "gateways", replace(_gateway(map, self.gateway), class_=self.class_))

    def title(self, map: RGMap) -> str:
        return f"relabel {self.gateway} as {self.class_}"


class RenameGateway(Edit, frozen=True):
    """A gateway has this name; the empty name takes it away."""

    gateway: GatewayId
    name: Text

    def change(self, map: RGMap) -> RGMap:
        return _with(map, "gateways", replace(_gateway(map, self.gateway), name=self.name))

    def title(self, map: RGMap) -> str:
        return f"rename {self.gateway} to {self.name}" if self.name else f"take the name off {self.gateway}"


class MoveGateway(Edit, frozen=True):
    """The posts stand here; crossing- and gateway-points are as given, or follow the posts where they are not."""

    gateway: GatewayId
    posts: tuple[Place, Place]
    crossing_points: Places | None = None
    gateway_points: Places | None = None

    def change(self, map: RGMap) -> RGMap:
        old = _gateway(map, self.gateway)
        if math.dist(*self.posts) < 0.05:
            raise EditError(f"the posts of {self.gateway} would stand less than 5 cm apart")
        if self.gateway_points is not None and len(self.gateway_points) != len(old.regions):
            given = len(self.gateway_points)
            raise EditError(f"{self.gateway} needs {len(old.regions)} gateway-points, one a region, not {given}")
        follow = _Follow(old.posts, self.posts)
        crossing, points = self.crossing_points, self.gateway_points
        return _with(
            map,
            "gateways",
            replace(
                old,
                posts=self.posts,
                crossing_points=follow.points(old.crossing_points) if crossing is None else crossing,
                gateway_points=follow.points(old.gateway_points) if points is None else points,
                traversal_directions=follow.directions(old.traversal_directions),
            ),
        )

    def title(self, map: RGMap) -> str:
        return f"move {self.gateway}"


class DeleteGateway(Edit, frozen=True):
    """There is no such gateway."""

    gateway: GatewayId

    def change(self, map: RGMap) -> RGMap:
        return _without(map, "gateways", _gateway(map, self.gateway).id)

    def title(self, map: RGMap) -> str:
        return f"delete {self.gateway}"


class SeedObject(Edit, frozen=True):
    """There is an object over these lines; the box stands in the edit, so that it replays to the same box."""

    id: NewObjectId
    lines: LineIds
    center: Place3
    size: Size3
    yaw: Angle
    label: Text = ""
    region: RegionId | None = None

    def change(self, map: RGMap) -> RGMap:
        if self.id in map.objects:
            raise EditError(f"there is already an object {self.id} in this map")
        if len(set(self.lines)) < len(self.lines):
            raise EditError("a line is named twice")
        for line in self.lines:
            _item(map, "lines", "line", line)
        if self.region is not None:
            _region(map, self.region)
        made = MapObject(
            id=self.id,
            label=self.label,
            center=self.center,
            size=self.size,
            yaw=self.yaw,
            lines=self.lines,
            region=self.region,
            confidence=1.0,
        )
        return _with(map, "objects", made)

    def title(self, map: RGMap) -> str:
        return f"make an object of {len(self.lines)} line{'s' * (len(self.lines) != 1)}"


class MoveObject(Edit, frozen=True):
    """The object's box stands here and is so large."""

    object: ObjectId
    center: Place3
    size: Size3
    yaw: Angle

    def change(self, map: RGMap) -> RGMap:
        moved = replace(_object(map, self.object), center=self.center, size=self.size, yaw=self.yaw)
        return _with(map, "objects", moved)

    def title(self, map: RGMap) -> str:
        return f"move {self.object}"


class LabelObject(Edit, frozen=True):
    """The object is called so; the empty label takes it away."""

    object: ObjectId
    label: Text

    def change(self, map: RGMap) -> RGMap:
        return _with(map, "objects", replace(_object(map, self.object), label=self.label))

    def title(self, map: RGMap) -> str:
        return f"label {self.object} as {self.label}" if self.label else f"take the label off {self.object}"


class DeleteObject(Edit, frozen=True):
    """There is no such object."""

    object: ObjectId

    def change(self, map: RGMap) -> RGMap:
        return _without(map, "objects", _object(map, self.object).id)

    def title(self, map: RGMap) -> str:
        return f"delete {self.object}"


AnyEdit = (
    ClassifyRegion
    | RenameRegion
    | ClassifyGateway
    | RenameGateway
    | MoveGateway
    | DeleteGateway
    | SeedObject
    | MoveObject
    | LabelObject
    | DeleteObject
)
EDITS: dict[str, type[Edit]] = {e.__name__: e for e in get_args(AnyEdit)}
"""Every edit by its name in the journal."""


def decode_edit(text: str | bytes) -> AnyEdit:
    """An edit from its JSON: ``{"edit": "RenameRegion", "region": "r3", "name": "Lab"}``. Raises EditError."""
    try:
        raw = msgspec.json.decode(text)
    except (msgspec.DecodeError, ValueError) as e:
        raise EditError(f"not JSON: {e}") from e
    kind = raw.get("edit") if isinstance(raw, dict) else None
    if not isinstance(kind, str) or kind not in EDITS:
        raise EditError(f"unknown edit {kind!r}; known are {', '.join(EDITS)}")
    try:
        return msgspec.convert(raw, EDITS[kind]).checked()  # type: ignore[return-value]
    except msgspec.ValidationError as e:
        raise refusal(EDITS[kind], e) from e


def object_from_lines(map: RGMap, lines: tuple[str, ...] | list[str], height: float = 1.0) -> SeedObject:
    """The edit that makes a box of ``height`` [m] over lines: the smallest rectangle along one of them, on the floor.

    Raises EditError if there is no such line.
    """
    chosen = [_item(map, "lines", "line", id) for id in dict.fromkeys(lines)]
    if not chosen:
        raise EditError("an object needs at least one line")
    homes = [line.regions[0] for line in chosen if line.regions]
    home = max(homes, key=homes.count) if homes else None
    axes = map.regions[home].axes if home in map.regions else ()
    (x, y), (along, across), yaw = fit_box(np.array([[line.start, line.end] for line in chosen]), axes)
    return SeedObject(
        id=new_id(map, "objects"),
        lines=tuple(line.id for line in chosen),
        center=(x, y, round(height / 2, 6)),
        size=(along, across, height),
        yaw=yaw,
        region=home,
    ).checked()


class _Follow:
    """Takes points along when the posts move: stretched along the opening, rigid across it."""

    def __init__(self, old: tuple[Point, Point], new: tuple[Point, Point]) -> None:
        a, b = np.array(old), np.array(new)
        self.mid, self.new_mid = a.mean(0), b.mean(0)
        u, v = a[1] - a[0], b[1] - b[0]
        self.stretch = float(np.hypot(*v) / max(np.hypot(*u), 1e-9))
        turn = math.atan2(v[1], v[0]) - math.atan2(u[1], u[0])
        # two posts have no order: by at most a quarter turn, so that no gateway-point changes sides
        self.turn = (turn + math.pi / 2) % math.pi - math.pi / 2
        self.along = u / max(np.hypot(*u), 1e-9)

    def points(self, points: tuple[Point, ...]) -> tuple[Point, ...]:
        c, s = math.cos(self.turn), math.sin(self.turn)
        out = []
        for p in points:
            d = np.array(p) - self.mid
            d = d + (self.stretch - 1) * (d @ self.along) * self.along
            x, y = self.new_mid + np.array([c * d[0] - s * d[1], s * d[0] + c * d[1]])
            out.append((round(float(x), 6), round(float(y), 6)))
        return tuple(out)

    def directions(self, angles: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(round(math.remainder(a + self.turn, 2 * math.pi), 6) for a in angles)


def _plain(value: Any) -> Any:
    """NumPy values in an edit that a script made, as plain ones."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is no value for an edit")


def _item(map: RGMap, kind: str, word: str, id: str) -> Any:
    try:
        return getattr(map, kind)[id]
    except KeyError:
        raise EditError(f"there is no {word} {id} in this map") from None


def _region(map: RGMap, id: str) -> Region:
    return _item(map, "regions", "region", id)


def _gateway(map: RGMap, id: str) -> Gateway:
    return _item(map, "gateways", "gateway", id)


def _object(map: RGMap, id: str) -> MapObject:
    return _item(map, "objects", "object", id)


def _with(map: RGMap, kind: str, item: Any) -> RGMap:
    """The map with one item set; the same map if it is equal already."""
    items = getattr(map, kind)
    return map if items.get(item.id) == item else replace(map, **{kind: {**items, item.id: item}})


def _without(map: RGMap, kind: str, id: str) -> RGMap:
    return replace(map, **{kind: {k: v for k, v in getattr(map, kind).items() if k != id}})
