"""The inspector: all that is known of what is selected, its fields, and what can be done with it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rgcore.errors import EditError
from rgcore.model.records import GATEWAY_CLASSES, REGION_CLASSES, MapObject
from rgviz import facts, markup, overview, status
from rgviz.commands import fitting
from rgviz.panels.parts import Parts, command_button, number_of
from rgviz.picking import Item
from rgviz.selecting import Items

if TYPE_CHECKING:
    from rgviz.view import View

OTHER = "another class ..."
ELSEWHERE = ("zoom", "rename", "class-")
"""Commands (or how their names begin) that need no button beside what is selected: a field or a row does the same."""


class Inspector:
    """Built anew when something else is selected, refreshed when the map has changed."""

    def __init__(self, view: View) -> None:
        self.view, self.gui = view, view.client.gui
        self.new_height = 1.0
        self.folder = self.gui.add_folder("Inspector")
        self.parts = Parts(view)
        self._shown: tuple[tuple[Item, ...], bool] | None = None
        self._name: Any = None

    def refresh(self) -> None:
        """Show the selection and the map as they are now."""
        if self._shown == (self.view.selection, self.view.app.session is not None):
            self.parts.refresh()
        else:
            self.show()

    def show(self) -> None:
        """Build it for what is selected now."""
        self.parts.clear()
        self._name = None
        items = self.view.selection
        self._shown = (items, self.view.app.session is not None)
        with self.folder:
            if self.view.app.session is None:
                self.parts.html(lambda: status.waiting(self.view.app.title, self.view.app.pace))
            elif not items:
                self.parts.html(self._overview)
            elif len(items) == 1:
                self._show_one(items[0])
            else:
                self.parts.html(lambda: facts.many(self.view.map, items))
                self._show_buttons()

    def focus_name(self) -> None:
        if self._name is not None:
            self.view.bridge.tell("focus", field=self._name._impl.uuid)

    def _overview(self) -> str:
        return overview.overview(self.view.map, self.view.app.title, self.view.figures)

    def _show_one(self, item: Item) -> None:
        app = self.view.app
        self.parts.html(lambda: facts.item(self.view.map, item, self.view.figures, app.edit_titles(self.view.map)))
        if not self.view.read_only:
            if item.kind in ("region", "gateway"):
                self._add_class(item)
            if item.kind in ("region", "gateway", "object"):
                label = "Label" if item.kind == "object" else "Name"
                self._name = self.parts.text(label, lambda: self._name_of(item), self.view.rename)
            if item.kind == "object":
                self._add_size(item)
        self._show_buttons()
        if item.kind == "region":
            self.parts.html(
                lambda: facts.region_plots(self.view.map, self.view.map.regions[item.id], self.view.figures)
            )

    def _show_buttons(self) -> None:
        """What can be done with the selection; a box over lines needs its height first."""
        if self.view.read_only:
            return
        if self.view.selection[0].kind == "line":
            self.parts.number("Height [m]", self.new_height, self._set_height)
        self.parts.html(lambda: buttons(self.view.selection))

    def _set_height(self, text: str) -> None:
        value = number_of(text, "Height")
        if value <= 0:
            raise EditError("the height of an object must be above 0 m")
        self.new_height = value

    def _name_of(self, item: Item) -> str:
        m = self.view.map
        if item.kind == "object":
            return m.objects[item.id].label
        return m.regions[item.id].name if item.kind == "region" else m.gateways[item.id].name

    def _class_of(self, item: Item) -> str:
        m = self.view.map
        return m.regions[item.id].class_ if item.kind == "region" else m.gateways[item.id].class_

    def _add_class(self, item: Item) -> None:
        """The known classes to choose from, and a field for one that nobody has used yet."""

        def options() -> tuple[str, ...]:
            m = self.view.map
            known = REGION_CLASSES if item.kind == "region" else GATEWAY_CLASSES
            items: Any = m.regions if item.kind == "region" else m.gateways
            return (*known, *sorted({i.class_ for i in items.values()} - set(known)), OTHER)

        choice = self.parts.add(self.gui.add_dropdown("Class", options(), initial_value=self._class_of(item)))
        other = self.parts.text("New class", lambda: "", self.view.relabel, visible=False)

        @choice.on_update
        async def _(event: Any) -> None:
            if event.client is not None:
                self.view.post(self._choose, choice, other, options, choice.value)

        def refresh() -> None:
            choice.options = options()
            choice.value = self._class_of(item)
            other.visible = False

        self.parts.follow(refresh)

    def _choose(self, choice: Any, other: Any, options: Callable[[], tuple[str, ...]], value: str) -> None:
        if value == OTHER:
            other.visible = True
            self.view.bridge.tell("focus", field=other._impl.uuid)
        elif value not in options():
            raise EditError("that class is not on offer; choose 'another class ...' to add one")
        else:
            self.view.relabel(value)

    def _add_size(self, item: Item) -> None:
        def number(label: str, field: str, read: Callable[[MapObject], float], unit: str) -> None:
            def value() -> float:
                return round(read(self.view.map.objects[item.id]), 3)

            handle = self.parts.number(
                f"{label} [{unit}]", value(), lambda text: self.view.resize(field, number_of(text, label))
            )
            self.parts.follow(lambda: setattr(handle, "value", value()))

        number("Length", "length", lambda o: o.size[0], "m")
        number("Width", "width", lambda o: o.size[1], "m")
        number("Height", "height", lambda o: o.size[2], "m")
        number("Turned", "turn", lambda o: math.degrees(o.yaw), "°")


def buttons(items: Items) -> str:
    """What can be done with a selection and has no field or row of its own."""
    faces = [command_button(c) for c in fitting(items) if not c.name.startswith(ELSEWHERE)]
    return markup.wrap(f'<div class="cmds">{"".join(faces)}</div>')
