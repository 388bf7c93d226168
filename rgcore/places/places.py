"""Places as they are found: regions and gateways before they become records."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec

from rgcore.geometry.grid import Grid

Point = tuple[float, float]


class FoundRegion(msgspec.Struct, frozen=True, kw_only=True):
    """A connected piece of free space between gateways. Ring counter-clockwise, first point not repeated."""

    boundary: tuple[Point, ...]
    holes: tuple[tuple[Point, ...], ...] = ()
    box_center: Point
    box_size: tuple[float, float]
    box_yaw: float
    first_scan: int
    """the first scan taken inside; regions that were only looked into come last, with -1"""


class FoundGateway(msgspec.Struct, frozen=True, kw_only=True):
    """A transition between regions, given by their indices."""

    class_: str
    confidence: float
    regions: tuple[int, ...]
    posts: tuple[Point, Point]
    crossing_points: tuple[Point, ...]
    gateway_points: tuple[Point, ...]
    traversal_directions: tuple[float, ...]
    passed: bool
    first_scan: int


@dataclass(frozen=True)
class Places:
    """Regions and gateways, ordered by the scan that came first; ``labels`` (int32): their raster, -1 = none."""

    labels: Grid
    regions: tuple[FoundRegion, ...]
    gateways: tuple[FoundGateway, ...]
