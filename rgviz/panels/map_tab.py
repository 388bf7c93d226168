"""The tab of the view: where to look from, which layers are shown and how strong, what the colours mean, downloads."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

from rgcore.errors import EditError, RgError
from rgcore.exports.formats import FORMATS
from rgviz import markup, overview
from rgviz.layers import LAYERS
from rgviz.panels.parts import command_button, command_named, press
from rgviz.panels.plans import Plans
from rgviz.panels.tab import Doer, Tab

if TYPE_CHECKING:
    from rgviz.view import View

ENDINGS = {k: f.title for k, f in FORMATS.items()}
VIEWS = (("fit", "Fit"), ("2d", "2D"), ("3d", "3D"))


class MapTab(Tab):
    title = "Map"

    def __init__(self, view: View) -> None:
        super().__init__(view)
        self.shown = {layer.name: layer.shown for layer in LAYERS}
        self.strength = dict.fromkeys(self.shown, 1.0)
        """in (0, 1], what is seen of a layer"""
        self.plans = Plans(view)
        self._last: str | None = None
        self._lost: tuple[str, ...] | None = None

    @property
    def doers(self) -> Mapping[str, Doer]:
        own = {"look": self._look, "layer": self._toggle, "strength": self._fade, "download": self._download}
        return {**own, **self.plans.doers}

    def build(self) -> None:
        gui = self.parts.gui
        faces = "".join(press("look", name, title, "cmd") for name, title in VIEWS)
        self.parts.html(
            lambda: markup.wrap(f'<div class="cmds">{faces}{command_button(command_named("dark"), "Dark")}</div>')
        )
        with self.parts.add(gui.add_folder("Layers")):
            self.parts.html(lambda: layer_rows(self.shown, self.strength))
        if self.view.app.session is not None:
            self.plans.build(self.parts.add(gui.add_folder("Floor plan")))
        with self.parts.add(gui.add_folder("Legend")):
            self.parts.html(lambda: self.view.app.legend(self.view.map))
        if self.view.app.session is not None:
            with self.parts.add(gui.add_folder("Download")):
                self.parts.html(lambda: overview.downloads(self.view.app.title, ENDINGS, self._last, self._lost))

    def refresh(self) -> None:
        super().refresh()
        self.plans.refresh()

    def commit(self, field: str, value: str) -> bool:
        return self.plans.parts.commit(field, value) or super().commit(field, value)

    def close(self) -> None:
        self.plans.close()
        super().close()

    def set_layer(self, name: str, shown: bool) -> None:
        if self.shown[name] != shown:
            self.shown[name] = shown
            self.view.show_layer(name, shown)

    def _look(self, how: str) -> None:
        if how == "fit":
            self.view.fit()
        else:
            self.view.turn(how == "2d")

    def _toggle(self, arg: str) -> None:
        """``"/lines 1"``: shown from now on."""
        name, _, on = arg.partition(" ")
        self._known(name)
        self.set_layer(name, on == "1")

    def _fade(self, arg: str) -> None:
        """``"/lines 40"``: percent. The page has faded it already; this keeps what stands in the panel true."""
        name, _, percent = arg.partition(" ")
        self._known(name)
        try:
            self.strength[name] = min(max(int(percent), 5), 100) / 100
        except ValueError:
            raise EditError("a layer is shown at 5 to 100 percent") from None

    def _download(self, ending: str) -> None:
        """The browser fetches the file by itself; what that could not carry is told beside it."""
        if ending not in ENDINGS:
            raise EditError("there is no such format")
        self._last, self._lost = ending, None
        threading.Thread(target=self._write, args=(ending,), daemon=True).start()  # a large map takes seconds

    def _write(self, ending: str) -> None:
        try:
            self.view.post(self._written, ending, self.view.app.exported(ending).lost)
        except RgError as e:
            self.view.post(self._written, ending, (f"anything: {e}",))

    def _written(self, ending: str, lost: tuple[str, ...]) -> None:
        if self._last == ending:
            self._lost = lost
            self.refresh()
            self.view.bridge.tell("reveal", what=".lost")

    def _known(self, name: str) -> None:
        if name not in self.shown:
            raise EditError("there is no such layer")


def layer_rows(shown: Mapping[str, bool], strength: Mapping[str, float]) -> str:
    """A switch and a slider for each layer."""
    rows = ""
    for layer in LAYERS:
        checked = " checked" if shown[layer.name] else ""
        title = escape(layer.title)
        hint = f' title="{escape(layer.hint)}"' if layer.hint else ""
        percent = round(100 * strength[layer.name])
        rows += (
            f'<div class="layer"><label{hint}><input type="checkbox" data-do="layer" data-arg="{layer.name}"{checked}>'
            f'{title}</label><input type="range" min="5" max="100" step="5" value="{percent}" data-do="strength" '
            f'data-arg="{layer.name}" aria-label="{title} opacity" title="opacity"></div>'
        )
    return markup.wrap(rows)
