"""The robot's road map of a floor: a lattice of places where it fits, and the ways between them."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from rgcore.scans.floor import Floor

STRIDE = 2
"""Cells of the room raster from one node of the road map to the next."""


class Roads:
    """The robot's free space as a graph: nodes ``xy`` (K, 2) with ``clearance``, edges that cost more near walls."""

    def __init__(self, floor: Floor, radius: float) -> None:
        labels = floor.labels
        self.labels, self.margin = labels, radius
        self.field = _clearance(floor)
        lattice = np.zeros(labels.shape, bool)
        lattice[::STRIDE, ::STRIDE] = True
        iy, ix = np.nonzero(lattice & (self.field >= self.margin))
        self.xy = labels.centers(np.stack([ix, iy], 1))
        self.room, self.clearance = labels.values[iy, ix], self.field[iy, ix]
        number = np.full(labels.shape, -1)
        number[iy, ix] = np.arange(len(ix))
        self.graph = self._connect(number[::STRIDE, ::STRIDE], labels.resolution * STRIDE)

    def _connect(self, number: np.ndarray, spacing: float) -> csr_array:
        a, b, length = [], [], []
        h, w = number.shape
        for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
            here = number[: h - dy, max(-dx, 0) : w - max(dx, 0)]
            there = number[dy:, max(dx, 0) : w - max(-dx, 0)]
            ok = (here >= 0) & (there >= 0)
            a.append(here[ok])
            b.append(there[ok])
            length.append(np.full(int(ok.sum()), spacing * np.hypot(dx, dy)))
        i, j, d = np.concatenate(a), np.concatenate(b), np.concatenate(length)
        near = np.minimum(self.clearance[i], self.clearance[j]) - self.margin
        cost = d * (1 + 3 * np.exp(-near / 0.15))
        n = len(self.xy)
        return coo_array((cost, (i, j)), shape=(n, n)).tocsr()

    def nearest(self, point: np.ndarray, among: np.ndarray | None = None) -> int:
        """The node next to a point (2,)."""
        nodes = np.arange(len(self.xy)) if among is None else among
        return int(nodes[np.argmin(((self.xy[nodes] - point) ** 2).sum(1))])

    def costs(self, nodes: list[int], to: list[int]) -> np.ndarray:
        """(len(nodes), len(to)) costs of the ways; one search at a time, to hold memory down."""
        return np.array([dijkstra(self.graph, directed=False, indices=n)[to] for n in nodes])

    def way(self, start: int, end: int) -> np.ndarray:
        """(K, 2) the cheapest way between two nodes."""
        _, before = dijkstra(self.graph, directed=False, indices=start, return_predecessors=True)
        nodes = [end]
        while nodes[-1] != start:
            nodes.append(int(before[nodes[-1]]))
        return self.xy[nodes[::-1]]

    def room_to_drive(self, points: np.ndarray) -> np.ndarray:
        """(K,) clearance [m] at points (K, 2), between cells."""
        at = (points - self.labels.origin) / self.labels.resolution - 0.5
        return map_coordinates(self.field, at.T[::-1], order=1, mode="nearest")


def _clearance(floor: Floor) -> np.ndarray:
    """(H, W) distance [m] of the room raster's cells to the nearest wall or furniture; 0 off the floor."""
    start, end = floor.segments[:, 0], floor.segments[:, 1]
    pieces = np.ceil(np.linalg.norm(end - start, axis=1) / 0.02).astype(int) + 1
    segment = np.repeat(np.arange(len(pieces)), pieces)
    part = np.arange(len(segment)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    share = part / np.repeat(np.maximum(pieces - 1, 1), pieces)
    points = start[segment] + share[:, None] * (end - start)[segment]
    iy, ix = np.nonzero(floor.labels.values)
    out = np.zeros(floor.labels.shape)
    out[iy, ix] = cKDTree(points).query(floor.labels.centers(np.stack([ix, iy], 1)))[0]
    return out
