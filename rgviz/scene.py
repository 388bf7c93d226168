"""The scene that all browsers share: draws layers into viser and keeps to what has changed."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from rgcore.model.records import RGMap
from rgviz import theme
from rgviz.artist import Artist
from rgviz.drawings import Dots, Drawing, Drawings, Faces, Strokes
from rgviz.glb import strokes_glb
from rgviz.layers import LAYERS, Layer, extent, growing_path, outdated

FLAT_LIGHT, SOLID_LIGHT = "/light/flat", "/light/solid"
MOST_THICK = 1200
"""strokes of a drawing that are drawn thick; more become a pixel wide, which is six times faster without a GPU"""


class Canvas:
    """A group of nodes, drawn from values: what is equal to what stands there is left alone."""

    def __init__(self, scene: viser.SceneApi, root: str) -> None:
        self.scene, self.root = scene, root
        self.drawn: Drawings = {}
        self.nodes: dict[str, Any] = {}

    def draw(self, drawings: Drawings) -> int:
        """Show exactly these drawings; the number of nodes that had to be touched."""
        wanted = {k: d for k, d in drawings.items() if not _empty(d)}
        touched = 0
        for name in [n for n in self.nodes if n not in wanted]:
            self.nodes.pop(name).remove()
            self.drawn.pop(name)
            touched += 1
        for name, drawing in wanted.items():
            if name not in self.drawn or not _equal(self.drawn[name], drawing):
                if not (name in self.drawn and _update(self.nodes[name], self.drawn[name], drawing)):
                    self.nodes[name] = _add(self.scene, f"{self.root}/{name}", drawing)
                self.drawn[name] = drawing
                touched += 1
        return touched

    def clear(self) -> None:
        self.draw({})


class Scene:
    """Every layer of the map in the browsers' common scene."""

    def __init__(self, server: viser.ViserServer) -> None:
        self.server = server
        self.artist = Artist()
        self.map: RGMap | None = None
        scene = server.scene
        scene.set_up_direction("+z")
        scene.world_axes.visible = False
        scene.configure_environment_map(None)  # loading it blocks a page for seconds where there is no GPU
        scene.configure_default_lights(enabled=False, cast_shadow=False)
        # either way a floor gets exactly its colour; only the solid view pays for shading walls
        scene.add_frame(FLAT_LIGHT, show_axes=False)
        scene.add_light_ambient(f"{FLAT_LIGHT}/sky", intensity=np.pi)
        scene.add_frame(SOLID_LIGHT, show_axes=False, visible=False)
        scene.add_light_ambient(f"{SOLID_LIGHT}/sky", intensity=0.62 * np.pi)
        scene.add_light_directional(f"{SOLID_LIGHT}/sun", intensity=0.38 * np.pi / SUN[2], position=tuple(10 * SUN))
        self._growing = Canvas(scene, "/growing")
        self._wanted = {layer.name for layer in LAYERS if layer.shown}
        self.layers: dict[str, Canvas] = {}
        for layer in LAYERS:
            scene.add_frame(layer.name, show_axes=False, visible=layer.shown)
            self.layers[layer.name] = Canvas(scene, layer.name)

    @property
    def extent(self) -> np.ndarray:
        """(2, 2) lower left and upper right of what there is to see [m]."""
        return extent(self.map or RGMap(), self.artist)

    def show_evidence(self, points: np.ndarray, trajectory: np.ndarray, growing: bool = False) -> None:
        """Points (K, 2) and path (N, 2) [m] in the map frame; while they are ``growing`` the path is always shown."""
        self.artist.points, self.artist.trajectory = points, trajectory
        self._redraw([layer for layer in LAYERS if not layer.reads and layer.name in self._wanted])
        self._growing.draw(growing_path(trajectory) if growing else {})

    def show(self, map_: RGMap) -> list[str]:
        """Show this map; the names of the layers that were drawn anew. What nobody has looked at yet is not drawn."""
        before, self.map = self.map, map_
        if before is None or before.regions.keys() != map_.regions.keys():
            self.artist.colors = theme.region_colors(map_, self.artist.colors)
        seen = [layer for layer in LAYERS if layer.name in self._wanted]
        return self._redraw([layer for layer in seen if layer.reads and outdated(layer, before, map_)])

    def want(self, name: str) -> None:
        """A browser is going to show this layer: from now on it is kept up."""
        if name not in self._wanted:
            self._wanted.add(name)
            self._redraw([layer for layer in LAYERS if layer.name == name])

    def _redraw(self, layers: list[Layer]) -> list[str]:
        drawn = [(layer.name, layer.draw(self.map or RGMap(), self.artist)) for layer in layers]
        with self.server.atomic():
            return [name for name, drawings in drawn if self.layers[name].draw(drawings)]


SUN = np.array([-0.35, -0.5, 0.79]) / np.linalg.norm([-0.35, -0.5, 0.79])


def _empty(drawing: Drawing) -> bool:
    if isinstance(drawing, Faces):
        return not len(drawing.faces)
    return not len(drawing.ends if isinstance(drawing, Strokes) else drawing.points)


def _equal(a: Drawing, b: Drawing) -> bool:
    if type(a) is not type(b):
        return False
    return all(_same(getattr(a, f), getattr(b, f)) for f in a.__dataclass_fields__)


def _same(x: Any, y: Any) -> bool:
    if isinstance(x, np.ndarray) or isinstance(y, np.ndarray):
        return np.array_equal(x, y)
    return bool(x == y)


def _update(node: Any, old: Drawing, new: Drawing) -> bool:
    """Give a node its new shape, which is cheaper for the browser than a new node; False if it must be a new one."""
    if isinstance(old, Faces) and isinstance(new, Faces):
        if (old.color, old.opacity, old.shaded) != (new.color, new.opacity, new.shaded):
            return False
        node.vertices, node.faces = new.vertices, new.faces.astype(np.uint32)
        return True
    if isinstance(old, Strokes) and isinstance(new, Strokes) and _thin(old) and _thin(new):
        node.glb_data = strokes_glb(new.ends, new.color)
        return True
    if isinstance(old, Dots) and isinstance(new, Dots) and (old.size, old.shape) == (new.size, new.shape):
        if old.color != new.color:
            return False
        node.points = new.points
        return True
    return False


def _thin(drawing: Strokes) -> bool:
    return drawing.width <= theme.THIN_WIDTH or len(drawing.ends) > MOST_THICK


def _add(scene: viser.SceneApi, name: str, drawing: Drawing) -> Any:
    """A node for a drawing; one of the same name is replaced."""
    if isinstance(drawing, Strokes) and _thin(drawing):
        return scene.add_glb(name, strokes_glb(drawing.ends, drawing.color), cast_shadow=False, receive_shadow=False)
    if isinstance(drawing, Strokes):
        color = theme.srgb_to_linear(drawing.color) if isinstance(drawing.color, np.ndarray) else drawing.color
        if isinstance(color, np.ndarray):
            color = np.repeat(color[:, None], 2, 1)
        return scene.add_line_segments(name, drawing.ends, color, thickness=drawing.width, thickness_units="screen")
    if isinstance(drawing, Dots):
        return scene.add_point_cloud(
            name,
            drawing.points,
            drawing.color,
            point_size=drawing.size,
            point_shape=drawing.shape,  # type: ignore[arg-type]
            precision="float32",
            point_shading="flat",
        )
    return scene.add_mesh_simple(
        name,
        drawing.vertices,
        drawing.faces.astype(np.uint32),
        color=drawing.color,
        opacity=None if drawing.opacity == 1 else drawing.opacity,
        side="double" if drawing.both_sides else "front",
        flat_shading=drawing.shaded,
        cast_shadow=False,
        receive_shadow=False,
    )
