"""Floor plans in the picture: under the lines, over the floors, white paper being clear."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import viser

from rgcore.errors import RgError
from rgcore.model.records import Backdrop, RGMap
from rgcore.scans.backdrop import Drawing, Plan, read_backdrop
from rgviz import theme
from rgviz.glb import strokes_glb

if TYPE_CHECKING:
    from rgcore.model.project import Project

LAYER = "/backdrop"
"""the node that holds the plans; ``layers.LAYERS`` lists it"""
INK: theme.RGB = (120, 40, 130)
"""of the strokes of a drawing: no class, wall or gateway has it"""
HEIGHT = 0.005
"""m: over the floors, under all else"""


class Backdrops:
    """The plans of a project in the scene. All methods run on the editor's thread but for the reading of a file, which
    takes seconds."""

    def __init__(self, scene: viser.SceneApi, post: Callable[..., None]) -> None:
        self.scene, self._post = scene, post
        self.project: Project | None = None
        self.faults: dict[str, str] = {}
        """why a plan is not shown, by its checksum"""
        self._nodes: dict[str, tuple[str, Any]] = {}
        self._read: dict[str, Plan | None] = {}

    def show(self, map_: RGMap) -> None:
        """The plans of this map, each where it lies; those that are not read yet follow."""
        for id in [i for i in self._nodes if i not in map_.backdrops or self._nodes[i][0] != map_.backdrops[i].sha256]:
            self._nodes.pop(id)[1].remove()
        for id, plan in map_.backdrops.items():
            if id in self._nodes:
                _lay(self._nodes[id][1], plan)
            elif plan.sha256 not in self._read:
                self._fetch(plan)
            elif (content := self._read[plan.sha256]) is not None:
                self._nodes[id] = plan.sha256, _add(self.scene, f"{LAYER}/{id}", content, plan)

    def _fetch(self, plan: Backdrop) -> None:
        self._read[plan.sha256] = None
        project = self.project
        if project is not None:
            threading.Thread(target=self._take, args=(project, plan), daemon=True).start()

    def _take(self, project: Project, plan: Backdrop) -> None:
        """On a thread of its own."""
        try:
            content: Plan | None = read_backdrop(project.backdrop(plan.sha256), plan.name)
            fault = ""
        except RgError as e:
            content, fault = None, str(e)
        self._post(self._taken, project, plan.sha256, content, fault)

    def _taken(self, project: Project, sha256: str, content: Plan | None, fault: str) -> None:
        self._read[sha256] = content
        if fault:
            self.faults[sha256] = fault
        self.show(project.map)


def inked(pixels: np.ndarray) -> np.ndarray:
    """(H, W, 4) uint8: the picture (H, W, 3) with its white taken out, so that over white it looks as it did."""
    opaque = 255 - pixels.min(2).astype(np.int32)
    clear = 255 - opaque
    color = (pixels.astype(np.int32) - clear[:, :, None]) * 255 // np.maximum(opaque, 1)[:, :, None]
    return np.concatenate([color, opaque[:, :, None]], 2).astype(np.uint8)


def _add(scene: viser.SceneApi, name: str, content: Plan, plan: Backdrop) -> Any:
    """A node whose longer side is one metre; its scale says the rest."""
    if isinstance(content, Drawing):
        ends = np.zeros((len(content.strokes), 2, 3), np.float32)
        ends[:, :, :2] = content.strokes / max(content.size)
        node: Any = scene.add_glb(name, strokes_glb(ends, INK), cast_shadow=False, receive_shadow=False)
    else:
        width, height = np.array(content.size) / max(content.size)
        node = scene.add_image(name, inked(content.pixels), width, height, cast_shadow=False, receive_shadow=False)
    _lay(node, plan)
    return node


def _lay(node: Any, plan: Backdrop) -> None:
    c, s = np.cos(plan.yaw / 2), np.sin(plan.yaw / 2)
    up = plan.form != "dxf"
    node.wxyz = (0.0, c, s, 0.0) if up else (c, 0.0, 0.0, s)  # about z after the half turn about x
    node.position = (*plan.center, HEIGHT)
    node.scale = plan.length
