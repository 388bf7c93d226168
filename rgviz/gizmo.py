"""The box of an object under the hand: the gizmo of one browser, and the sizes typed beside it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import viser

from rgcore.errors import EditError
from rgcore.model.edits import Edit, MoveObject
from rgcore.model.records import MapObject, replace, rounded


class Gizmo:
    """Arrows and an arc on one box, in the scene of one browser; ``moved`` hears phase, position and quaternion."""

    def __init__(
        self, scene: viser.SceneApi, moved: Callable[[str, tuple[float, ...], tuple[float, ...]], None]
    ) -> None:
        self._scene, self._moved = scene, moved
        self._node: Any = None
        self.box: MapObject | None = None

    def hold(self, box: MapObject | None) -> None:
        """Stand on this box, where it stands now; on none."""
        if self._node is not None and (box is None or self.box is None or self.box.id != box.id):
            self._node.remove()
            self._node = None
        if box is not None and self._node is None:
            self._node = self._made(box)
        elif box is not None and self.box is not box:
            self._node.position, self._node.wxyz = box.center, quaternion(box.yaw)
        self.box = box

    def let_go(self) -> None:
        """Forget where the hand took it: the next ``hold`` puts it back to where its box stands."""
        if self._node is not None:
            self._node.remove()
        self._node = self.box = None

    def _made(self, box: MapObject) -> Any:
        node = self._scene.add_transform_controls(
            "/gizmo", scale=70, fixed=True, line_width=3, active_axes=(True, True, False), depth_test=False,
            position=box.center, wxyz=quaternion(box.yaw),
        )  # fmt: skip

        @node.on_update
        async def _(event: Any) -> None:
            if event.client is not None:
                self._moved(event.phase, tuple(event.target.position), tuple(event.target.wxyz))

        return node


def dragged(box: MapObject, position: tuple[float, ...], wxyz: tuple[float, ...]) -> MapObject:
    """The box as the gizmo holds it: moved on the floor and turned about the vertical."""
    if not all(math.isfinite(v) for v in (*position, *wxyz)) or not any(wxyz):
        raise EditError("a box must stand at a place and in a direction that are numbers")
    w, x, y, z = wxyz
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    center = (_short(position[0]), _short(position[1]), box.center[2])
    return replace(box, center=center, yaw=_short(yaw))


def quaternion(yaw: float) -> tuple[float, float, float, float]:
    """wxyz of a turn about the vertical."""
    return math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)


def resized(box: MapObject, field: str, value: float) -> MapObject:
    """The box with its ``length``, ``width``, ``height`` [m] or ``turn`` [degrees] changed; it stays on its floor."""
    if not math.isfinite(value):
        raise EditError(f"the {field} of an object must be a number")
    if field == "turn":
        return replace(box, yaw=_short(math.remainder(math.radians(value), 2 * math.pi)))
    if value <= 0:
        raise EditError(f"the {field} of an object must be above 0 m")
    x, y, z = box.center
    along, across, high = box.size
    floor = z - high / 2
    size = {"length": (value, across, high), "width": (along, value, high), "height": (along, across, value)}[field]
    return replace(box, size=size, center=(x, y, _short(floor + size[2] / 2)))


def move(box: MapObject) -> Edit:
    """The edit that puts an object where this box stands."""
    return MoveObject(object=box.id, center=box.center, size=box.size, yaw=box.yaw)


def _short(value: float) -> float:
    """A tenth of a millimetre: no hand is finer."""
    return rounded(round(float(value), 4))
