"""The tab of lists: everything in the map, kind by kind, narrowed by a search; a click goes there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING, Any

from rgcore.errors import EditError, QueryError
from rgcore.model.find import find
from rgcore.model.records import RGMap, replace
from rgviz import facts, markup, theme
from rgviz.panels.parts import press
from rgviz.panels.tab import Doer, Tab
from rgviz.picking import KINDS, Kind

if TYPE_CHECKING:
    from rgviz.view import View

PAGE = 40
"""rows shown at once: lists of a hundred thousand lines cost no more than short ones"""
MOST = 10_000
"""items that are selected at once; more are a slip of the hand"""
EXAMPLE = "class:TOMA accuracy>0.1 edited:yes name~lab"


class Found:
    """What a search finds among one kind; kept as long as what it depends on is the same object."""

    def __init__(self) -> None:
        self._kept: dict[Kind, tuple[tuple[Any, ...], list[str]]] = {}

    def ids(self, map_: RGMap, text: str, kind: Kind) -> list[str]:
        """In the order of the map. Raises QueryError with a sentence."""
        table = getattr(map_, KINDS[kind])
        depends = (text, table, map_.regions if "region" in text else None, map_.notes if "noted" in text else None)
        kept = self._kept.get(kind)
        if kept is None or kept[0][0] != text or any(a is not b for a, b in zip(kept[0][1:], depends[1:], strict=True)):
            kept = self._kept[kind] = (depends, _search(map_, text, kind) if text.strip() else list(table))
        return kept[1]


def _search(map_: RGMap, text: str, kind: Kind) -> list[str]:
    """Of one kind alone: regions and notes stay in the map, other items are judged by them."""
    others = [t for k, t in KINDS.items() if k not in (kind, "region", "note")]
    table = getattr(map_, KINDS[kind])
    return [id for id in find(replace(map_, **{t: {} for t in others}), text) if id in table]


class FindTab(Tab):
    title = "Find"

    def __init__(self, view: View) -> None:
        super().__init__(view)
        self.text, self.kind, self.page = "", "region", 0
        self.found = Found()

    @property
    def doers(self) -> Mapping[str, Doer]:
        return {"kind": self._choose, "page": self._turn, "all": self._select_all, "go": self._go}

    def build(self) -> None:
        self.field = self.parts.text("Search", lambda: self.text, self.search)
        self.parts.html(self._list)

    def search(self, text: str) -> None:
        """Raises QueryError, which the person reads in the list as well."""
        self.text, self.page = text, 0

    def _choose(self, kind: str) -> None:
        if kind not in KINDS:
            raise EditError("there is no such kind of thing")
        self.kind, self.page = kind, 0

    def _turn(self, page: str) -> None:
        if not page.isdigit():
            raise EditError("there is no such page")
        self.page = int(page)

    def _go(self, id: str) -> None:
        self.view.go_to([id])

    def _select_all(self, _: str) -> None:
        ids = self.found.ids(self.view.map, self.text, self.kind)  # type: ignore[arg-type]
        if len(ids) > MOST:
            raise EditError(f"{len(ids):,} at once are too many; narrow the search to {MOST:,}")
        self.view.go_to(ids, 0.05)

    def _list(self) -> str:
        map_, kind = self.view.map, self.kind
        try:
            found = {k: self.found.ids(map_, self.text, k) for k in KINDS}
        except QueryError as e:
            return markup.wrap(f'<div class="error">{escape(str(e))}</div>{_help()}')
        ids = found[kind]  # type: ignore[index]
        self.page = min(self.page, max(0, math.ceil(len(ids) / PAGE) - 1))
        chosen = {i.id for i in self.view.selection}
        part = ids[self.page * PAGE : (self.page + 1) * PAGE]
        rows = "".join(row(map_, kind, id, id in chosen) for id in part)  # type: ignore[arg-type]
        chips = "".join(
            press("kind", k, f"{k}s <b>{len(found[k]):,}</b>", "chip on" if k == kind else "chip") for k in KINDS
        )
        empty = "" if ids else '<p class="muted">nothing of this kind</p>'
        return markup.wrap(f'<div class="chips">{chips}</div>{rows}{empty}{_pages(self.page, len(ids))}{_help()}')


def row(map_: RGMap, kind: Kind, id: str, chosen: bool = False) -> str:
    """An item in a list: its name, what it is, the number that tells most of it."""
    item = getattr(map_, KINDS[kind])[id]
    mark, note = "", ""
    if kind == "region":
        mark = f'<span class="dot" style="background:{theme.css(theme.class_color(item.class_))}"></span>'
        name, note = item.name or id, f"{item.class_} · {facts.area(item):.0f} m²"
    elif kind == "gateway":
        name, note = item.name or id, f"{theme.CLASS_TITLES.get(item.class_, item.class_)} · {item.width:.2f} m"
    elif kind == "object":
        name, note = item.label or id, f"{id} · {item.size[0]:.1f} × {item.size[1]:.1f} m"
    elif kind == "line":
        name, note = id, f"{math.dist(item.start, item.end):.2f} m · {item.support} segments"
    else:
        name, note = item.text, item.item or ""
    seen = '<span class="tick" title="confirmed">✓</span>' if item.provenance.confirmed else ""
    face = f"{mark}<b>{escape(name)}</b>{seen}<small>{escape(note)}</small>"
    return press("go", id, face, "row on" if chosen else "row")


def _pages(page: int, count: int) -> str:
    if not count:
        return ""
    last = min((page + 1) * PAGE, count)
    back = press("page", str(page - 1), "‹", "cmd", "before") if page else ""
    on = press("page", str(page + 1), "›", "cmd", "after") if last < count else ""
    every = press("all", "", "select all found", "cmd")
    where = f'<span class="muted">{page * PAGE + 1}-{last} of {count:,}</span>'
    return f'<div class="cmds pages">{back}{where}{on}{every}</div>'


def _help() -> str:
    return (
        f'<p class="muted">A search: <code>{escape(EXAMPLE)}</code>; a bare word looks in names. Enter starts it.</p>'
    )
