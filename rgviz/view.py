"""The view of one browser: what it has selected, which layers it shows, its panels. The map itself is common to all."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import viser
import viser._messages

from rgcore.errors import EditError, RgError
from rgcore.model.draft import object_from_lines
from rgcore.model.edits import Edit
from rgcore.model.records import MapObject, RGMap
from rgviz import highlight, theme, tools
from rgviz.bridge import Bridge, Commit, FromBrowser
from rgviz.panels import Panels
from rgviz.picking import Item
from rgviz.scene import FLAT_LIGHT, SOLID_LIGHT, Canvas

if TYPE_CHECKING:
    from rgviz.app import App


class View:
    """One browser. All methods run on the editor's thread."""

    def __init__(self, app: App, client: viser.ClientHandle) -> None:
        self.app, self.client = app, client
        self.selection: tuple[Item, ...] = ()
        self.flat = True
        self._marks = Canvas(client.scene, "/selection")
        self._preview = Canvas(client.scene, "/preview")
        self._gizmo: Any = None
        self._held: MapObject | None = None
        self.bridge = Bridge(client, self._heard)
        self.show_title()
        self.panels = Panels(self)
        self.show_extent()
        self.tell_labels()

    @property
    def map(self) -> RGMap:
        return self.app.map

    # ---- asked for by the person ------------------------------------------------------------------

    def post(self, task: Callable[..., None], *args: Any) -> None:
        """Let the editor's thread do it; a refusal is told to this browser alone."""
        self.app.worker.post(task, *args, refused=self.refuse)

    def refuse(self, why: str) -> None:
        self.client.add_notification("Not done", why, color="red", auto_close_seconds=8, with_close_button=True)
        self.panels.refresh()

    def click(self, event: Any, add: bool = False) -> None:
        """A click on the picture selects what lies under it; with ``add`` a line is added to the selection."""
        ray = (np.asarray(event.ray_origin), np.asarray(event.ray_direction))
        item = self.app.picker(self.map).at(self.client.camera, event.screen_pos, ray, lines_first=add)
        if item is not None:
            self.select(tools.added(self.selection, item) if add else (item,))
        elif not add:
            self.select(())

    def select(self, items: tuple[Item, ...]) -> None:
        self.selection = tools.still_there(self.map, items)
        self.panels.show_selection()
        self.client.flush()  # the words need no frame of the picture: let them go ahead
        self._draw_selection()

    def do(self, edit: Edit) -> None:
        self.app.opened.do(edit, by="browser")

    def undo(self) -> None:
        self.app.opened.undo(by="browser")

    def redo(self) -> None:
        self.app.opened.redo(by="browser")

    def relabel(self, class_: str) -> None:
        """Give every selected region or gateway this class."""
        for item in self._some("Select a region first"):
            self.do(tools.classify(item, class_))

    def rename(self, name: str) -> None:
        self.do(tools.rename(self._some("Select something first")[0], name))

    def edit_name(self) -> None:
        self._some("Select a region, gateway or object first")
        self.panels.focus_name()

    def make_object(self) -> None:
        """A box over the selected lines, selected afterwards."""
        lines = [i.id for i in self.selection if i.kind == "line"]
        if not lines:
            raise EditError("Select the lines of the object first: click one, Shift+click the others.")
        edit = object_from_lines(self.map, lines, self.panels.new_height)
        self.do(edit)
        self.select((Item("object", edit.id),))

    def delete(self) -> None:
        for item in self._some("Select a gateway or an object first"):
            self.do(tools.delete(item))

    def resize(self, field: str, value: float) -> None:
        item = self._some("Select an object first")[0]
        self.do(tools.move(tools.resized(self.map.objects[item.id], field, value)))

    def fit(self) -> None:
        self.bridge.tell("fit", extent=None)

    def fit_selection(self) -> None:
        extent = tools.extent_of(self.map, self._some("Select something first"))
        self.bridge.tell("fit", extent=None if extent is None else extent.tolist())

    def turn(self, flat: bool | None = None) -> None:
        """Straight down, or from the side with the walls raised."""
        self.flat = not self.flat if flat is None else flat
        self.bridge.tell("view", mode="2d" if self.flat else "3d")
        self.panels.set_layer("/walls", not self.flat)
        self._show_node(FLAT_LIGHT, self.flat)
        self._show_node(SOLID_LIGHT, not self.flat)

    def show_layer(self, name: str, shown: bool) -> None:
        """For this browser alone."""
        if name == "/labels":
            self.bridge.tell("labels-shown", shown=shown)
        else:
            self._show_node(name, shown)

    # ---- told by the app --------------------------------------------------------------------------

    def map_changed(self) -> None:
        """The map is another one: let go of what is gone, show what is there."""
        self.selection = tools.still_there(self.map, self.selection)
        self.panels.refresh()
        self.client.flush()
        self._draw_selection()
        self.tell_labels()

    def show_title(self) -> None:
        self.bridge.tell("title", text=f"{self.app.title} - {theme.NAME}")

    def show_extent(self) -> None:
        self.bridge.tell("extent", extent=self.app.scene.extent.tolist())

    def tell_labels(self) -> None:
        self.bridge.tell("labels", labels=self.app.labels(self.map))

    # ---- parts ------------------------------------------------------------------------------------

    def _some(self, why_not: str) -> tuple[Item, ...]:
        if not self.selection:
            raise EditError(f"{why_not}.")
        return self.selection

    def _show_node(self, name: str, shown: bool) -> None:
        message = viser._messages.SetSceneNodeVisibilityMessage(name, shown)
        self.client._websock_connection.queue_message(message)

    def _heard(self, message: FromBrowser) -> None:
        if isinstance(message, Commit):
            self.post(self.panels.commit, message.field, message.value)
        else:
            self.post(self.panels.refresh)

    def _draw_selection(self) -> None:
        with self.client.atomic():
            self._marks.draw(highlight.marks(self.map, self.selection, self.app.scene.artist))
            self._preview.clear()
            self._hold()
        self.bridge.tell("selected", ids=[i.id for i in self.selection])

    def _hold(self) -> None:
        """A gizmo on the selected object, where it stands now."""
        one = self.selection[0] if len(self.selection) == 1 else None
        box = self.map.objects[one.id] if one is not None and one.kind == "object" else None
        if box is None or self.app.read_only:
            if self._gizmo is not None:
                self._gizmo.remove()
            self._gizmo = self._held = None
            return
        place = (box.center[0], box.center[1], box.center[2])
        if self._gizmo is None or self._held is None or self._held.id != box.id:
            if self._gizmo is not None:
                self._gizmo.remove()
            self._gizmo = self._add_gizmo(place, tools.quaternion(box.yaw))
        elif self._held is not box:
            self._gizmo.position, self._gizmo.wxyz = place, tools.quaternion(box.yaw)
        self._held = box

    def _add_gizmo(self, place: tuple[float, float, float], wxyz: tuple[float, float, float, float]) -> Any:
        gizmo = self.client.scene.add_transform_controls(
            "/gizmo", scale=70, fixed=True, line_width=3, active_axes=(True, True, False), depth_test=False,
            position=place, wxyz=wxyz,
        )  # fmt: skip

        @gizmo.on_update
        async def _(event: Any) -> None:
            if event.client is not None:
                self.post(self._drag, event.phase, tuple(event.target.position), tuple(event.target.wxyz))

        return gizmo

    def _drag(self, phase: str, position: tuple[float, ...], wxyz: tuple[float, ...]) -> None:
        """The hand moves: the box is shown there. The hand lets go: one edit is made."""
        if self._held is None:
            return
        box = tools.dragged(self._held, position, wxyz)
        if phase != "end":
            self._preview.draw(highlight.box(box))
            return
        try:
            self.do(tools.move(box))
        except RgError:
            self._held = None  # back to where it stands
            self._draw_selection()
            raise
        self._draw_selection()
