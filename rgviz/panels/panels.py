"""All panels of one browser; made anew for each page that is opened, they show what the view shows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rgcore.errors import EditError
from rgviz import markup, overview
from rgviz.commands import BY_NAME, spoken
from rgviz.panels.find_tab import FindTab
from rgviz.panels.history_tab import HistoryTab
from rgviz.panels.inspector import Inspector
from rgviz.panels.map_tab import MapTab
from rgviz.panels.parts import command_button, command_named, press, set_html
from rgviz.panels.review_tab import ReviewTab
from rgviz.panels.runs_tab import RunsTab
from rgviz.panels.tab import Tab

if TYPE_CHECKING:
    from rgviz.view import View

TOOLS = {
    "select": "Select",
    "split": "Split",
    "region": "Region",
    "gateway": "Gateway",
    "wall": "Wall",
    "cut": "Cut line",
    "rectangle": "Box",
    "note": "Note",
    "measure": "Measure",
}
"""Commands that take something into the hand, and what they are called where there is little room."""


NARROW = 1100
"""px: a picture no wider keeps its room; the left panel waits at the edge until it is asked for"""


class Panels:
    """``press`` and ``commit`` are what a person does in them; the rest is for the view."""

    def __init__(self, view: View) -> None:
        self.view, self.gui = view, view.client.gui
        panel = self.gui.add_panel()
        self._left = panel.add_tab("Map")
        panel.dock_left()
        panel.set_width(280)
        self._panel = panel
        if view.client.camera.image_width < NARROW:
            panel.minimize()
        self.map_tab, self.find_tab = MapTab(view), FindTab(view)
        self.tabs: dict[str, Tab] = {
            t.title: t for t in (self.map_tab, self.find_tab, ReviewTab(view), HistoryTab(view), RunsTab(view))
        }
        self.open = self.map_tab.title
        with self._left:
            self._bar = self.gui.add_html("")
        self._status = self.gui.add_html("")
        self._undo, self._redo = self._step_button("undo"), self._step_button("redo")
        self._tools = self.gui.add_html("")
        self.inspector = Inspector(view)
        self._ready = view.app.session is not None
        self.show_tab(self.open)
        self.refresh()

    # ---- what the view calls ----------------------------------------------------------------------

    def refresh(self) -> None:
        """Show the map and the selection as they are now."""
        app = self.view.app
        for button, name, title in ((self._undo, "undo", app.undo_title), (self._redo, "redo", app.redo_title)):
            key = spoken(BY_NAME[name].keys[0])
            button.label = f"{BY_NAME[name].title}: {title}" if title else f"{BY_NAME[name].title} ({key})"
            button.disabled = title is None or self.view.read_only
            button.visible = app.session is not None and not self.view.guest
        set_html(self._status, app.status_html() + (overview.guest() if self.view.guest else ""))
        set_html(self._tools, "" if self.view.read_only else self._toolbar())
        if self._ready != (app.session is not None):
            self._ready = app.session is not None
            self.show_tab(self.open)
        self.tabs[self.open].refresh()
        self.inspector.refresh()

    def show_selection(self) -> None:
        """Build the inspector for what is selected now."""
        self.inspector.show()
        if self.open != self.map_tab.title:
            self.tabs[self.open].refresh()

    def show_tab(self, title: str) -> None:
        """Open a tab of the left panel. Raises EditError if there is none of that name."""
        if title not in self.tabs:
            raise EditError("there is no such tab")
        self.tabs[self.open].close()
        self.open = title
        faces = "".join(press("tab", t, t, "on" if t == title else "") for t in self.tabs)
        set_html(self._bar, f'<div class="tabs" role="tablist">{faces}</div>')
        with self._left:
            self.tabs[title].build()

    def open_tab(self, title: str) -> None:
        """Open a tab of the left panel, and the panel."""
        self._panel.expand()
        self.show_tab(title)

    def search(self) -> None:
        """Open the lists, ready to type."""
        self.open_tab(self.find_tab.title)
        self.view.bridge.tell("focus", field=self.find_tab.field._impl.uuid)

    def commit(self, field: str, value: str) -> None:
        """A field is finished."""
        if self.inspector.parts.commit(field, value) or self.tabs[self.open].commit(field, value):
            self.refresh()

    def press(self, do: str, arg: str) -> None:
        """A button of our own HTML was pressed. Raises EditError for what no panel has on it."""
        if do == "tab":
            self.show_tab(arg)
        elif do == "command":
            command_named(arg).run(self.view)
        else:
            doer = self.tabs[self.open].doers.get(do)
            if doer is None:
                raise EditError("that is not on this panel")
            doer(arg)
            self.tabs[self.open].refresh()

    def focus_name(self) -> None:
        self.inspector.focus_name()

    def set_layer(self, name: str, shown: bool) -> None:
        self.map_tab.set_layer(name, shown)
        if self.open == self.map_tab.title:
            self.map_tab.refresh()

    @property
    def new_height(self) -> float:
        """m, of the next object."""
        return self.inspector.new_height

    # ---- parts ------------------------------------------------------------------------------------

    def _toolbar(self) -> str:
        faces = "".join(command_button(BY_NAME[n], title) for n, title in TOOLS.items())
        return markup.wrap(
            f'<details class="tools" open><summary>Tools</summary><div class="cmds">{faces}</div></details>'
        )

    def _step_button(self, name: str) -> Any:
        button = self.gui.add_button(BY_NAME[name].title)

        @button.on_click
        async def _(event: Any) -> None:
            self.view.post(BY_NAME[name].run, self.view)

        return button
