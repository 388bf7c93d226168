"""The tab of the review: what is least sure, what looks wrong with its remedy, what people noted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from rgcore.errors import EditError
from rgcore.model.doubt import Doubt
from rgcore.model.edits import HeedFinding, IgnoreFinding
from rgcore.model.lint import Finding
from rgcore.model.records import RGMap
from rgviz import markup, theme
from rgviz.panels.parts import command_button, command_named, press
from rgviz.panels.tab import Doer, Tab
from rgviz.picking import KINDS

VERDICTS = {"next": "Next", "confirm": "Right", "reject": "Not there"}
MOST = 40
"""doubts, findings and notes that are listed; the keys lead through all of them"""


class ReviewTab(Tab):
    title = "Review"

    @property
    def doers(self) -> Mapping[str, Doer]:
        return {"see": self._see, "fix": self._fix, "ignore": self._ignore, "heed": self._heed}

    def build(self) -> None:
        gui = self.parts.gui
        self.parts.html(lambda: progress(self.view.map))
        with self.parts.add(gui.add_folder("To check")):
            self.parts.html(lambda: work(self.view.map, self.view.app.doubts(self.view.map), self._chosen))
        with self.parts.add(gui.add_folder("Looks wrong")):
            self.parts.html(
                lambda: findings(self.view.map, self.view.app.findings(self.view.map), not self.view.read_only)
            )
        with self.parts.add(gui.add_folder("Notes")):
            self.parts.html(lambda: notes(self.view.map))

    @property
    def _chosen(self) -> frozenset[str]:
        return frozenset(i.id for i in self.view.selection)

    def _see(self, id: str) -> None:
        self.view.go_to([id])

    def _fix(self, id: str) -> None:
        remedy = self._finding(id).remedy
        if remedy is None:
            raise EditError("there is no remedy that is surely right; mend it by hand")
        self.view.do(remedy)

    def _ignore(self, id: str) -> None:
        finding = self._finding(id)
        self.view.do(IgnoreFinding(code=finding.code, items=finding.items))

    def _heed(self, id: str) -> None:
        if id not in self.view.map.ignored:
            raise EditError("that is not ignored any more")
        ignored = self.view.map.ignored[id]
        self.view.do(HeedFinding(code=ignored.code, items=ignored.items))

    def _finding(self, id: str) -> Finding:
        found = next((f for f in self.view.app.findings(self.view.map) if f.id == id), None)
        if found is None:
            raise EditError("that is settled already")
        return found


def progress(map_: RGMap) -> str:
    """How much of the map somebody has confirmed."""
    items = [i for t in (map_.regions, map_.gateways, map_.objects) for i in t.values()]
    done = sum(i.provenance.confirmed for i in items)
    share = 100 * done / len(items) if items else 0.0
    keys = "".join(command_button(command_named(n), title) for n, title in VERDICTS.items())
    return markup.wrap(
        f'<div class="rg-h">{done} of {len(items)}<small>regions, gateways, objects confirmed</small></div>'
        f'<div class="bar"><i style="width:{share:.1f}%;background:{theme.css(theme.BRAND)}"></i></div>'
        f'<div class="cmds">{keys}</div>'
    )


def work(map_: RGMap, doubts: Sequence[Doubt], chosen: frozenset[str] = frozenset()) -> str:
    """The most doubtful items, with why."""
    rows = ""
    for d in doubts[:MOST]:
        bar = f'<span class="doubt"><i style="height:{100 * d.score:.0f}%"></i></span>'
        face = f"{bar}<b>{escape(called(map_, d.item))}</b><small>{escape('; '.join(d.reasons))}</small>"
        rows += press("see", d.item, face, "row on" if d.item in chosen else "row", f"doubt {d.score:.2f}")
    more = f'<p class="muted">and {len(doubts) - MOST:,} more</p>' if len(doubts) > MOST else ""
    return markup.wrap((rows + more) or '<p class="muted">Nothing left to check.</p>')


def findings(map_: RGMap, found: Sequence[Finding], editable: bool) -> str:
    """What looks wrong: a click goes there; its remedy and "ignore" beside it. What is ignored can be called back."""
    rows = ""
    for f in found[:MOST]:
        fix = press("fix", f.id, "fix", "cmd", remedy_of(map_, f)) if f.remedy is not None and editable else ""
        let = press("ignore", f.id, "ignore", "cmd", "it is all right so; kept in the map") if editable else ""
        rows += _finding(press("see", f.items[0], escape(f.text), "row"), fix + let)
    more = f'<p class="muted">and {len(found) - MOST:,} more</p>' if len(found) > MOST else ""
    ignored = ""
    for i in list(map_.ignored.values())[:MOST]:
        back = press("heed", i.id, "tell again", "cmd") if editable else ""
        ignored += _finding(f'<span class="muted">{escape(i.code)}: {escape(", ".join(i.items))}</span>', back)
    if ignored:
        ignored = f"<details><summary>{len(map_.ignored)} ignored</summary>{ignored}</details>"
    return markup.wrap((rows + more or '<p class="muted">Nothing looks wrong.</p>') + ignored)


def _finding(face: str, buttons: str) -> str:
    return f'<div class="finding">{face}<div class="cmds">{buttons}</div></div>'


def notes(map_: RGMap) -> str:
    """What people wrote down."""
    rows = ""
    for n in list(map_.notes.values())[:MOST]:
        about = f"on {called(map_, n.item)}" if n.item else "at a place"
        by = f" · {markup.when(n.provenance.at)}" if n.provenance.at else ""
        rows += press("see", n.id, f"<b>{escape(n.text)}</b><small>{escape(about + by)}</small>", "row")
    return markup.wrap(rows or f'<p class="muted">None yet. {command_named("note").keys[0]} writes one.</p>')


def called(map_: RGMap, id: str) -> str:
    """An item by its name and id."""
    for kind, table in KINDS.items():
        item = getattr(map_, table).get(id)
        if item is not None:
            name = getattr(item, "name", "") or getattr(item, "label", "")
            return f"{name} ({id})" if name and name != id else f"{kind} {id}"
    return id


def remedy_of(map_: RGMap, finding: Finding) -> str:
    """What the remedy would do, in words."""
    return "" if finding.remedy is None else finding.remedy.title(map_)
