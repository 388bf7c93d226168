"""Edits of objects: boxes over groups of lines, and the mapper's guesses at them."""

from __future__ import annotations

from rgcore.errors import EditError
from rgcore.model.edit import Edit, drop, must_be_new, put, the_line, the_object, the_region
from rgcore.model.fields import Angle, LineIds, NewObjectId, ObjectId, Place3, RegionId, Size3, Text
from rgcore.model.records import MapObject, RGMap, replace


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
        must_be_new(map, "objects", self.id)
        if len(set(self.lines)) < len(self.lines):
            raise EditError("a line is named twice")
        for line in self.lines:
            the_line(map, line)
        return put(map, "objects", _made(map, self, self.lines))

    def title(self, map: RGMap) -> str:
        return f"make an object of {len(self.lines)} line{'s' * (len(self.lines) != 1)}"


class AddObject(Edit, frozen=True):
    """There is an object that no line shows."""

    id: NewObjectId
    center: Place3
    size: Size3
    yaw: Angle
    label: Text = ""
    region: RegionId | None = None

    def change(self, map: RGMap) -> RGMap:
        must_be_new(map, "objects", self.id)
        return put(map, "objects", _made(map, self, ()))

    def title(self, map: RGMap) -> str:
        return f"add {self.label}" if self.label else "add an object"


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


class ConfirmObject(Edit, frozen=True):
    """The object is there for sure."""

    object: ObjectId

    def change(self, map: RGMap) -> RGMap:
        old = the_object(map, self.object)
        return put(map, "objects", replace(old, confidence=1.0, provenance=replace(old.provenance, confirmed=True)))

    def title(self, map: RGMap) -> str:
        return f"confirm {self.object}"


class DeleteObject(Edit, frozen=True):
    """There is no such object."""

    object: ObjectId

    def change(self, map: RGMap) -> RGMap:
        return drop(map, "objects", the_object(map, self.object).id)

    def title(self, map: RGMap) -> str:
        return f"delete {self.object}"


class RejectObject(DeleteObject, frozen=True):
    """The mapper took something for an object that is none."""

    def title(self, map: RGMap) -> str:
        return f"reject {self.object}"


def _made(map: RGMap, edit: SeedObject | AddObject, lines: tuple[str, ...]) -> MapObject:
    if edit.region is not None:
        the_region(map, edit.region)
    return MapObject(
        id=edit.id,
        label=edit.label,
        center=edit.center,
        size=edit.size,
        yaw=edit.yaw,
        lines=lines,
        region=edit.region,
        confidence=1.0,
    )
