"""The map as ``building.yaml`` of Open-RMF's traffic editor: walls, floors, doors and lanes of one level, in metres."""

from __future__ import annotations

from typing import Any

import yaml

from rgcore.exports.nav2_route import Lanes
from rgcore.exports.options import Exported, Options
from rgcore.model.base import natural
from rgcore.model.records import RGMap
from rgcore.slam.trajectory import Trajectory

_TEXT, _INT, _FLOAT, _BOOL = 1, 2, 3, 4  # how the format tells the type of a parameter
_LOST = (
    "class scores, main axes and objects",
    "classes of gateways other than doors: those are lanes only",
)


def render(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """The YAML file; walls are the lines that are no clutter, lanes those of the route graph."""
    level = _Level()
    lanes = Lanes(map)
    for (x, y), about in lanes.nodes:
        level.vertex(x, y, level.unique(about.get("name", ""), about["rg_id"]) if about["kind"] == "region" else "")
    two_ways = sorted({(min(a, b), max(a, b)) for a, b, _ in lanes.edges})
    ways = [[a, b, {"bidirectional": [_BOOL, True], "graph_idx": [_INT, 0]}] for a, b in two_ways]
    walls = [
        [level.vertex(*v.start), level.vertex(*v.end), {"rg_id": [_TEXT, v.id]}]
        for v in _ordered(map.lines)
        if not v.clutter
    ]
    doors = [
        [level.vertex(*g.posts[0]), level.vertex(*g.posts[1]), _door(level.unique(g.name, g.id))]
        for g in _ordered(map.gateways)
        if g.class_ == "narrow_passage"
    ]
    floors, holes = [], []
    for r in _ordered(map.regions):
        about = {"rg_id": [_TEXT, r.id], "rg_name": [_TEXT, r.name], "rg_class": [_TEXT, r.class_]}
        if r.accuracy is not None:
            about["rg_accuracy"] = [_FLOAT, r.accuracy]
        floors.append({"parameters": about, "vertices": [level.vertex(x, y) for x, y in r.boundary]})
        for hole in r.holes:
            vertices = [level.vertex(x, y) for x, y in hole]
            holes.append({"parameters": {"rg_id": [_TEXT, r.id]}, "vertices": vertices})
    document = {
        "coordinate_system": "cartesian_meters",
        "graphs": {},
        "levels": {
            "L1": {
                "doors": doors,
                "elevation": 0.0,
                "fiducials": [],
                "floors": floors,
                "holes": holes,
                "lanes": ways,
                "layers": {},
                "measurements": [],
                "models": [],
                "vertices": level.vertices,
                "walls": walls,
            }
        },
        "lifts": {},
        "name": options.stem,
    }
    text = yaml.safe_dump(document, sort_keys=False, allow_unicode=True, default_flow_style=None, width=120)
    return Exported(text.encode(), lost=(*_LOST, *lanes.gaps))


class _Level:
    """Vertices, which everything else names by their numbers."""

    def __init__(self) -> None:
        self.vertices: list[list[Any]] = []
        self._names: set[str] = set()

    def unique(self, name: str, id: str) -> str:
        """A name that no other has: a fleet goes to places by their names, and refuses a map with two of one."""
        free = next(n for n in (name, f"{name} ({id})", id, f"{id}'") if n and n not in self._names)
        self._names.add(free)
        return free

    def vertex(self, x: float, y: float, name: str = "") -> int:
        self.vertices.append([float(x), float(y), 0.0, name])
        return len(self.vertices) - 1


def _door(name: str) -> dict[str, list[Any]]:
    return {
        "motion_axis": [_TEXT, "start"],
        "motion_degrees": [_FLOAT, 90.0],
        "motion_direction": [_INT, 1],
        "name": [_TEXT, name],
        "type": [_TEXT, "hinged"],
    }


def _ordered(items: dict[str, Any]) -> list[Any]:
    return [items[k] for k in sorted(items, key=natural)]
