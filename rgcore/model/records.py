"""The document: what the map *is*, as immutable records in dicts by id (metres, radians, map frame).

Each fact stands once: a line names its regions, a gateway names its regions, an object names its lines and its region.
The lists of a region (its lines, gateways, objects) are derived by the functions at the end.
Dicts inside a record are never changed in place: an edit makes new ones.
"""

from __future__ import annotations

from typing import Any, Literal

import msgspec

Point = tuple[float, float]
Point3 = tuple[float, float, float]

REGION_CLASSES = ("CDMA", "ODMA", "TOMA", "CC")
"""Region classes of the paper (section II): closed / open with one main axis (hallways), two main axes, cluttered."""

GATEWAY_CLASSES = ("narrow_passage", "junction_T", "junction_L", "junction_X", "opening")


class Record(msgspec.Struct, frozen=True, kw_only=True):
    """Base of all records: frozen, compared by value."""


class Provenance(Record, frozen=True, kw_only=True):
    """Who made the item: the pipeline, a person, or a person after the pipeline; ``edits`` are journal numbers."""

    source: Literal["auto", "human", "edited"] = "auto"
    by: str | None = None
    """who touched or reviewed it last, and when (``at``)"""
    at: str | None = None
    edits: tuple[int, ...] = ()
    confirmed: bool = False
    """whether a person looked at it and found it right"""


class Line(Record, frozen=True, kw_only=True):
    """A wall line. Free space lies to the left of start -> end."""

    id: str
    start: Point
    end: Point
    regions: tuple[str, ...] = ()
    """ids of the regions that list this line: first the one whose free space it bounds, then those that see it"""
    support: int = 0
    """number of scan segments merged into the line"""
    residual: float | None = None
    """m, root mean square distance of the merged segments' ends from the line"""
    deviation: Point | None = None
    """standard deviations that the mapper gives it: m across at its middle, rad of its direction"""
    clutter: bool = False
    """whether it is a thing in the room (chair, plant) and no wall"""
    provenance: Provenance = Provenance()


class Box2(Record, frozen=True, kw_only=True):
    """Rectangle in the plane: ``size`` along the axis ``yaw`` and across it."""

    center: Point
    size: Point
    yaw: float


class Region(Record, frozen=True, kw_only=True):
    """A place: hallway, office, lab. ``boundary``: its outline, a counter-clockwise ring, first point not repeated."""

    id: str
    name: str
    class_: str = msgspec.field(name="class")
    class_scores: dict[str, float] = {}
    boundary: tuple[Point, ...]
    holes: tuple[tuple[Point, ...], ...] = ()
    box: Box2
    """the smallest rectangle that holds all possible robot positions in the region (paper, section II)"""
    axes: tuple[float, ...] = ()
    """one or two main axes, rad in [0, pi), the stronger first"""
    accuracy: float | None = None
    """acc(R) [m]; None where no scan was taken in the region"""
    scans: int = 0
    """number of scans taken in the region"""
    provenance: Provenance = Provenance()


class Gateway(Record, frozen=True, kw_only=True):
    """A transition between regions. ``posts`` are the two ends of the opening."""

    id: str
    name: str = ""
    class_: str = msgspec.field(name="class")
    confidence: float = 0.0
    regions: tuple[str, ...] = ()
    posts: tuple[Point, Point]
    crossing_points: tuple[Point, ...] = ()
    """where the robot crosses from one region to the next: one for a passage, one an arm for a junction"""
    gateway_points: tuple[Point, ...] = ()
    """one a region of ``regions``, in the same order: where the gateway counts as entered and left"""
    traversal_directions: tuple[float, ...] = ()
    """rad, the directions in which it is passed"""
    passed: bool = False
    """whether the robot drove through it"""
    provenance: Provenance = Provenance()

    @property
    def width(self) -> float:
        """Distance of the posts [m]."""
        (ax, ay), (bx, by) = self.posts
        return ((ax - bx) ** 2 + (ay - by) ** 2) ** 0.5


class MapObject(Record, frozen=True, kw_only=True):
    """An object hypothesis: a box in 3D over a group of lines; ``center`` is the middle of the box."""

    id: str
    label: str = ""
    center: Point3
    size: Point3
    yaw: float = 0.0
    lines: tuple[str, ...] = ()
    region: str | None = None
    confidence: float = 0.0
    provenance: Provenance = Provenance()


class Note(Record, frozen=True, kw_only=True):
    """What a person wrote down, at a place or on an item; the note outlives the item and stays at its place."""

    id: str
    text: str
    place: Point
    item: str | None = None
    """id of the item that it is about"""
    provenance: Provenance = Provenance()


class Backdrop(Record, frozen=True, kw_only=True):
    """A floor plan that lies under the map: an image or a drawing, which the project keeps by its content.

    Its own frame has x to the right and y up, the unit is a pixel or, of a drawing, a metre. A point p of it lies at
    ``center`` + ``scale`` R(``yaw``) (p - middle of the plan).
    """

    id: str
    name: str
    """what the file was called; it is no path"""
    sha256: str
    form: Literal["png", "jpg", "dxf"]
    size: Point
    """width and height in its own unit"""
    center: Point
    yaw: float = 0.0
    length: float
    """m of its longer side on the map"""
    provenance: Provenance = Provenance()

    @property
    def scale(self) -> float:
        """m a unit of the plan"""
        return self.length / max(self.size)


class Ignored(Record, frozen=True, kw_only=True):
    """A finding of the lint that a person has seen and lets stand; ``id`` is that of the finding."""

    id: str
    code: str
    items: tuple[str, ...]
    provenance: Provenance = Provenance()


class Source(Record, frozen=True, kw_only=True):
    """What the map was made from."""

    log: str = ""
    sha256: str = ""
    format: str = ""
    settings: dict[str, Any] = {}
    """only those that differ from the defaults, as {"stage.name": value}"""
    software: str = ""


class Stats(Record, frozen=True, kw_only=True):
    """Counts of the run: ``points`` = valid readings used, ``segments`` = lines of all single scans before merging."""

    scans: int = 0
    points: int = 0
    segments: int = 0
    accuracy: float | None = None
    """acc over all scans [m], root mean square"""
    accuracy_penalty: float | None = None
    """p [m]: what a reading costs that the map does not predict"""


class RGMap(Record, frozen=True, kw_only=True):
    """An RG map <R, G> (paper, section II) with its lines and objects, and what people noted about it."""

    source: Source = Source()
    stats: Stats = Stats()
    lines: dict[str, Line] = {}
    regions: dict[str, Region] = {}
    gateways: dict[str, Gateway] = {}
    objects: dict[str, MapObject] = {}
    notes: dict[str, Note] = {}
    ignored: dict[str, Ignored] = {}
    backdrops: dict[str, Backdrop] = {}

    def lines_of(self, region: str) -> list[str]:
        return [k for k, v in self.lines.items() if region in v.regions]

    def gateways_of(self, region: str) -> list[str]:
        return [k for k, v in self.gateways.items() if region in v.regions]

    def objects_of(self, region: str) -> list[str]:
        return [k for k, v in self.objects.items() if v.region == region]


replace = msgspec.structs.replace
"""A copy of a record with some fields changed."""

DIGITS = 6
"""Numbers of the document are whole micrometres and microradians: exact in JSON, far below what a laser measures."""


def rounded(value: float) -> float:
    """A number as it stands in the document; never -0.0, which would be another text for the same number."""
    return round(float(value), DIGITS) + 0.0
