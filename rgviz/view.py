"""The view of one browser: what it has selected, which layers it shows, its panels. The map itself is common to all."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
import viser
import viser._messages

from rgcore.errors import EditError, RgError
from rgcore.model.draft import note_on, place_of
from rgcore.model.edits import AddBackdrop, Edit, WriteNote
from rgcore.model.outcome import Outcome, Remedy
from rgcore.model.records import Point, RGMap
from rgviz import actions, gizmo, highlight, page, selecting, theme
from rgviz.again.looking import Looking
from rgviz.bridge import Answer, Bridge, Commit, FromBrowser, Pointer, Press
from rgviz.figures import Figures
from rgviz.hands import Hands
from rgviz.help import sheet
from rgviz.panels import Panels
from rgviz.picking import Item, Kind
from rgviz.reviewing import Reviewing
from rgviz.scene import FLAT_LIGHT, SOLID_LIGHT, Canvas
from rgviz.selecting import Items
from rgviz.server import may_edit
from rgviz.session import Session
from rgviz.tools.drawing import SplitTool
from rgviz.tools.pointing import AssignTool, BoxTool, NoteTool
from rgviz.tools.reshaping import ReshapeTool
from rgviz.tools.tool import Question, Tool

if TYPE_CHECKING:
    from rgviz.app import App


AROUND = 2.5
"""m that are shown around an item that one is led to"""


class View:
    """One browser. All methods run on the editor's thread."""

    hands: Hands
    looking: Looking
    panels: Panels
    review: Reviewing

    def __init__(self, app: App, client: viser.ClientHandle) -> None:
        self.app, self.client = app, client
        self.guest = not may_edit(app.server, app.gate, client.client_id)
        self.selection: Items = ()
        self.flat, self.dark = True, False
        self._marks = Canvas(client.scene, "/selection")
        self._preview = Canvas(client.scene, "/preview")
        self._gizmo = gizmo.Gizmo(client.scene, lambda *how: self.post(self._drag, *how))
        self.looking = Looking(self)
        self.hands = Hands(self)
        self.review = Reviewing(self)
        self.bridge = Bridge(client, self._heard)
        self.show_title()
        self.panels = Panels(self)
        self._labels: dict[tuple[str, str], dict[str, Any]] = {}
        self.show_extent()
        self.tell_labels()
        self.looking.changed()

    @property
    def map(self) -> RGMap:
        """What this browser looks at: the map, or a new run of it."""
        return self.looking.map or self.app.map

    @property
    def figures(self) -> Figures | None:
        """What the evidence says of ``map``; nothing is kept of a run that only waits."""
        return self.app.figures if self.looking.map is None else None

    @property
    def read_only(self) -> bool:
        """Whether this browser can change nothing: nobody here can, it came by the link for looking, or it looks at a
        new run."""
        return self.guest or self.app.read_only or self.looking.map is not None

    # ---- asked for by the person ------------------------------------------------------------------

    def post(self, task: Callable[..., None], *args: Any) -> None:
        """Let the editor's thread do it; a refusal is told to this browser alone."""
        self.app.worker.post(task, *args, refused=self.refuse)

    def refuse(self, why: str) -> None:
        self.client.add_notification("Not done", why, color="red", auto_close_seconds=8, with_close_button=True)
        self.panels.refresh()

    def tell(self, title: str, text: str) -> None:
        """Something that this person should know."""
        self.client.add_notification(title, text, auto_close_seconds=8, with_close_button=True)

    def click(self, event: Any, add: bool = False) -> None:
        """A click on the picture selects what lies under it; with ``add`` it is added to what is selected, or taken
        away, and only its kind counts. Lines begin a selection of many where a region or nothing was selected."""
        if self.hands.busy:
            return
        if add and self._kind in (None, "region"):
            item = self._under(event, "line") or self._under(event, self._kind)
        else:
            item = self._under(event, self._kind if add else None)
        if item is not None:
            self.select(selecting.toggled(self.selection, item) if add else (item,))
        elif not add:
            self.select(())

    def select_within(self, low: tuple[float, float], high: tuple[float, float], add: bool) -> None:
        """A rectangle drawn on the picture, by its corners from (0, 0) to (1, 1): what lies in it is added or taken."""
        if self.hands.busy:
            return
        items = self.app.picker(self.map).within(self.client.camera, low, high)
        items = tuple(i for i in items if self._kind in (None, i.kind))
        self.select(selecting.added(self.selection, items) if add else selecting.without(self.selection, items))

    def select(self, items: Items) -> None:
        self.selection = selecting.still_there(self.map, items)
        self.panels.show_selection()
        self.client.flush()  # the words need no frame of the picture: let them go ahead
        self._draw_selection()
        self.hands.selected(self.selection)

    def select_ids(self, ids: Iterable[str]) -> None:
        """What a search or a list names: those of the kind that most of them are of."""
        self.select(selecting.of_ids(self.map, ids))

    def go_to(self, ids: Iterable[str], margin: float = 0.3) -> None:
        """Select items by their ids and show them with what is around."""
        self.select_ids(ids)
        extent = selecting.extent_of(self.map, self.selection, margin, AROUND)
        if extent is not None:
            self.bridge.tell("fit", extent=extent.tolist())

    def go_to_place(self, place: Point, around: float) -> None:
        """Show a place of the map with so many metres around it."""
        (x, y), r = place, around
        self.bridge.tell("fit", extent=[[x - r, y - r], [x + r, y + r]])

    def settle(self, outcome: Outcome, remedy: Remedy) -> None:
        """Do something about an edit that waits since a new run."""
        self._session.settle(outcome, remedy, by="browser")

    def do(self, edit: Edit) -> None:
        self._session.do(edit, by="browser")

    def lay(self, edit: AddBackdrop, data: bytes) -> None:
        """A floor plan, whose file is ``data``, lies under the map from now on."""
        self._session.lay(edit, data, by="browser")

    def undo(self) -> None:
        self._session.undo(by="browser")

    def redo(self) -> None:
        self._session.redo(by="browser")

    def back_to(self, number: int) -> None:
        """The map after that many edits of the history: undoes, or makes again, what lies between."""
        self._session.back_to(number, by="browser")

    def act(self, action: Callable[[RGMap, Items], Edit]) -> Edit:
        """Make the edit of an action on what is selected. Raises EditError if nothing is."""
        edit = action(self.map, self._some("Select something first"))
        self.do(edit)
        return edit

    def relabel(self, class_: str) -> None:
        """Give every selected region or gateway this class."""
        self.act(lambda _, items: actions.relabel(items, class_))

    def rename(self, name: str) -> None:
        self.act(lambda _, items: actions.rename(items[0], name))

    def edit_name(self) -> None:
        self._some("Select a region, gateway or object first")
        self.panels.focus_name()

    def make_object(self) -> None:
        """A box over the selected lines, selected afterwards."""
        edit = actions.box(self.map, self.selection, self.panels.new_height)
        self.do(edit)
        self.select((Item("object", edit.id),))  # type: ignore[attr-defined]

    def delete(self) -> None:
        """The last point of a tool; else what is selected."""
        if not self.hands.back():
            self.act(actions.delete)

    def merge(self) -> None:
        first = self._some("Select two regions or more that lie side by side")[:1]
        self.act(lambda _, items: actions.merge(items))
        self.select(first)

    def escape(self) -> None:
        """What a tool has drawn goes, then the tool, then the selection."""
        if not self.hands.cancel():
            self.select(())

    def take(self, tool: Tool) -> None:
        if tool.edits:
            self._session.project.must_write()
        self.hands.take(tool)

    def split(self, gateway: bool = False) -> None:
        """A line across the selected region, or the one that it begins in."""
        self.take(SplitTool(region=self._one if self._kind == "region" else None, gateway=gateway))

    def draw_box(self) -> None:
        """An object over what stands in a rectangle."""
        self.take(BoxTool(height=self.panels.new_height))

    def reshape(self) -> None:
        regions = selecting.ids_of(self.selection, "region")
        if len(regions) != 1:
            raise EditError("Select one region first.")
        self.take(ReshapeTool(regions[0]))

    def assign(self) -> None:
        self.take(AssignTool.for_(self.map, self.selection))

    def write_note(self) -> None:
        """On what is selected, or where one clicks; a selected note is written anew."""
        if not self.selection:
            self.take(NoteTool())
            return
        one = self.selection[0].id
        at = place_of(self.map, one)
        if one in self.map.notes:
            asked = Question("Note", at, lambda _, text: WriteNote(note=one, text=text))
            self.hands.ask(asked, self.map.notes[one].text)
        else:
            self.hands.ask(Question(f"Note on {one}", at, lambda m, text: note_on(m, text, one)))

    def resize(self, field: str, value: float) -> None:
        item = self._some("Select an object first")[0]
        self.do(gizmo.move(gizmo.resized(self.map.objects[item.id], field, value)))

    def fit(self) -> None:
        self.bridge.tell("fit", extent=None)

    def fit_selection(self) -> None:
        extent = selecting.extent_of(self.map, self._some("Select something first"))
        self.bridge.tell("fit", extent=None if extent is None else extent.tolist())

    def turn(self, flat: bool | None = None) -> None:
        """Straight down, or from the side with the walls raised."""
        self.flat = not self.flat if flat is None else flat
        self.bridge.tell("view", mode="2d" if self.flat else "3d")
        self.panels.set_layer("/walls", not self.flat)
        self.show_node(FLAT_LIGHT, self.flat)
        self.show_node(SOLID_LIGHT, not self.flat)

    def look_down(self) -> None:
        """The whole map from above."""
        self.turn(True)
        self.fit()

    def switch_look(self) -> None:
        """Light or dark, in this browser alone."""
        self.dark = not self.dark
        page.dress(self.client.gui, self.dark)
        self.bridge.tell("dark", on=self.dark)

    def show_keys(self) -> None:
        """The sheet of all commands, over the page."""
        self.bridge.tell("cheat-sheet", html=sheet())

    def show_layer(self, name: str, shown: bool) -> None:
        """For this browser alone."""
        if name == "/labels":
            self.bridge.tell("labels-shown", shown=shown)
        else:
            if shown:
                self.app.scene.want(name)
            self.looking.show_layer(name, shown)

    # ---- told by the app --------------------------------------------------------------------------

    def map_changed(self) -> None:
        """The map is another one: let go of what is gone, show what is there."""
        self.selection = selecting.still_there(self.map, self.selection)
        self.panels.refresh()
        self.client.flush()
        self._draw_selection()
        self.hands.map_changed()
        self.tell_labels()
        self.looking.show_pins()

    def again_changed(self) -> None:
        """A new run is further, there, decided about; or something is found to be different."""
        self.looking.changed()
        self.panels.refresh()

    def show_title(self) -> None:
        self.bridge.tell("title", text=f"{self.app.title} - {theme.NAME}")

    def show_extent(self) -> None:
        self.bridge.tell("extent", extent=self.app.scene.extent.tolist())

    def tell_labels(self) -> None:
        """Those that this browser does not have yet, and which ones are gone."""
        now = {(v["kind"], v["id"]): v for v in self.app.labels(self.map)}
        put = [v for k, v in now.items() if self._labels.get(k) != v]
        gone = [":".join(k) for k in self._labels if k not in now]
        self._labels = now
        if put or gone:
            self.bridge.tell("labels", put=put, gone=gone)

    # ---- parts ------------------------------------------------------------------------------------

    def must_edit(self) -> Session:
        """Raises EditError in a browser that came to look, whatever it sends."""
        if self.guest:
            raise EditError("This link is for looking. To correct the map, open the other link that rgviz printed.")
        return self.app.opened

    @property
    def _session(self) -> Session:
        """For edits of the map on show. Raises EditError where this browser may make none."""
        if self.looking.map is not None:
            raise EditError("This is the new run, to look at. To correct the map, accept it or go back to the map.")
        return self.must_edit()

    def _some(self, why_not: str) -> tuple[Item, ...]:
        if not self.selection:
            raise EditError(f"{why_not}.")
        return self.selection

    def show_node(self, name: str, shown: bool) -> None:
        """For this browser alone, also what all have in common."""
        message = viser._messages.SetSceneNodeVisibilityMessage(name, shown)
        self.client._websock_connection.queue_message(message)

    def _heard(self, message: FromBrowser) -> None:
        if isinstance(message, Pointer):
            self.hands.hear(message)
        elif isinstance(message, Answer):
            self.post(self.hands.answer, message)
        elif isinstance(message, Press):
            self.post(self.panels.press, message.do, message.arg)
        elif isinstance(message, Commit):
            self.post(self.panels.commit, message.field, message.value)
        else:
            self.post(self.panels.refresh)

    @property
    def _one(self) -> str | None:
        """The id of the only selected item."""
        return self.selection[0].id if len(self.selection) == 1 else None

    @property
    def _kind(self) -> Kind | None:
        """Of what is selected."""
        return self.selection[0].kind if self.selection else None

    def _under(self, event: Any, want: Kind | None = None) -> Item | None:
        ray = (np.asarray(event.ray_origin), np.asarray(event.ray_direction))
        return self.app.picker(self.map).at(self.client.camera, event.screen_pos, ray, want)

    def _draw_selection(self) -> None:
        with self.client.atomic():
            self._marks.draw(highlight.marks(self.map, self.selection, self.app.scene.artist))
            self._preview.clear()
            one = self.selection[0] if len(self.selection) == 1 and not self.read_only else None
            self._gizmo.hold(self.map.objects[one.id] if one is not None and one.kind == "object" else None)
        self.bridge.tell("selected", ids=[i.id for i in self.selection])

    def _drag(self, phase: str, position: tuple[float, ...], wxyz: tuple[float, ...]) -> None:
        """The hand moves: the box is shown there. The hand lets go: one edit is made."""
        if self._gizmo.box is None:
            return
        box = gizmo.dragged(self._gizmo.box, position, wxyz)
        if phase != "end":
            self._preview.draw(highlight.box(box))
            return
        try:
            self.do(gizmo.move(box))
        except RgError:
            self._gizmo.let_go()
            self._draw_selection()
            raise
        self._draw_selection()
