"""The artist: what drawing needs beside the map, and what is worth keeping from one drawing to the next."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import numpy as np

from rgcore.geometry.polygons import label_place, triangulate
from rgcore.model.records import Line, Region, RGMap
from rgviz import theme
from rgviz.drawings import ring
from rgviz.theme import RGB

T = TypeVar("T")


class Rows(Generic[T]):
    """Numbers read off each record of a table, row by row; of the next map only what is new is read.

    A record that no edit touched is the same object, so a change of one line among 100,000 costs no 100,000 readings.
    """

    def __init__(self, read: Callable[[T], Any], shape: tuple[int, ...] = (), kind: type = float) -> None:
        self._read = read
        self._table: Mapping[str, T] = {}
        self._rows: np.ndarray = np.zeros((0, *shape), kind)

    def __call__(self, table: Mapping[str, T]) -> np.ndarray:
        """(N, ...) in the order of the table, read-only."""
        if table is not self._table:
            self._rows, self._table = self._next(table), table
        return self._rows

    def _next(self, table: Mapping[str, T]) -> np.ndarray:
        old = self._table
        place = dict(zip(old, range(len(old)), strict=True))
        known = zip(table, table.values(), map(old.get, table), strict=True)
        came_from = np.fromiter((place[k] if v is was else -1 for k, v, was in known), np.intp, len(table))
        rows = np.zeros((len(table), *self._rows.shape[1:]), self._rows.dtype)
        rows[came_from >= 0] = self._rows[came_from[came_from >= 0]]
        fresh = [self._read(v) for v, place in zip(table.values(), came_from.tolist(), strict=True) if place < 0]
        if fresh:
            rows[came_from < 0] = fresh
        rows.flags.writeable = False
        return rows


@dataclass
class Artist:
    """What drawing needs beside the map: the evidence, and what is worth keeping from one drawing to the next."""

    points: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.float32))
    trajectory: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    colors: dict[str, RGB] = field(default_factory=dict)
    line_ends: Rows[Line] = field(default_factory=lambda: Rows(lambda v: (v.start, v.end), (2, 2)))
    """(N, 2, 2) start and end of each line"""
    _kept: dict[tuple[str, str], tuple[object, Any]] = field(default_factory=dict)
    _homes: dict[str | None, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._home: Rows[Line] = Rows(lambda v: self._number(v.regions[0] if v.regions else None), kind=int)

    def floor(self, region: Region) -> np.ndarray:
        """(T, 3, 2) triangles of a region's floor."""
        return self._once("floor", region, lambda: triangulate(region.boundary, region.holes))

    def rings(self, region: Region) -> np.ndarray:
        """(N, 2, 2) strokes around a region and its holes."""
        return self._once("rings", region, lambda: np.concatenate([ring(r) for r in (region.boundary, *region.holes)]))

    def middle(self, region: Region) -> tuple[float, float]:
        """Where a region's name stands: inside, with room around it."""
        return self._once("middle", region, lambda: label_place(region.boundary, region.holes)[0])

    def line_colors(self, map_: RGMap) -> np.ndarray:
        """(N, 3) uint8: each line has the colour of the region whose free space it bounds."""
        home = self._home(map_.lines)
        known = [self.colors.get(id, theme.FREE_LINE) if id else theme.FREE_LINE for id in self._homes]
        return np.array(known, np.uint8).reshape(-1, 3)[home]

    def _number(self, region: str | None) -> int:
        return self._homes.setdefault(region, len(self._homes))

    def _once(self, what: str, region: Region, compute: Callable[[], T]) -> T:
        """Computed once for an outline, which stays the same object as long as nobody reshapes the region."""
        kept = self._kept.get((what, region.id))
        if kept is None or kept[0] is not region.boundary:
            kept = self._kept[what, region.id] = (region.boundary, compute())
        return kept[1]
