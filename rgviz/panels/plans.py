"""Floor plans in the tab of the map: bring one, see which there are, align, take away."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping
from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any

from rgcore.errors import EditError, RgError
from rgcore.model.backdrops import laid, title
from rgcore.model.edits import AlignBackdrop, DeleteBackdrop
from rgcore.model.records import Backdrop, RGMap
from rgcore.scans.backdrop import LARGEST
from rgviz import markup
from rgviz.panels.parts import Parts, number_of, press
from rgviz.panels.tab import Doer
from rgviz.tools.aligning import AlignTool

if TYPE_CHECKING:
    from rgviz.view import View

FORMS = ".png,.jpg,.jpeg,.dxf,image/png,image/jpeg"
FIELDS = ("Plan x (m)", "Plan y (m)", "Plan turn (°)", "Plan length (m)")
"""of the middle of a plan, and of its longer side"""


class Plans:
    """A folder of the tab. ``parts`` hold what changes with the plans there are."""

    def __init__(self, view: View) -> None:
        self.view, self.parts = view, Parts(view)
        self._folder: Any = None
        self._built: tuple[object, ...] = ()
        self._chosen: str | None = None

    @property
    def doers(self) -> Mapping[str, Doer]:
        return {
            "plan": self._choose,
            "plan-align": self._align,
            "plan-away": self._take_away,
            "plan-too-large": _refuse,
        }

    def build(self, folder: Any) -> None:
        """``folder`` is gone when the tab is closed, and what is in it."""
        self._folder, self._built = folder, ()
        if not self.view.read_only:
            with folder:
                button = self.view.client.gui.add_upload_button("Lay a plan under the map", mime_type=FORMS)

            @button.on_upload
            async def _(event: Any) -> None:
                file = event.target.value
                threading.Thread(target=self._read, args=(file.name, file.content), daemon=True).start()

        self.refresh()

    def refresh(self) -> None:
        plans, chosen = self.view.map.backdrops, self._known()
        wanted = (*plans, chosen, self.view.read_only)
        if self._folder is None:
            return
        if wanted != self._built:
            self._built = wanted
            self.parts.clear()
            with self._folder:
                self._fill(chosen)
        self.parts.refresh()

    def close(self) -> None:
        self.parts.clear()
        self._folder = None

    # ---- parts ------------------------------------------------------------------------------------

    def _fill(self, chosen: str | None) -> None:
        self.parts.html(lambda: rows(self.view.map, self._known(), self.view.read_only, self.view.app.backdrops.faults))
        if chosen is None or self.view.read_only:
            return
        for n, label in enumerate(FIELDS):
            field = self.parts.number(label, self._number(n), partial(self._set, n))
            self.parts.follow(partial(self._show, field, n))

    def _known(self) -> str | None:
        """The plan whose place is shown."""
        plans = self.view.map.backdrops
        if self._chosen not in plans:
            self._chosen = next(reversed(plans), None) if plans else None
        return self._chosen

    def _plan(self, id: str) -> Backdrop:
        if id not in self.view.map.backdrops:
            raise EditError("that plan is not there any more")
        return self.view.map.backdrops[id]

    def _number(self, n: int) -> float:
        plan = self.view.map.backdrops.get(self._chosen or "")
        return 0.0 if plan is None else round((*plan.center, math.degrees(plan.yaw), plan.length)[n], 3)

    def _show(self, field: Any, n: int) -> None:
        field.value = self._number(n)

    def _set(self, n: int, text: str) -> None:
        """A field is finished; the others stay as exact as they are."""
        plan = self._plan(self._chosen or "")
        values = [*plan.center, plan.yaw, plan.length]
        value = number_of(text, FIELDS[n])
        values[n] = math.remainder(math.radians(value), math.tau) if n == 2 else value
        x, y, yaw, length = values
        self.view.do(AlignBackdrop(backdrop=plan.id, center=(x, y), yaw=yaw, length=length))

    def _choose(self, id: str) -> None:
        self._chosen = self._plan(id).id

    def _align(self, id: str) -> None:
        self.view.take(AlignTool(self._plan(id).id))

    def _take_away(self, id: str) -> None:
        self.view.do(DeleteBackdrop(backdrop=self._plan(id).id))

    def _read(self, name: str, data: bytes) -> None:
        """On a thread of its own: a drawing takes seconds."""
        try:
            edit = laid(self.view.map, data, name)
        except RgError as e:
            self.view.post(self.view.refuse, str(e))
        else:
            self.view.post(self.view.lay, edit, data)


def _refuse(name: str) -> None:
    """The page did not send it."""
    raise EditError(f"{title(name)}: is larger than {LARGEST >> 20} MB; save it smaller")


def rows(map_: RGMap, chosen: str | None, read_only: bool, faults: Mapping[str, str]) -> str:
    """A row a plan, the chosen one with what can be done to it."""
    out = ""
    for plan in map_.backdrops.values():
        width, height = (plan.scale * s for s in plan.size)
        face = f"<b>{escape(plan.name)}</b><small>{width:.2f} × {height:.2f} m</small>"
        out += press("plan", plan.id, face, "row on" if plan.id == chosen else "row")
        if plan.sha256 in faults:
            out += f'<p class="error">{escape(faults[plan.sha256])}</p>'
        if plan.id == chosen and not read_only:
            away = press("plan-away", plan.id, "Take away", "cmd")
            align = press(
                "plan-align", plan.id, "Align by points", "cmd", "a point of the plan, where it belongs; twice"
            )
            out += f'<div class="cmds">{align}{away}</div>'
    return markup.wrap(out or '<p class="muted">A png, jpg or DXF of the building, to compare the map with.</p>')
