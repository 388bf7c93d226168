"""The tab of the history: every edit by its name, who made it and when; back to any of them."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from rgcore.errors import EditError
from rgcore.model.edit import several
from rgcore.model.history import Done, History
from rgviz import actions, markup
from rgviz.panels.parts import press
from rgviz.panels.tab import Doer, Tab

MOST = 100
"""edits that are listed; older ones are reached by going back"""


class HistoryTab(Tab):
    title = "History"

    @property
    def doers(self) -> Mapping[str, Doer]:
        return {"back": self._back, "restore": self._restore}

    def build(self) -> None:
        self.parts.html(self._list)

    def _list(self) -> str:
        session = self.view.app.session
        if session is None:
            return markup.wrap('<p class="muted">The map is being made.</p>')
        return edits(session.project.history, not self.view.read_only)

    def _back(self, number: str) -> None:
        """To the map after the edit of that number in the history, counted from 1; 0: as the mapper made it."""
        if not number.isdigit():
            raise EditError("there is no such edit")
        self.view.back_to(int(number))

    def _restore(self, number: str) -> None:
        """Bring back what the edit of that number took away of the automatic map; later edits stay."""
        history = self.view.app.opened.project.history
        if not number.isdigit() or not 1 <= int(number) <= len(history.done):
            raise EditError("there is no such edit")
        done = history.done[int(number) - 1]
        self.view.do(actions.restore(lost(history, done)))


def lost(history: History, done: Done) -> tuple[str, ...]:
    """What an edit took away of the automatic map and is still not there; regions first, for gateways need them."""
    order = ("regions", "lines", "objects", "gateways")
    gone = [c for c in done.patch if c.after is None and c.kind in order]
    gone.sort(key=lambda c: order.index(c.kind))
    base, now = history.base, history.map
    return tuple(c.id for c in gone if c.id in getattr(base, c.kind) and c.id not in getattr(now, c.kind))


def edits(history: History, editable: bool) -> str:
    """What can be made again, then what stands, the newest first, then the map as it was made."""
    stands = len(history.done)
    undone = [(stands + 1 + n, d) for n, d in enumerate(reversed(history.undone))]
    done = [(n + 1, d) for n, d in enumerate(history.done)]
    rows = "".join(_row(n, d, "undone", "make it again, and all before", editable) for n, d in reversed(undone[:MOST]))
    for n, d in reversed(done[-MOST:]):
        rows += _row(n, d, "now" if n == stands else "", "undo all that came after", editable and n != stands)
        away = lost(history, d) if editable and n != stands else ()  # the last one is undone as well
        if away:
            what = f"bring back {several(away, 'items')}"
            rows += f'<div class="cmds">{press("restore", str(n), escape(what), "cmd", "what came after stays")}</div>'
    if len(done) > MOST:
        rows += f'<p class="muted">and {len(done) - MOST:,} older ones</p>'
    start = "The map as the mapper made it"
    if editable and stands:
        rows += press("back", "0", f"<b>{start}</b><small>undo everything; it can be made again</small>", "row")
    else:
        rows += f'<div class="row {"" if stands else "now"}"><b>{start}</b></div>'
    return markup.wrap(rows)


def _row(number: int, done: Done, kind: str, hint: str, active: bool) -> str:
    who = f"{done.entry.by or 'somebody'} · {markup.when(done.entry.at)}"
    face = f"<b>{escape(done.title)}</b><small>{escape(who)}</small>"
    if not active:
        return f'<div class="row {kind}">{face}</div>'
    return press("back", str(number), face, f"row {kind}", hint)
