"""What one may ask of an export, and what comes out of it."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Georeference:
    """Where the map's origin lies on the earth (WGS 84), and how it is turned.

    latitude, longitude [degrees]; heading: direction of the map's x axis [rad], counter-clockwise from east.
    """

    latitude: float
    longitude: float
    heading: float = 0.0


@dataclass(frozen=True)
class Options:
    """``stem``: the file's name without its ending, for files that name one another; ``wall_height`` [m]: how high
    lines are extruded in formats that have a height; ``resolution`` [m]: size of a cell in formats that are rasters;
    ``georeference``: for formats that can place a map on the earth.
    """

    stem: str = "map"
    wall_height: float = 2.5
    resolution: float = 0.05
    georeference: Georeference | None = None


@dataclass(frozen=True)
class Exported:
    """``data``: the file; ``beside``: the files that belong to it, by what follows the stem of its name (``.pgm``,
    ``-keepout.pgm``); ``lost``: a sentence for each kind of thing that the format could not carry.
    """

    data: bytes
    beside: dict[str, bytes] = field(default_factory=dict)
    lost: tuple[str, ...] = ()
