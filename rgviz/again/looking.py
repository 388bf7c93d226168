"""What one browser looks at beside the map as it is: a new run, both, what is different, where outcomes lie."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from rgcore.errors import EditError
from rgcore.model.outcome import Outcome
from rgcore.model.records import RGMap
from rgviz import theme
from rgviz.again.comparing import Comparison, drawings, old_walls
from rgviz.again.kinds import KIND_COLORS
from rgviz.artist import Artist
from rgviz.layers import LAYERS
from rgviz.scene import Canvas

if TYPE_CHECKING:
    from rgviz.again.again import Proposal
    from rgviz.view import View

Which = Literal["now", "new", "both"]
Pin = dict[str, Any]
"""What ``static/seeing.js`` paints: place [m], text, colour, and whether it wants attention."""
ROOT = "/new"
"""node of a browser that holds the new map, layer by layer"""


class Looking:
    """``which``: the map on show; ``compared``: with which other one, ``comparison``: what is known of that so far."""

    def __init__(self, view: View) -> None:
        self.view = view
        self.which: Which = "now"
        self.compared: str | None = None
        self.comparison: Comparison | None = None
        scene = view.client.scene
        self._new = {layer.name: Canvas(scene, f"{ROOT}{layer.name}") for layer in LAYERS}
        self._over, self._changes = Canvas(scene, "/was"), Canvas(scene, "/changes")
        self._artist = Artist()
        self.pinned = False
        self._pins: list[Pin] = []

    @property
    def map(self) -> RGMap | None:
        """The new map while it is on show."""
        return None if self.which == "now" or self._proposal is None else self._proposal.plan.map

    def choose(self, which: str) -> None:
        """Which map is on show: the one as it is, the new one, or both. Raises EditError if there is no new one."""
        if which not in ("now", "new", "both"):
            raise EditError("there is no such map to look at")
        if which != "now" and self._proposal is None:
            raise EditError("There is no new run to look at.")
        if which != self.which:
            self.view.select(())
            self.which = which  # type: ignore[assignment]
            self.draw()
            self.view.map_changed()

    def turn(self) -> None:
        """The other map: the new one, or the one as it is."""
        self.choose("new" if self.which == "now" else "now")

    def compare(self, key: str | None) -> None:
        """Show the colours of what is different against this other map; none: take them away."""
        self.compared = key
        self._show_changes()

    def switch_changes(self) -> None:
        """The colours of what is different against the new run, or the one before, or none again."""
        titles = self.view.app.others.titles
        if self.compared is None and not titles:
            raise EditError("There is only this run; nothing to compare it with.")
        self.compare(None if self.compared is not None else next(iter(titles)))
        self.view.panels.refresh()

    def changed(self) -> None:
        """Another plan or comparison, or none any more."""
        self._show_changes()
        proposal = self._proposal
        if proposal is None and self.which != "now":
            self.choose("now")
        elif self.which != "now":
            self.draw()
        self.show_pins()

    def show_pins(self) -> None:
        """The places of the edits that the list of the runs shows, as long as it is open."""
        told = pins(self.view.app.again.in_need) if self.pinned else []
        if told != self._pins:
            self._pins = told
            self.view.bridge.tell("pins", pins=told)

    # ---- parts ------------------------------------------------------------------------------------

    @property
    def _proposal(self) -> Proposal | None:
        return self.view.app.again.proposal

    def _show_changes(self) -> None:
        if self.compared is not None and self.compared not in self.view.app.others.titles:
            self.compared = None
        found = None if self.compared is None else self.view.app.others.comparison(self.compared)
        if found is not self.comparison:
            self.comparison = found
            self._changes.draw({} if found is None else drawings(found))

    def show_layer(self, name: str, shown: bool) -> None:
        """A layer is switched on or off in this browser."""
        if self.which == "now":
            self.view.show_node(name, shown)
        else:
            self.draw()

    def draw(self) -> None:
        """The layers of the new map in this browser alone, or what all browsers see."""
        new = self._proposal if self.which != "now" else None
        shown, scene = self.view.panels.map_tab.shown, self.view.app.scene
        if new is not None:
            self._artist.points = new.points
            self._artist.trajectory = np.asarray(new.plan.run.trajectory.map_from_base)[:, :2]
            self._artist.colors = theme.region_colors(new.plan.map, scene.artist.colors)
        with self.view.client.atomic():
            for layer in LAYERS:
                here = new is not None and shown[layer.name]
                self._new[layer.name].draw(layer.draw(new.plan.map, self._artist) if new and here else {})
                self.view.show_node(layer.name, new is None and shown[layer.name])
            self._over.draw(old_walls(new.comparison) if new is not None and self.which == "both" else {})


def pins(outcomes: Sequence[Outcome]) -> list[Pin]:
    """A pin at the place of every edit, numbered as they come, in the colour of what becomes of it."""
    return [
        {
            "x": o.place[0],
            "y": o.place[1],
            "text": str(n),
            "color": theme.css(KIND_COLORS[o.kind]),
            "big": o.kind != "applied",
        }
        for n, o in enumerate(outcomes, 1)
        if o.place is not None
    ]
