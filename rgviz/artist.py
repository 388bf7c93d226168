"""The artist: what drawing needs beside the map, and what is worth keeping from one drawing to the next."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from rgcore.geometry.polygons import label_place, triangulate
from rgcore.model.records import Line, Region
from rgcore.model.rows import Rows
from rgviz import theme
from rgviz.drawings import ring
from rgviz.theme import RGB

T = TypeVar("T")


@dataclass
class Artist:
    """What drawing needs beside the map: the evidence, and what is worth keeping from one drawing to the next."""

    points: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.float32))
    trajectory: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    colors: dict[str, RGB] = field(default_factory=dict)
    _kept: dict[tuple[str, str], tuple[object, Any]] = field(default_factory=dict)
    _homes: dict[str | None, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._home: Rows[Line] = Rows(self._number)

    def line_colors(self, lines: Mapping[str, Line]) -> np.ndarray:
        """(N, 3) uint8: each line has the colour of the region whose free space it bounds."""
        home = self._home(lines).astype(int)
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
