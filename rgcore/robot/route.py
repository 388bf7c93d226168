"""Ways over the gateways of a map for a robot of some width, from any place to any other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from rgcore.geometry.polygons import Polygon
from rgcore.model.records import Gateway
from rgcore.robot.floor import Floor

LANE = 0.5
"""m between the places at which an opening wider than a door can be crossed; nearest to a post, where there is room."""


@dataclass(frozen=True)
class Route:
    """A way for the robot's middle: the ``regions`` it leads through, in order, the ``gateways`` between them.

    waypoints  (K, 2) m, from start to goal, straight in between
    length     m
    """

    regions: tuple[str, ...]
    gateways: tuple[str, ...]
    waypoints: np.ndarray
    length: float


@dataclass(frozen=True)
class Stop:
    """An end of a route: a point [m] and the index of its region."""

    point: np.ndarray
    region: int


class Roads:
    """All straight pieces of shortest ways for one width: within each region about its corners, and through gateways.

    A gateway is crossed where the paper has it (section II): from the gateway-point of one region straight over the
    crossing-point to that of the next; an opening wider than a door also beside that.
    """

    def __init__(
        self, shapes: dict[str, Polygon], lines: dict[str, np.ndarray], gateways: list[Gateway], width: float
    ) -> None:
        """``lines``: of each region (L, 2, 2), what stands in it."""
        self.width = width
        self.ids = list(shapes)
        self.floors = [Floor.of(s, lines[id], width) for id, s in shapes.items()]
        self.gateways = [g for g in gateways if g.width >= width]
        self._points: list[np.ndarray] = []
        self._pairs: list[np.ndarray] = []
        self._lengths: list[np.ndarray] = []
        self.region = np.zeros(0, np.int64)  # of each node; -1 on a crossing-point
        self.gateway = np.zeros(0, np.int64)  # of each node; -1 unless it is a crossing-point
        self._cross()
        self._drive()

    def route(self, start: Stop, goal: Stop) -> Route | None:
        """The shortest way, or None."""
        distance, before, nodes, region = self._search(start, goal)
        n = len(self.nodes)
        if not np.isfinite(distance[n + 1]):
            return None
        way = [n + 1]
        while way[-1] != n:
            way.append(int(before[way[-1]]))
        way = way[::-1]
        points = np.concatenate([start.point[None], nodes[way], goal.point[None]])
        points = points[np.r_[True, np.hypot(*np.diff(points, axis=0).T) > 1e-6]]
        length = float(np.hypot(*np.diff(points, axis=0).T).sum())
        crossed = [int(self.gateway[k]) for k in way if k < n]
        through = (self.ids[r] for r, _ in groupby(int(region[k]) for k in way if region[k] >= 0))
        names = tuple(self.gateways[g].id for g, _ in groupby(crossed) if g >= 0)
        return Route(tuple(through), names, points, length)

    def reached(self, start: Stop) -> np.ndarray:
        """(N,) which nodes a robot gets to from ``start``."""
        return np.isfinite(self._search(start, start)[0][: len(self.nodes)])

    def _cross(self) -> None:
        """The nodes and ways through gateways; ``self._doors``: per region, its gateway-points' nodes."""
        index = {id: i for i, id in enumerate(self.ids)}
        points: list[np.ndarray] = []
        region: list[int] = []
        gateway: list[int] = []
        pairs: list[tuple[int, int]] = []
        for k, g in enumerate(self.gateways):
            for lane in lanes(g, self.width):
                crossings = []
                for c in range(len(lane[0])):
                    crossings.append(len(points))
                    points, region, gateway = [*points, lane[0][c]], [*region, -1], [*gateway, k]
                pairs += [(a, b) for a in crossings for b in crossings if a < b]
                for i, id in enumerate(g.regions):
                    if id in index:
                        pairs.append((crossings[i % len(crossings)], len(points)))
                        points, region, gateway = [*points, lane[1][i]], [*region, index[id]], [*gateway, -1]
        self.nodes, self.region = np.array(points).reshape(-1, 2), np.array(region, np.int64)
        self.gateway = np.array(gateway, np.int64)
        self._add(np.array(pairs, np.int64).reshape(-1, 2))

    def _drive(self) -> None:
        """The nodes and ways within the regions; ``self._inner``: per region, its nodes."""
        self._inner: list[np.ndarray] = []
        for r, floor in enumerate(self.floors):
            doors = np.flatnonzero(self.region == r)
            entered = floor.enter(self.nodes[doors])
            pairs, lengths = floor.ways(entered)
            first = len(self.nodes)
            inner = np.concatenate([floor.turns[:, 1], entered])
            self._inner.append(first + np.arange(len(inner)))
            self.nodes = np.concatenate([self.nodes, inner])
            self.region = np.concatenate([self.region, np.full(len(inner), r)])
            self.gateway = np.concatenate([self.gateway, np.full(len(inner), -1)])
            self._pairs.append(first + pairs)
            self._lengths.append(lengths)
            self._add(np.stack([doors, first + len(floor.turns) + np.arange(len(doors))], 1))

    def _add(self, pairs: np.ndarray) -> None:
        """Ways between nodes that see each other; those with a nan are none."""
        lengths = np.hypot(*(self.nodes[pairs[:, 1]] - self.nodes[pairs[:, 0]]).T)
        self._pairs.append(pairs[np.isfinite(lengths)])
        self._lengths.append(lengths[np.isfinite(lengths)])

    def _search(self, start: Stop, goal: Stop) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Distances and predecessors of all nodes from the first of the two that are added, start and goal."""
        n = len(self.nodes)
        nodes, pairs, lengths = [self.nodes], list(self._pairs), list(self._lengths)
        for k, stop in enumerate((start, goal)):
            floor, inner = self.floors[stop.region], self._inner[stop.region]
            here = floor.enter(stop.point)
            others = self.nodes[inner[len(floor.turns) :]]
            number = np.r_[inner, n + k]
            if k == 1 and start.region == goal.region:
                others = np.concatenate([others, nodes[1]])
                number = np.r_[inner, n, n + 1]
            found, far = floor.ways_from(here, others)
            nodes.append(here)
            pairs.append(number[found])
            lengths.append(far)
        i, j = np.concatenate(pairs).T
        weights = np.maximum(np.concatenate(lengths), 1e-9)  # scipy takes 0 for no way
        graph = coo_array((weights, (i, j)), shape=(n + 2, n + 2)).tocsr()
        distance, before = dijkstra(graph, directed=False, indices=n, return_predecessors=True)
        return distance, before, np.concatenate(nodes), np.r_[self.region, start.region, goal.region]


def lanes(gateway: Gateway, width: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Where a gateway can be crossed: crossing-points (1 or one a region, 2) and gateway-points (one a region, 2)."""
    posts = np.array(gateway.posts, float)
    crossing = np.array(gateway.crossing_points, float).reshape(-1, 2)
    if len(crossing) != len(gateway.regions) or len(crossing) < 3:
        crossing = crossing if len(crossing) == 1 else posts.mean(0)[None]
    points = np.array(gateway.gateway_points, float).reshape(-1, 2)
    if len(points) != len(gateway.regions):
        points = np.repeat(crossing[:1], len(gateway.regions), 0)
    along = (posts[1] - posts[0]) / max(gateway.width, 1e-9)
    side = max(0.0, gateway.width / 2 - max(width / 2, LANE)) if len(crossing) == 1 else 0.0
    count = int(side / LANE)
    for shift in LANE * np.arange(-count, count + 1):
        yield crossing + shift * along, points + shift * along
