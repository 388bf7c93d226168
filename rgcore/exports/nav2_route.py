"""The map as a graph for Nav2's route server (GeoJSON in metres): a log in, a drivable and named graph out.

Nodes are crossing-points, gateway-points, the middles of regions, and the corners that ways between them bend about.
An edge is straight and goes one way, so each way is written twice. Passages carry class, width, a speed limit
[percent] where they are narrow, and the operation that opens a door.
"""

from __future__ import annotations

import json
import math
from itertools import combinations, pairwise
from typing import Any

import numpy as np

from rgcore.errors import QueryError
from rgcore.exports.nav2 import NARROW, NARROW_SPEED, SPEED
from rgcore.exports.options import Exported, Options
from rgcore.geometry.polygons import label_place
from rgcore.model.records import Gateway, Region, RGMap
from rgcore.robot.query import Query
from rgcore.slam.trajectory import Trajectory

DETOUR = 1.1
"""A way that is hardly longer by way of another gateway-point is not written by itself."""

_LOST = ("lines, objects and outlines: the graph holds the ways only",)


def render(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """The graph as GeoJSON; what it could not connect is told in ``lost``."""
    graph = Lanes(map)
    return Exported(graph.geojson(options.stem), lost=(*_LOST, *graph.gaps))


class Lanes:
    """The ways of a map: ``nodes`` (place, what it is), ``edges`` (from, to, what it is), and the ``gaps`` in words."""

    def __init__(self, map: RGMap) -> None:
        self.query, self.map = Query(map), map
        self.nodes: list[tuple[tuple[float, float], dict[str, Any]]] = []
        self.edges: list[tuple[int, int, dict[str, Any]]] = []
        self.gaps: list[str] = []
        self._at: dict[tuple[str, float, float], int] = {}
        self._doors: dict[str, list[int]] = {r: [] for r in self.map.regions}
        for g in map.gateways.values():
            self._cross(g)
        for r in map.regions.values():
            self._drive(r)
        if not self.edges:
            self.gaps.append("ways: there are none, and the route server refuses a graph without")

    def _cross(self, g: Gateway) -> None:
        """The nodes of a gateway, and the ways over its crossing-points between its gateway-points."""
        about = {"rg_id": g.id, "class": g.class_, "width": float(round(g.width, 3))} | _named(g.name)
        crossings = [self._node("", p, {**about, "kind": "crossing"}) for p in g.crossing_points or (_middle(g),)]
        for a, b in combinations(crossings, 2):
            self._both(a, b, about)
        for i, (r, p) in enumerate(zip(g.regions, g.gateway_points, strict=False)):
            if r in self._doors:
                node = self._node(r, p, {"rg_id": g.id, "kind": "gateway_point", "region": r})
                self._doors[r].append(node)
                limit = {"speed_limit": float(NARROW_SPEED)} if g.width < NARROW else {}
                self._both(node, crossings[i % len(crossings)], {**about, **limit}, _operation(g))

    def _drive(self, r: Region) -> None:
        """The ways within a region: between its gateway-points, and to its middle."""
        middle, _ = label_place(r.boundary, r.holes)
        about = {"rg_id": r.id, "class": r.class_} | _named(r.name)
        home = self._node(r.id, middle, {**about, "kind": "region"})
        stops = list(dict.fromkeys([*self._doors[r.id], home]))
        ways = {pair: way for pair in combinations(stops, 2) if (way := self._way(r, *pair)) is not None}
        far = {pair: _length(way) for pair, way in ways.items()}
        limit = {"speed_limit": float(SPEED[r.class_])} if r.class_ in SPEED else {}
        for (a, b), way in ways.items():
            by_way_of_another = any(
                _far(far, a, c) + _far(far, c, b) < DETOUR * far[a, b] for c in stops if c not in (a, b, home)
            )
            if not by_way_of_another:
                nodes = [a, *(self._node(r.id, p, {"kind": "bend", "region": r.id}) for p in way[1:-1]), b]
                for here, there in pairwise(nodes):
                    self._both(here, there, {**about, **limit})

    def _way(self, r: Region, a: int, b: int) -> list[tuple[float, float]] | None:
        """The way between two nodes of a region that stays in it; None, and a note, where there is none."""
        start, goal = self.nodes[a][0], self.nodes[b][0]
        try:
            route = self.query.route(start, goal)
        except QueryError as e:
            self.gaps.append(f"{r.id}: {e}")
            return None
        return [(float(x), float(y)) for x, y in route.waypoints] if route.regions == (r.id,) else None

    def _node(self, region: str, at: tuple[float, float], about: dict[str, Any]) -> int:
        x, y = (round(float(v), 3) + 0.0 for v in at)
        if (region, x, y) not in self._at:
            self.nodes.append(((x, y), about))
            self._at[region, x, y] = len(self.nodes) - 1
        return self._at[region, x, y]

    def _both(self, a: int, b: int, about: dict[str, Any], operation: dict[str, Any] | None = None) -> None:
        more = {"operations": operation} if operation else {}
        known = {(i, j) for i, j, _ in self.edges}
        for i, j in ((a, b), (b, a)):
            if i != j and (i, j) not in known:
                self.edges.append((i, j, {"metadata": about, **more}))

    def geojson(self, name: str) -> bytes:
        """The route server's file; ids are unique over nodes and edges, as the loader wants them."""
        features = []
        for k, (at, about) in enumerate(self.nodes, 1):
            properties = {"id": k, "frame": "map", "metadata": about}
            features.append(_feature({"type": "Point", "coordinates": list(at)}, properties))
        for k, (a, b, about) in enumerate(self.edges, len(self.nodes) + 1):
            ends = [list(self.nodes[a][0]), list(self.nodes[b][0])]
            cost = float(round(math.dist(*ends), 3))
            properties = {"id": k, "startid": a + 1, "endid": b + 1, "cost": cost, "overridable": True, **about}
            features.append(_feature({"type": "MultiLineString", "coordinates": [ends]}, properties))
        lines = ",\n".join(json.dumps(f, ensure_ascii=False, sort_keys=True) for f in features)
        return f'{{"type": "FeatureCollection", "name": {json.dumps(name)}, "features": [\n{lines}\n]}}\n'.encode()


def _operation(g: Gateway) -> dict[str, Any] | None:
    """What a robot does before it passes: a door may have to be opened."""
    if g.class_ != "narrow_passage":
        return None
    return {"open_door": {"type": "OpenDoor", "trigger": "ON_ENTER", "metadata": {"door_id": g.id}}}


def _feature(geometry: dict[str, Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "geometry": geometry, "properties": properties}


def _named(name: str) -> dict[str, str]:
    return {"name": name} if name else {}


def _middle(g: Gateway) -> tuple[float, float]:
    (ax, ay), (bx, by) = g.posts
    return (ax + bx) / 2, (ay + by) / 2


def _length(way: list[tuple[float, float]]) -> float:
    return float(np.hypot(*np.diff(np.array(way), axis=0).T).sum())


def _far(far: dict[tuple[int, int], float], a: int, b: int) -> float:
    return far.get((a, b), far.get((b, a), np.inf))
