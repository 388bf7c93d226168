"""The map as a glTF 2.0 binary: floors, lines, walls, gateways and object boxes as named nodes, in metres.

The map's own frame has z up; the root node ``map`` turns it to glTF's y up, and everything below it keeps the
coordinates of the map. What an item *is* stands in the ``extras`` of its node, a JSON object as the specification of
glTF 2.0 asks for (section 5.18.1).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rgcore.exports.options import Exported, Options
from rgcore.exports.palette import GATEWAY, OBJECT, RGB, as_hex, class_color
from rgcore.exports.rgjson import FORMAT, VERSION
from rgcore.geometry.polygons import triangulate
from rgcore.model.base import natural
from rgcore.model.records import Gateway, MapObject, Region, RGMap
from rgcore.slam.trajectory import Trajectory

if TYPE_CHECKING:
    import trimesh

WALL: RGB = (222, 222, 218)
THRESHOLD_DEPTH = 0.2  # m, a gateway shows as a strip of this depth
_ABOVE_FLOOR = 0.01  # m, so that strip and floor do not flicker through each other
_Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""x stays, z becomes y, y becomes -z."""

_LOST = ("notes, the trajectory, boxes of robot positions, how sure a line is, by whom and when",)


def render(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """The map as GLB; lines are extruded to ``options.wall_height``."""
    import trimesh
    from trimesh.exchange.gltf import export_glb

    scene = trimesh.Scene(base_frame="world")
    scene.metadata.update(format=FORMAT, version=VERSION, frame="map", log=map.source.log, sha256=map.source.sha256)
    scene.graph.update("map", "world", matrix=_Y_UP, metadata={"kind": "map"})
    for group in ("floors", "lines", "walls", "gateways", "objects"):
        scene.graph.update(group, "map", metadata={"kind": group})
    for r in _ordered(map.regions):
        _add(scene, f"region {r.id}", "floors", _floor(r), class_color(r.class_), _about_region(map, r))
    for region, lines in _walls(map).items():
        name = f"walls {region or 'without region'}"
        about = {"kind": "walls", "region": region or None, "lines": [line.id for line in lines]}
        _add(scene, name, "walls", _extruded(lines, options.wall_height), WALL, about)
        _trace(scene, name.replace("walls", "lines", 1), lines, {**about, "kind": "lines"})
    for g in _ordered(map.gateways):
        _add(scene, f"gateway {g.id}", "gateways", _threshold(g), GATEWAY, _about_gateway(g))
    for o in _ordered(map.objects):
        _add(scene, f"object {o.id}", "objects", _UNIT_BOX, OBJECT, _about_object(o), _placed(o))
    data: bytes = export_glb(scene)  # scene.export refuses a map that is still empty
    return Exported(data, lost=_LOST)


Mesh = tuple[np.ndarray, np.ndarray]
"""Vertices (V, 3) [m] and faces (F, 3)."""


def _add(
    scene: trimesh.Scene, name: str, parent: str, mesh: Mesh, color: RGB, extras: dict[str, Any], matrix: Any = None
) -> None:
    """A node; without geometry where the mesh is empty, so that every item of the map is there."""
    import trimesh

    vertices, faces = mesh
    if not len(faces):
        scene.graph.update(name, parent, metadata=extras)
        return
    shape = trimesh.Trimesh(vertices, faces, process=False)
    shape.visual = trimesh.visual.TextureVisuals(material=_material(color))
    scene.add_geometry(
        shape, node_name=name, geom_name=name, parent_node_name=parent, transform=matrix, metadata=extras
    )


def _trace(scene: trimesh.Scene, name: str, lines: list[Any], extras: dict[str, Any]) -> None:
    """The lines themselves on the floor; importers that know no lines (Blender) still have the walls."""
    import trimesh

    ends = np.array([[(*line.start, _ABOVE_FLOOR), (*line.end, _ABOVE_FLOOR)] for line in lines], float)
    drawn = trimesh.path.Path3D(
        entities=[trimesh.path.entities.Line([2 * i, 2 * i + 1]) for i in range(len(lines))],
        vertices=ends.reshape(-1, 3),
        process=False,
    )
    scene.add_geometry(drawn, node_name=name, geom_name=name, parent_node_name="lines", metadata=extras)


def _material(color: RGB) -> Any:
    """Both sides show; factors are linear (glTF 2.0, 3.9.2) where the palette is sRGB."""
    import trimesh

    c = np.array(color) / 255
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return trimesh.visual.material.PBRMaterial(
        name=as_hex(color),
        baseColorFactor=np.append(linear, 1.0),
        metallicFactor=0.0,
        roughnessFactor=0.9,
        doubleSided=True,
    )


def _floor(region: Region) -> Mesh:
    if len(region.boundary) < 3:
        return np.zeros((0, 3)), np.zeros((0, 3), int)
    triangles = triangulate(region.boundary, region.holes)
    corners, faces = np.unique(triangles.reshape(-1, 2), axis=0, return_inverse=True)
    return np.column_stack([corners, np.zeros(len(corners))]), faces.reshape(-1, 3)


def _walls(map: RGMap) -> dict[str, list[Any]]:
    """Lines by the region whose free space they bound; those of none under an empty name."""
    out: dict[str, list[Any]] = {id: [] for id in sorted(map.regions, key=natural)}
    for line in _ordered(map.lines):
        home = next((r for r in line.regions if r in map.regions), "")
        out.setdefault(home, []).append(line)
    return {region: lines for region, lines in out.items() if lines}


def _extruded(lines: list[Any], height: float) -> Mesh:
    """A vertical quad a line, which faces its free side."""
    ends = np.array([[line.start, line.end] for line in lines], float)
    corners = ends[:, [0, 1, 1, 0]]
    z = np.broadcast_to([0.0, 0.0, height, height], corners.shape[:2])
    vertices = np.concatenate([corners, z[..., None]], 2).reshape(-1, 3)
    quad = np.array([[0, 2, 1], [0, 3, 2]])
    return vertices, (4 * np.arange(len(lines))[:, None, None] + quad).reshape(-1, 3)


def _threshold(gateway: Gateway) -> Mesh:
    """A strip on the floor from post to post."""
    a, b = np.array(gateway.posts, float)
    along = (b - a) / max(float(np.hypot(*(b - a))), 1e-9)
    across = 0.5 * THRESHOLD_DEPTH * np.array([-along[1], along[0]])
    corners = np.array([a - across, b - across, b + across, a + across])
    return np.column_stack([corners, np.full(4, _ABOVE_FLOOR)]), np.array([[0, 1, 2], [0, 2, 3]])


def _unit_box() -> Mesh:
    vertices = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


_UNIT_BOX = _unit_box()


def _placed(o: MapObject) -> np.ndarray:
    """(4, 4) that makes the unit box the object's: scaled by its size, turned by its yaw, moved to its middle."""
    c, s = np.cos(o.yaw), np.sin(o.yaw)
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) * o.size
    matrix[:3, 3] = o.center
    return matrix


def _about_region(map: RGMap, r: Region) -> dict[str, Any]:
    return {
        "kind": "region",
        "id": r.id,
        "name": r.name,
        "class": r.class_,
        "class_scores": dict(sorted(r.class_scores.items())),
        "accuracy": r.accuracy,
        "axes": list(r.axes),
        "gateways": sorted(map.gateways_of(r.id), key=natural),
        "provenance": r.provenance.source,
    }


def _about_gateway(g: Gateway) -> dict[str, Any]:
    return {
        "kind": "gateway",
        "id": g.id,
        "name": g.name,
        "class": g.class_,
        "confidence": g.confidence,
        "regions": list(g.regions),
        "width": g.width,
        "passed": g.passed,
        "posts": [list(p) for p in g.posts],
        "crossing_points": [list(p) for p in g.crossing_points],
        "gateway_points": [list(p) for p in g.gateway_points],
        "provenance": g.provenance.source,
    }


def _about_object(o: MapObject) -> dict[str, Any]:
    return {
        "kind": "object",
        "id": o.id,
        "name": o.label,
        "class": o.label,
        "region": o.region,
        "size": list(o.size),
        "lines": list(o.lines),
        "confidence": o.confidence,
        "provenance": o.provenance.source,
    }


def _ordered(items: dict[str, Any]) -> list[Any]:
    return [items[id] for id in sorted(items, key=natural)]
