"""What a robot or a person asks of a map: where am I, what is here, what would I see, how do I get there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rgcore.errors import NoRoute, QueryError
from rgcore.geometry import polygons
from rgcore.lines.accuracy import predict
from rgcore.model.records import Gateway, MapObject, Region, RGMap
from rgcore.robot.blocked import why_blocked
from rgcore.robot.floor import DOORSTEP
from rgcore.robot.route import Roads, Route, Stop

Place = str | Sequence[float] | np.ndarray
"""A region, by id or name; or a point or pose: x, y [m] and maybe an angle, map frame."""


class Query:
    """Questions to a map, which stays as it is: make a new Query of an edited one. All in metres, map frame."""

    def __init__(self, map: RGMap) -> None:
        self.map = map
        self._regions = list(map.regions.values())
        self._shapes = {r.id: polygons.polygon(r.boundary, r.holes) for r in self._regions}
        self._outlines = list(self._shapes.values())
        self._ends = np.array([(v.start, v.end) for v in map.lines.values()], float).reshape(-1, 2, 2)
        home = np.array([v.regions[0] if v.regions else "" for v in map.lines.values()], str)
        self._lines = {id: self._ends[home == id] for id in map.regions}
        self._roads: dict[float, Roads] = {}

    def region_of(self, points: np.ndarray) -> np.ndarray:
        """(N,) index into ``list(map.regions)`` of the region at points (N, 2); -1 where there is none.

        A region's edge belongs to it, an edge or a place that several share to the first of them.
        """
        return polygons.locate(self._outlines, points)

    def region_at(self, x: float, y: float) -> Region | None:
        """The region at a point, None outside of all."""
        found = int(self.region_of(np.array([[x, y]]))[0])
        return self._regions[found] if found >= 0 else None

    def gateways_from(self, place: Place, width: float = 0.0) -> list[Gateway]:
        """The gateways of a region, or of the region at a pose, that a robot of a ``width`` [m] fits through.

        QueryError where there is no such region, or none at the pose.
        """
        here = (self.map.gateways[g] for g in self.map.gateways_of(self._regions[self._stop(place).region].id))
        return [g for g in here if g.width >= width]

    def objects_in(self, place: Place) -> list[MapObject]:
        """The objects in a region, or in the region at a pose. QueryError as ``gateways_from``."""
        region = self._regions[self._stop(place).region].id
        return [self.map.objects[o] for o in self.map.objects_of(region)]

    def predicted_scan(self, pose: Sequence[float] | np.ndarray, bearings: np.ndarray, max_range: float) -> np.ndarray:
        """(B,) m, what a laser at ``pose`` (x, y, theta) would measure along ascending ``bearings`` (B,) [rad].

        The back-projection of the paper (section IV-C) from all lines of the map; inf where it meets none of them.
        """
        return predict(self._ends, np.asarray(pose, float).reshape(1, 3), np.asarray(bearings, float), max_range)[0]

    def route(self, start: Place, goal: Place, width: float = 0.0) -> Route:
        """The shortest way for a robot's middle, at least half its ``width`` [m] from all outlines and lines.

        Only gateways that are as wide are passed. A region stands for its middle. Where start, goal or a gateway-point
        are nearer to one, the robot comes from there straight to where it has room.
        NoRoute with a sentence where there is no way; QueryError for a place that is not in the map.
        """
        a, b = self._stop(start, "the start"), self._stop(goal, "the goal")
        found = self._roads_for(width).route(a, b)
        if found is None:
            raise NoRoute(why_blocked(self.map, self._roads_for(width), a, b))
        return found

    def why_not(self, start: Place, goal: Place, width: float = 0.0) -> str | None:
        """Why there is no route, as a sentence; None where there is one."""
        try:
            self.route(start, goal, width)
        except QueryError as none:
            return str(none)
        return None

    def unexplored(self) -> list[Gateway]:
        """The gateways that were seen but not passed, or that lead nowhere: to fewer than two regions of the map."""
        return [
            g for g in self.map.gateways.values() if not g.passed or len(set(g.regions) & self.map.regions.keys()) < 2
        ]

    def _roads_for(self, width: float) -> Roads:
        if not 0 <= width < np.inf:
            raise QueryError(f"the width of a robot must be 0 m or more; it is {width}")
        if width not in self._roads:
            self._roads[width] = Roads(self._shapes, self._lines, list(self.map.gateways.values()), width)
        return self._roads[width]

    def _stop(self, place: Place, called: str = "the pose") -> Stop:
        """The point and region that are meant."""
        if isinstance(place, str):
            region = self._named(place)
            middle, _ = polygons.label_place(self._regions[region].boundary, self._regions[region].holes)
            return Stop(np.array(middle), region)
        point = np.asarray(place, float)[:2]
        if point.shape != (2,) or not np.isfinite(point).all():
            raise QueryError(f"{called} must be a region, or x, y [m] and maybe an angle; it is {place}")
        region = int(self.region_of(point[None])[0])
        if region < 0:
            region, far = self._nearest(point)
            if not far <= DOORSTEP:
                near = f"; the nearest, {self._regions[region].id}, is {far:.1f} m away" if region >= 0 else ""
                raise QueryError(f"{called} ({point[0]:.2f}, {point[1]:.2f}) lies in no region{near}")
        return Stop(point, region)

    def _nearest(self, point: np.ndarray) -> tuple[int, float]:
        """The nearest region and its distance [m]."""
        far = [float(np.hypot(*(polygons.nearest(s, point)[0] - point))) for s in self._outlines]
        return (int(np.argmin(far)), min(far)) if far else (-1, np.inf)

    def _named(self, name: str) -> int:
        """The index of a region called by its id or, where no other has it, by its name."""
        if name in self.map.regions:
            return list(self.map.regions).index(name)
        same = [i for i, r in enumerate(self._regions) if r.name.casefold() == name.casefold()]
        if len(same) != 1:
            ids = " and ".join(self._regions[i].id for i in same)
            raise QueryError(f"{ids} are both called {name}; say which by its id" if same else f"no region is {name}")
        return same[0]
