"""The panels of one browser: commands and the inspector on the right, layers, legend and downloads on the left."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rgcore.errors import EditError
from rgcore.exports.formats import FORMATS
from rgcore.model.records import GATEWAY_CLASSES, REGION_CLASSES, MapObject
from rgviz import facts, status
from rgviz.commands import BY_NAME, spoken
from rgviz.layers import LAYERS
from rgviz.picking import Item

if TYPE_CHECKING:
    from rgviz.view import View

OTHER = "another class ..."
Committed = Callable[[str], None]
"""Called with the finished text of a field."""


class Panels:
    """Made anew for each page that is opened; what they show follows the view."""

    def __init__(self, view: View) -> None:
        self.view, self.gui = view, view.client.gui
        self.new_height = 1.0
        self._shown: tuple[Item, ...] | None = None
        self._open = False
        self._parts: list[Any] = []
        self._fields: dict[str, tuple[Any, Committed]] = {}
        self._refreshers: list[Callable[[], None]] = []
        self._name: Any = None
        self._layers: dict[str, Any] = {}
        self._add_left()
        self._status = self.gui.add_html("")
        self._undo = self._command("undo")
        self._redo = self._command("redo")
        self._inspector = self.gui.add_folder("Inspector")
        self.refresh()

    # ---- what the view calls ----------------------------------------------------------------------

    def refresh(self) -> None:
        """Show the map and the selection as they are now."""
        app = self.view.app
        for button, name, title in ((self._undo, "undo", app.undo_title), (self._redo, "redo", app.redo_title)):
            key = spoken(BY_NAME[name].keys[0])
            button.label = f"{BY_NAME[name].title}: {title}" if title else f"{BY_NAME[name].title} ({key})"
            button.disabled = title is None or app.read_only
            button.visible = app.session is not None
        self._status.content = app.status_html()
        self._legend.content = app.legend(self.view.map)
        self._downloads.visible = app.session is not None
        if (self._shown, self._open) == (self.view.selection, app.session is not None):
            for refresh in self._refreshers:
                refresh()
        else:
            self.show_selection()

    def show_selection(self) -> None:
        """Build the inspector for what is selected now."""
        for part in self._parts:
            part.remove()
        self._parts, self._fields, self._refreshers, self._name = [], {}, [], None
        self._shown, self._open = self.view.selection, self.view.app.session is not None
        with self._inspector:
            if self.view.app.session is None:
                self._html(lambda: status.waiting(self.view.app.title, self.view.app.pace))
            elif not self._shown:
                self._html(lambda: facts.overview(self.view.map, self.view.app.title))
                self._add(self.gui.add_folder("Keys", expand_by_default=False))
                with self._parts[-1]:
                    self.gui.add_html(facts.keys())
            elif len(self._shown) == 1:
                self._show_one(self._shown[0])
            else:
                self._html(lambda: facts.many(self.view.map, self._shown or ()))
                if self._shown[0].kind == "line":
                    self._show_seed()

    def commit(self, field: str, value: str) -> None:
        """A field of the inspector is finished."""
        if field in self._fields:
            self._fields[field][1](value)
            self.refresh()

    def focus_name(self) -> None:
        if self._name is not None:
            self.view.bridge.tell("focus", field=self._name._impl.uuid)

    def set_layer(self, name: str, shown: bool) -> None:
        if self._layers[name].value != shown:
            self._layers[name].value = shown
            self.view.show_layer(name, shown)

    # ---- left -------------------------------------------------------------------------------------

    def _add_left(self) -> None:
        panel = self.gui.add_panel()
        with panel.add_tab("Map"):
            with self.gui.add_folder("View"):
                buttons = self.gui.add_button_group("", ("Fit", "2D", "3D"))

                @buttons.on_click
                async def _(event: Any) -> None:
                    asked = event.target.value
                    if asked == "Fit":
                        self.view.post(self.view.fit)
                    else:
                        self.view.post(self.view.turn, asked == "2D")

            with self.gui.add_folder("Layers"):
                for layer in LAYERS:
                    self._layers[layer.name] = self._toggle(layer.name, layer.title, layer.shown, layer.hint)
            with self.gui.add_folder("Legend"):
                self._legend = self.gui.add_html("")
            self._downloads = self.gui.add_folder("Download")
            with self._downloads:
                self.gui.add_html(facts.downloads(self.view.app.title, {k: f.title for k, f in FORMATS.items()}))
        panel.dock_left()
        panel.set_width(250)

    def _toggle(self, name: str, title: str, shown: bool, hint: str) -> Any:
        box = self.gui.add_checkbox(title, shown, hint=hint or None)

        @box.on_update
        async def _(event: Any) -> None:
            if event.client is not None:
                self.view.post(self.view.show_layer, name, bool(box.value))

        return box

    # ---- inspector --------------------------------------------------------------------------------

    def _show_one(self, item: Item) -> None:
        self._html(lambda: facts.item(self.view.map, item))
        frozen = self.view.app.read_only
        if item.kind in ("region", "gateway") and not frozen:
            self._add_class(item)
        if item.kind != "line" and not frozen:
            label = "Label" if item.kind == "object" else "Name"
            self._name = self._text(label, lambda: self._name_of(item), self.view.rename)
        if item.kind == "object" and not frozen:
            self._add_size(item)
        if item.kind == "line":
            self._show_seed()
        if item.kind in ("gateway", "object") and not frozen:
            self._add(self._command("delete", f"Delete this {item.kind}"))

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

        choice = self._add(self.gui.add_dropdown("Class", options(), initial_value=self._class_of(item)))
        other = self._text("New class", lambda: "", self.view.relabel, visible=False)

        @choice.on_update
        async def _(event: Any) -> None:
            if event.client is not None:
                self.view.post(self._choose, choice, other, options, choice.value)

        def refresh() -> None:
            choice.options = options()
            choice.value = self._class_of(item)
            other.visible = False

        self._refreshers.append(refresh)

    def _choose(self, choice: Any, other: Any, options: Callable[[], tuple[str, ...]], value: str) -> None:
        if value == OTHER:
            other.visible = True
            self.view.bridge.tell("focus", field=other._impl.uuid)
        elif value not in options():
            raise EditError("that class is not on offer; choose 'another class ...' to add one")
        else:
            self.view.relabel(value)

    def _add_size(self, item: Item) -> None:
        def number(label: str, field: str, read: Callable[[MapObject], float], unit: str, step: float) -> None:
            def committed(text: str) -> None:
                self.view.resize(field, _number(text, label))

            value = round(read(self.view.map.objects[item.id]), 3)
            handle = self._add(self.gui.add_number(f"{label} [{unit}]", value, step=step))
            self._fields[handle._impl.uuid] = (handle, committed)
            self._refreshers.append(
                lambda: setattr(handle, "value", round(read(self.view.map.objects[item.id]), 3)),
            )

        number("Length", "length", lambda o: o.size[0], "m", 0.001)
        number("Width", "width", lambda o: o.size[1], "m", 0.001)
        number("Height", "height", lambda o: o.size[2], "m", 0.001)
        number("Turned", "turn", lambda o: math.degrees(o.yaw), "°", 0.001)

    def _show_seed(self) -> None:
        if self.view.app.read_only:
            return
        height = self._add(self.gui.add_number("Height [m]", self.new_height, step=0.001))

        def committed(text: str) -> None:
            value = _number(text, "Height")
            if value <= 0:
                raise EditError("the height of an object must be above 0 m")
            self.new_height = value

        self._fields[height._impl.uuid] = (height, committed)
        self._add(
            self._command("box", "Make an object of it" if len(self._shown or ()) == 1 else "Make an object of them")
        )

    # ---- parts ------------------------------------------------------------------------------------

    def _html(self, content: Callable[[], str]) -> None:
        handle = self._add(self.gui.add_html(content()))
        self._refreshers.append(lambda: setattr(handle, "content", content()))

    def _text(self, label: str, read: Callable[[], str], committed: Committed, visible: bool = True) -> Any:
        handle = self._add(self.gui.add_text(label, read(), visible=visible))
        self._fields[handle._impl.uuid] = (handle, committed)
        self._refreshers.append(lambda: setattr(handle, "value", read()))
        return handle

    def _command(self, name: str, title: str | None = None) -> Any:
        command = BY_NAME[name]
        key = f" ({spoken(command.keys[0])})" if command.keys else ""
        button = self.gui.add_button((title or command.title) + key)

        @button.on_click
        async def _(event: Any) -> None:
            self.view.post(command.run, self.view)

        return button

    def _add(self, part: Any) -> Any:
        self._parts.append(part)
        return part


def _number(text: str, label: str) -> float:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        raise EditError(f"{label} must be a number, not '{text[:20]}'") from None
