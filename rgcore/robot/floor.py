"""Where a robot of some width can drive within one region, and the straight pieces of its shortest ways there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.geometry import polygons
from rgcore.geometry.polygons import MultiPolygon, Polygon

DOORSTEP = 0.3
"""m; outlines end somewhere in the thickness of a door's wall: so far from a region a place still belongs to it."""

ALONG = 0.1
"""m; a line that stays so near to a region's outline is the wall that the outline follows."""

PAIRS = 200_000
"""Nodes are compared so many pairs at a time: bounds the memory in a region full of clutter."""


@dataclass(frozen=True)
class Floor:
    """A region's outline ``shape``, and the places ``room`` in it that the robot's middle can take.

    ``turns`` (n, 3, 2): the corners of ``room`` about which shortest ways bend, each between its neighbours
    (Lozano-Perez & Wesley 1979).
    """

    shape: Polygon
    room: MultiPolygon
    turns: np.ndarray

    @classmethod
    def of(cls, shape: Polygon, lines: np.ndarray, width: float) -> Floor:
        """``lines`` (L, 2, 2): what stands in the region; those along its outline add nothing and are left out."""
        room = polygons.shrink(shape, width / 2, lines[~polygons.covers(shape.boundary, lines, ALONG)])
        return cls(shape, room, polygons.turns(room))

    def enter(self, points: np.ndarray) -> np.ndarray:
        """(K, 2) where a robot that stands at ``points`` (K, 2) gets to where it has room; nan where it cannot.

        It may come straight out of a tight corner, from a wall or over a doorstep, but not through a wall.
        """
        p = np.asarray(points, float).reshape(-1, 2)
        on = polygons.nearest(self.shape, p)
        out = polygons.nearest(self.room, on)
        reached = (np.hypot(*(on - p).T) <= DOORSTEP) & np.isfinite(out).all(1)
        reached[reached] = polygons.covers(self.shape, np.stack([on, out], 1)[reached])
        out[~reached] = np.nan
        return out

    def ways(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Straight ways between all nodes, the turns (n) and then ``points`` (K, 2) in ``room``.

        Returns pairs of nodes (m, 2) and lengths (m,) [m]. A way that does not hug the corner at its end is on no
        shortest way and left out.
        """
        n, count = len(self.turns), len(self.turns) + len(points)
        nodes = np.concatenate([self.turns[:, 1], points])
        found, lengths = [np.zeros((0, 2), np.int64)], [np.zeros(0)]
        for rows in np.array_split(np.arange(count), 1 + count * count // PAIRS):
            i, j = np.meshgrid(rows, np.arange(count), indexing="ij")
            pairs, far = self._see(nodes, np.stack([i[i < j], j[i < j]], 1), n)
            found.append(pairs)
            lengths.append(far)
        return np.concatenate(found), np.concatenate(lengths)

    def ways_from(self, points: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As ``ways``, only those from ``points`` (K, 2): nodes are the turns, then ``others``, then ``points``."""
        n, first = len(self.turns), len(self.turns) + len(others)
        count = first + len(points)
        pairs = np.array([(i, j) for j in range(first, count) for i in range(j)], np.int64).reshape(-1, 2)
        return self._see(np.concatenate([self.turns[:, 1], others, points]), pairs, n)

    def _see(self, nodes: np.ndarray, pairs: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
        """The pairs that see each other, and their distance; the first ``n`` nodes are turns."""
        pairs = pairs[~np.isnan(nodes[pairs]).any((1, 2))]
        hugging = np.ones(len(pairs), bool)
        for end in (0, 1):
            at = np.flatnonzero(pairs[:, end] < n)
            corner, other = self.turns[pairs[at, end]], nodes[pairs[at, 1 - end]]
            along = corner[:, 1] - other
            before, after = (_cross(along, corner[:, i] - corner[:, 1]) for i in (0, 2))
            hugging[at] &= before * after >= -1e-9
        pairs = pairs[hugging]
        pairs = pairs[polygons.covers(self.room, nodes[pairs])]
        return pairs, np.hypot(*(nodes[pairs[:, 1]] - nodes[pairs[:, 0]]).T)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
