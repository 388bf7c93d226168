"""Edits: each is a frozen value that says what shall be, and a function from a map to a map.

A new edit is one class here and one word in ``AnyEdit``: journal, undo, scripting, provenance and carrying to a new run
follow from its fields and their types (``fields.py``). Consistency of the map lives in the edit; to ask whether one is
allowed is to try it.
"""

from __future__ import annotations

import math
from typing import get_args

import msgspec
import numpy as np

from rgcore.errors import EditError
from rgcore.model.boxes import fit_box
from rgcore.model.edit import Edit, drop, put, the_gateway, the_line, the_object, the_region
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
from rgcore.model.follow import Follow
from rgcore.model.records import MapObject, RGMap, replace


class ClassifyRegion(Edit, frozen=True):
    """A region is of this class: CDMA, ODMA, TOMA, CC or any other name."""

    region: RegionId
    class_: ClassName = msgspec.field(name="class")

    def change(self, map: RGMap) -> RGMap:
        return put(map, "regions", replace(the_region(map, self.region), class_=self.class_))

    def title(self, map: RGMap) -> str:
        return f"relabel {self.region} as {self.class_}"


class RenameRegion(Edit, frozen=True):
    """A region has this name."""

    region: RegionId
    name: Name

    def change(self, map: RGMap) -> RGMap:
        return put(map, "regions", replace(the_region(map, self.region), name=self.name))

    def title(self, map: RGMap) -> str:
        return f"rename {self.region} to {self.name}"


class ClassifyGateway(Edit, frozen=True):
    """A gateway is of this class: narrow_passage, junction_T, junction_L, junction_X, opening or any other name."""

    gateway: GatewayId
    class_: ClassName = msgspec.field(name="class")

    def change(self, map: RGMap) -> RGMap:
        return put(map, "gateways", replace(the_gateway(map, self.gateway), class_=self.class_))

    def title(self, map: RGMap) -> str:
        return f"relabel {self.gateway} as {self.class_}"


class RenameGateway(Edit, frozen=True):
    """A gateway has this name; the empty name takes it away."""

    gateway: GatewayId
    name: Text

    def change(self, map: RGMap) -> RGMap:
        return put(map, "gateways", replace(the_gateway(map, self.gateway), name=self.name))

    def title(self, map: RGMap) -> str:
        return f"rename {self.gateway} to {self.name}" if self.name else f"take the name off {self.gateway}"


class MoveGateway(Edit, frozen=True):
    """The posts stand here; crossing- and gateway-points are as given, or follow the posts where they are not."""

    gateway: GatewayId
    posts: tuple[Place, Place]
    crossing_points: Places | None = None
    gateway_points: Places | None = None

    def change(self, map: RGMap) -> RGMap:
        old = the_gateway(map, self.gateway)
        if math.dist(*self.posts) < 0.05:
            raise EditError(f"the posts of {self.gateway} would stand less than 5 cm apart")
        if self.gateway_points is not None and len(self.gateway_points) != len(old.regions):
            given = len(self.gateway_points)
            raise EditError(f"{self.gateway} needs {len(old.regions)} gateway-points, one a region, not {given}")
        follow = Follow(old.posts, self.posts)
        crossing, points = self.crossing_points, self.gateway_points
        return put(
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
        return drop(map, "gateways", the_gateway(map, self.gateway).id)

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
            the_line(map, line)
        if self.region is not None:
            the_region(map, self.region)
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
        return put(map, "objects", made)

    def title(self, map: RGMap) -> str:
        return f"make an object of {len(self.lines)} line{'s' * (len(self.lines) != 1)}"


class MoveObject(Edit, frozen=True):
    """The object's box stands here and is so large."""

    object: ObjectId
    center: Place3
    size: Size3
    yaw: Angle

    def change(self, map: RGMap) -> RGMap:
        moved = replace(the_object(map, self.object), center=self.center, size=self.size, yaw=self.yaw)
        return put(map, "objects", moved)

    def title(self, map: RGMap) -> str:
        return f"move {self.object}"


class LabelObject(Edit, frozen=True):
    """The object is called so; the empty label takes it away."""

    object: ObjectId
    label: Text

    def change(self, map: RGMap) -> RGMap:
        return put(map, "objects", replace(the_object(map, self.object), label=self.label))

    def title(self, map: RGMap) -> str:
        return f"label {self.object} as {self.label}" if self.label else f"take the label off {self.object}"


class DeleteObject(Edit, frozen=True):
    """There is no such object."""

    object: ObjectId

    def change(self, map: RGMap) -> RGMap:
        return drop(map, "objects", the_object(map, self.object).id)

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
    chosen = [the_line(map, id) for id in dict.fromkeys(lines)]
    if not chosen:
        raise EditError("an object needs at least one line")
    homes = [line.regions[0] for line in chosen if line.regions]
    home = max(homes, key=homes.count) if homes else None
    axes = map.regions[home].axes if home in map.regions else ()
    (x, y), (along, across), yaw = fit_box(np.array([[line.start, line.end] for line in chosen]), axes)
    return SeedObject(
        id=new_id(map, "objects"),
        lines=tuple(line.id for line in chosen),
        center=(x, y, height / 2),
        size=(along, across, height),
        yaw=yaw,
        region=home,
    ).checked()
