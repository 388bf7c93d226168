"""The artist: what drawing needs beside the map, and what is worth keeping from one drawing to the next."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import compress, repeat
from operator import is_
from typing import Any, Generic, TypeVar

import numpy as np

from rgcore.geometry.polygons import label_place, triangulate
from rgcore.model.records import Line, Region
from rgviz import theme
from rgviz.drawings import ring
from rgviz.theme import RGB

T = TypeVar("T")


class Rows(Generic[T]):
    """Numbers read off each record of a table, row by row; of the next map only what is new is read.

    A record that no edit touched is the same object, so a change of one line among 100,000 costs no 100,000 readings.
    """

    def __init__(self, read: Callable[[T], Any], shape: tuple[int, ...] = ()) -> None:
        self._read = read
        self._table: Mapping[str, T] = {}
        self._rows: np.ndarray = np.zeros((0, *shape))

    def __call__(self, table: Mapping[str, T]) -> np.ndarray:
        """(N, ...) in the order of the table, read-only."""
        if table is not self._table:
            self._rows, self._table = self._next(table), table
        return self._rows

    def _next(self, table: Mapping[str, T]) -> np.ndarray:
        old, count = self._table, len(table)
        place = dict(zip(old, range(len(old)), strict=True))
        came_from = np.fromiter(map(place.get, table, repeat(-1)), np.intp, count)
        same = np.fromiter(map(is_, table.values(), map(old.get, table)), bool, count)
        rows = np.zeros((count, *self._rows.shape[1:]))
        rows[same] = self._rows[came_from[same]]
        fresh = [self._read(v) for v in compress(table.values(), ~same)]
        if fresh:
            rows[~same] = fresh
        rows.flags.writeable = False
        return rows


@dataclass
class Artist:
    """What drawing needs beside the map: the evidence, and what is worth keeping from one drawing to the next."""

    points: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.float32))
    trajectory: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    colors: dict[str, RGB] = field(default_factory=dict)
    _kept: dict[tuple[str, str], tuple[object, Any]] = field(default_factory=dict)
    _homes: dict[str | None, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._lines: Rows[Line] = Rows(lambda v: (*v.start, *v.end, self._number(v)), (5,))

    def line_ends(self, lines: Mapping[str, Line]) -> np.ndarray:
        """(N, 2, 2) start and end of each line."""
        return self._lines(lines)[:, :4].reshape(-1, 2, 2)

    def line_colors(self, lines: Mapping[str, Line]) -> np.ndarray:
        """(N, 3) uint8: each line has the colour of the region whose free space it bounds."""
        home = self._lines(lines)[:, 4].astype(int)
        known = [self.colors.get(id, theme.FREE_LINE) if id else theme.FREE_LINE for id in self._homes]
        return np.array(known, np.uint8).reshape(-1, 3)[home]

    def _number(self, line: Line) -> int:
        return self._homes.setdefault(line.regions[0] if line.regions else None, len(self._homes))

    def floor(self, region: Region) -> np.ndarray:
        """(T, 3, 2) triangles of a region's floor."""
        return self._once("floor", region, lambda: triangulate(region.boundary, region.holes))

    def rings(self, region: Region) -> np.ndarray:
        """(N, 2, 2) strokes around a region and its holes."""
        return self._once("rings", region, lambda: np.concatenate([ring(r) for r in (region.boundary, *region.holes)]))

    def middle(self, region: Region) -> tuple[float, float]:
        """Where a region's name stands: inside, with room around it."""
        return self._once("middle", region, lambda: label_place(region.boundary, region.holes)[0])

    def _once(self, what: str, region: Region, compute: Callable[[], T]) -> T:
        """Computed once for an outline, which stays the same object as long as nobody reshapes the region."""
        kept = self._kept.get((what, region.id))
        if kept is None or kept[0] is not region.boundary:
            kept = self._kept[what, region.id] = (region.boundary, compute())
        return kept[1]
