"""A floor plan as a person writes it: rooms as polygons on the middle lines of walls, doors as points on common walls.

Neighbouring rooms share their wall's middle line, so coordinates are round numbers; the faces of the walls follow from
the wall thickness (``rgcore.scans.floor``). Metres, radians. See ``rgviz/demo/office.plan.json`` for a whole building.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from rgcore.errors import InputError

Point = tuple[float, float]
Length = Annotated[float, Meta(gt=0, le=1000)]
Ring = Annotated[tuple[Point, ...], Meta(min_length=3)]
Kind = Literal["narrow_passage", "opening", "junction_T", "junction_L", "junction_X"]


class PlanRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base of the plan's records: a misspelt field is an error, not a default."""


class Room(PlanRecord, frozen=True):
    """A room. ``outline`` and ``holes`` run on the middle lines of its walls, in either sense; no point is repeated."""

    name: Annotated[str, Meta(min_length=1)]
    outline: Ring
    holes: tuple[Ring, ...] = ()
    cls: Literal["room", "hallway", "lobby"] = "room"
    """what a person calls it"""
    class_: Literal["CDMA", "ODMA", "TOMA", "CC"] | None = msgspec.field(name="class", default=None)
    """region class of the paper; by default CDMA for a hallway, TOMA for the others"""

    @property
    def region_class(self) -> str:
        return self.class_ or ("CDMA" if self.cls == "hallway" else "TOMA")


class Door(PlanRecord, frozen=True):
    """A door or a wide opening in the common wall of two rooms; ``at`` is the middle between its posts."""

    at: Point
    width: Length = 0.9
    kind: Kind = "narrow_passage"
    open: bool = True


class Junction(PlanRecord, frozen=True):
    """Where the arms of one hallway meet: the hallway stays one region, the junction is noted in the truth."""

    room: str
    at: Point
    width: Length
    arms: Annotated[tuple[float, ...], Meta(min_length=2, max_length=4)]
    """rad, the directions of the arms: two make an L, three a T, four an X"""

    @property
    def kind(self) -> str:
        return {2: "junction_L", 3: "junction_T", 4: "junction_X"}[len(self.arms)]


class Furniture(PlanRecord, frozen=True):
    """A box on the floor, or four legs at its corners (what a laser sees of a table)."""

    label: Annotated[str, Meta(min_length=1)]
    at: Point
    size: tuple[Length, Length]
    yaw: float = 0.0
    shape: Literal["box", "legs"] = "box"


class Wall(PlanRecord, frozen=True):
    """A wall that stands free in a room: a partition, a pillar."""

    start: Point
    end: Point
    thickness: Length = 0.1


class Plan(PlanRecord, frozen=True):
    """A floor. ``wall`` is the thickness of all walls between rooms; ``start`` the robot's first pose, x y theta."""

    name: Annotated[str, Meta(min_length=1)]
    start: tuple[float, float, float]
    rooms: Annotated[tuple[Room, ...], Meta(min_length=1, max_length=255)]
    wall: Annotated[float, Meta(gt=0, le=1)] = 0.14
    doors: tuple[Door, ...] = ()
    junctions: tuple[Junction, ...] = ()
    furniture: tuple[Furniture, ...] = ()
    walls: tuple[Wall, ...] = ()


def read_plan(path: str | Path) -> Plan:
    """A floor plan from JSON. Raises InputError that names the file and the item that is wrong."""
    try:
        return msgspec.json.decode(Path(path).read_bytes(), type=Plan)
    except OSError as e:
        raise InputError(path, f"cannot read the floor plan: {e.strerror}") from e
    except msgspec.ValidationError as e:
        reason, _, where = str(e).partition(" - at `$")
        raise InputError(path, f"{where.strip('`.') or 'plan'}: {reason}") from e
    except (msgspec.DecodeError, UnicodeDecodeError) as e:
        raise InputError(path, f"not a JSON floor plan: {e}") from e
