"""Ways through the pose graph: how far an old keyframe may be off goes by the way to it."""

from __future__ import annotations

from array import array

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra


class Ways:
    """Shortest way [m] through the graph from the newest keyframe to every other, kept up to date as it grows."""

    SLACK = 2.0
    """A shorter way is only worth a new search when it saves this much [m]."""

    def __init__(self) -> None:
        self.length = np.zeros(0)
        self._ends, self._lengths = array("q"), array("d")  # of the edges: two keyframes each, and a length [m]
        self._graph: csr_matrix | None = None  # of the edges, when they are asked for

    def advance(self, step: float) -> None:
        """A new keyframe, ``step`` [m] from the one before; inf if no way leads to it."""
        k = len(self.length)
        if k and np.isfinite(step):
            self._add(k - 1, k, step)
        self.length = np.append(self.length + step, 0.0)

    def shortcut(self, keyframe: int, old: int, distance: float) -> None:
        """The keyframe that the ways start from is linked to an old one ``distance`` [m] away."""
        self._add(keyframe, old, distance)
        if self.length[old] > distance + self.SLACK:
            self.turn_to(keyframe)

    def turn_to(self, keyframe: int, limit: float = np.inf) -> None:
        """From now on the ways are those from this keyframe; longer ones than ``limit`` [m] are inf."""
        if self._graph is None:
            (a, b), n, w = np.array(self._ends).reshape(-1, 2).T, len(self.length), np.array(self._lengths)
            self._graph = csr_matrix((np.tile(w, 2), (np.append(a, b), np.append(b, a))), shape=(n, n))
        self.length = dijkstra(self._graph, indices=keyframe, limit=limit)

    def _add(self, a: int, b: int, length: float) -> None:
        self._graph = None
        self._ends.extend((a, b))
        self._lengths.append(max(length, 1e-3))  # a sparse graph takes zero for no edge
