"""Lists, review and history as the panels show them; and that nothing in them that came from outside is markup."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any

import pytest
from office_map import office_map
from test_facts import HOSTILE, Words

from rgcore.errors import EditError, QueryError
from rgcore.model.doubt import work_list
from rgcore.model.draft import note_on
from rgcore.model.edits import (
    ClassifyRegion,
    Confirm,
    DeleteGateway,
    DeleteRegion,
    IgnoreFinding,
    LabelObject,
    MoveGateway,
    RenameRegion,
)
from rgcore.model.history import Do, History, Undo, step
from rgcore.model.lint import lint
from rgcore.model.records import RGMap, replace
from rgviz.actions import restore
from rgviz.bridge import Press, read
from rgviz.commands import BY_NAME, COMMANDS
from rgviz.help import help_page, sheet
from rgviz.layers import LAYERS
from rgviz.panels.find_tab import PAGE, FindTab, Found, row
from rgviz.panels.history_tab import MOST, edits, lost
from rgviz.panels.inspector import buttons
from rgviz.panels.map_tab import MapTab, layer_rows
from rgviz.panels.panels import TOOLS
from rgviz.panels.review_tab import ReviewTab, findings, notes, progress, work
from rgviz.picking import Item

MAP = office_map(4, 1, 2)


def buttons_of(html: str) -> list[tuple[str, str]]:
    """What the buttons of some HTML do, and to what."""
    return re.findall(r'data-do="([^"]*)" data-arg="([^"]*)"', html)


class Spy:
    """A view that remembers what it was asked for."""

    def __init__(self, map_: RGMap = MAP) -> None:
        self.map, self.selection, self.read_only = map_, (), False
        self.client = SimpleNamespace(gui=None)
        self.calls: list[tuple[str, Any]] = []
        self.app = SimpleNamespace(findings=lint, doubts=lambda m: work_list(m, lint(m)))

    def __getattr__(self, name: str) -> Any:
        return lambda *args: self.calls.append((name, args[0] if args else None))


def test_lists_show_a_page_and_a_search_narrows_them() -> None:
    tab = FindTab(Spy())  # type: ignore[arg-type]
    html = tab._list()
    assert [a for d, a in buttons_of(html) if d == "go"] == list(MAP.regions)
    assert "<b>124</b>" in html
    tab._choose("line")
    assert len([1 for d, _ in buttons_of(tab._list()) if d == "go"]) == PAGE
    tab._turn("3")
    assert ("go", list(MAP.lines)[3 * PAGE]) in buttons_of(tab._list())
    tab._choose("region")
    tab.search("class:CC")
    assert [a for d, a in buttons_of(tab._list()) if d == "go"] == ["r5", "r8"]
    tab.search("clas:CC")
    assert "did you mean class" in Words(tab._list()).text
    tab.search("no-such-name")
    assert "nothing of this kind" in tab._list()


def test_all_that_was_found_is_selected_and_one_is_gone_to() -> None:
    view = Spy()
    tab = FindTab(view)  # type: ignore[arg-type]
    tab.search("class:CC")
    tab.doers["all"]("")
    tab.doers["go"]("r8")
    assert view.calls == [("go_to", ["r5", "r8"]), ("go_to", ["r8"])]
    for do, arg in (("kind", "wall"), ("page", "-1"), ("page", "x")):
        with pytest.raises(EditError):
            tab.doers[do](arg)


def test_a_search_is_made_again_only_for_a_kind_that_changed() -> None:
    found = Found()
    lines, regions = found.ids(MAP, "length>4", "line"), found.ids(MAP, "length>4 ", "region")
    relabelled = ClassifyRegion(region="r4", class_="CC").apply(MAP)
    assert found.ids(relabelled, "length>4", "line") is lines
    assert found.ids(relabelled, "length>4 ", "region") is not regions
    assert found.ids(MAP, "region:r4", "line") != found.ids(MAP, "region:r5", "line")
    renamed = RenameRegion(region="r4", name="lab").apply(MAP)
    assert not found.ids(MAP, "region~lab", "line")
    assert found.ids(renamed, "region~lab", "line")
    with pytest.raises(QueryError):
        found.ids(MAP, "length>long", "line")


def test_review_lists_doubts_and_findings_with_their_remedies() -> None:
    twins = RenameRegion(region="r5", name="office 3").apply(MAP)
    found = lint(twins)
    assert [f.code for f in found] == ["duplicate-name"]
    html = findings(twins, found, True)
    assert {d for d, _ in buttons_of(html)} == {"see", "fix", "ignore"}
    assert {d for d, _ in buttons_of(findings(twins, found, False))} == {"see"}
    view = Spy(twins)
    tab = ReviewTab(view)  # type: ignore[arg-type]
    tab.doers["fix"](found[0].id)
    assert view.calls[-1] == ("do", found[0].remedy)
    tab.doers["ignore"](found[0].id)
    ignore = view.calls[-1][1]
    assert ignore == IgnoreFinding(code="duplicate-name", items=found[0].items)
    settled = ignore.apply(twins)
    assert ("heed", found[0].id) in buttons_of(findings(settled, lint(settled), True))
    for do in ("fix", "ignore", "heed"):
        with pytest.raises(EditError, match=r"settled|not ignored"):
            tab.doers[do]("no-such:finding")

    doubts = work_list(MAP, [])
    listed = work(MAP, doubts)
    assert [a for d, a in buttons_of(listed) if d == "see"] == [d.item for d in doubts][:40]
    assert "85 % only" in Words(listed).text
    assert "0 of 27" in Words(progress(MAP)).text
    assert "2 of 27" in Words(progress(Confirm(items=("r4", "g2")).apply(MAP))).text


def test_what_was_taken_away_comes_back_alone() -> None:
    h = History.of(MAP)
    edits_made = (DeleteRegion(region="r4"), RenameRegion(region="r5", name="kept"), DeleteGateway(gateway="g4"))
    for n, edit in enumerate(edits_made, 1):
        h = step(h, Do(number=n, at="2026-01-01T00:00:00Z", edit=edit))
    assert lost(h, h.done[0]) == ("r4", "g3")
    assert [a for d, a in buttons_of(edits(h, True)) if d == "restore"] == ["1"], "the last one is undone as well"
    assert "restore" not in edits(h, False)
    back = restore(lost(h, h.done[0])).apply(h.map, h.base)
    assert back.regions["r4"].boundary == MAP.regions["r4"].boundary
    assert back.gateways["g3"].regions == MAP.gateways["g3"].regions
    assert back.regions["r5"].name == "kept"
    assert "g4" not in back.gateways


def test_history_names_every_edit_and_leads_back_and_forth() -> None:
    h = History.of(MAP)
    made = [RenameRegion(region="r4", name=n) for n in ("one", "two", "three")]
    for n, edit in enumerate(made, 1):
        h = step(h, Do(number=n, at="2026-01-01T10:00:00Z", by="Ada", edit=edit))
    h = step(h, Undo(number=4, at="2026-01-01T10:01:00Z"))
    html = edits(h, True)
    text = Words(html).text
    for name in ("one", "two", "three"):
        assert f"rename r4 to {name}" in text
    assert "Ada · 2026-01-01 10:00 UTC" in text
    assert buttons_of(html) == [("back", "3"), ("back", "1"), ("back", "0")]
    assert buttons_of(edits(h, False)) == []
    for n in range(5, 5 + 2 * MOST):
        h = step(h, Do(number=n, at="2026-01-01T10:00:00Z", edit=RenameRegion(region="r4", name=f"n{n}")))
    assert len(buttons_of(edits(h, True))) == MOST


def test_layers_have_a_switch_and_a_slider_each_and_junk_is_refused() -> None:
    view = Spy()
    tab = MapTab(view)  # type: ignore[arg-type]
    html = layer_rows(tab.shown, tab.strength)
    assert len(buttons_of(html)) == 2 * len(LAYERS)
    tab.doers["layer"]("/points 0")
    tab.doers["strength"]("/floors 40")
    html = layer_rows(tab.shown, tab.strength)
    assert view.calls == [("show_layer", "/points")]
    assert 'data-arg="/points">' in html
    assert 'value="40"' in html
    for do, arg in (("layer", "/nowhere 1"), ("strength", "/floors much"), ("strength", "/etc 40")):
        with pytest.raises(EditError):
            tab.doers[do](arg)


def test_every_command_stands_in_the_help_and_in_the_sheet() -> None:
    from rgviz.app import static_folder

    page, keys = help_page(static_folder()), sheet()
    for c in COMMANDS:
        told = f"<td>{Words(c.title).text.strip()}</td>"
        assert told in page, c.name
        assert told in keys, c.name
    used = [k for c in COMMANDS for k in c.keys]
    assert len(used) == len(set(used)), "a key that two commands have"
    assert not {k.upper() for k in used} & set("WASDQE"), "a key that flies the camera"
    assert set(TOOLS) <= set(BY_NAME)


def test_buttons_beside_a_selection_fit_it() -> None:
    region = buttons((Item("region", "r4"),))
    assert {"confirm", "revert", "delete", "reshape"} <= {a for _, a in buttons_of(region)}
    assert "merge" not in {a for _, a in buttons_of(region)}
    two = buttons((Item("region", "r4"), Item("region", "r5")))
    assert "merge" in {a for _, a in buttons_of(two)}


def test_nothing_foreign_is_markup() -> None:
    m = RenameRegion(region="r4", name=HOSTILE).apply(MAP)
    m = ClassifyRegion(region="r4", class_=HOSTILE).apply(m)
    m = LabelObject(object="o2", label=HOSTILE).apply(m)
    m = note_on(m, HOSTILE, "r4").apply(m)
    m = MoveGateway(gateway="g3", posts=((4.0, 5.0), (4.1, 5.0))).apply(m)
    h = step(History.of(MAP), Do(number=1, at="now", by=HOSTILE[:80], edit=RenameRegion(region="r4", name=HOSTILE)))
    pages = [row(m, kind, id) for kind, id in (("region", "r4"), ("object", "o2"), ("note", next(iter(m.notes))))]  # type: ignore[arg-type]
    pages += [work(m, work_list(m, lint(m))), findings(m, lint(m), True), notes(m), edits(h, True)]
    for page in pages:
        assert "img" not in Words(page).tags
    tab = FindTab(Spy(m))  # type: ignore[arg-type]
    tab.search(f"'{HOSTILE}:'")
    assert "img" not in Words(tab._list()).tags


def test_presses_from_a_browser_are_bounded() -> None:
    assert read('{"type":"press","do":"go","arg":"r3","n":4}') == Press("go", "r3")
    assert read('{"type":"press","do":"' + "x" * 21 + '"}') is None
    assert read('{"type":"press","do":"go","arg":"' + "x" * 2001 + '"}') is None
    assert read('{"type":"press","do":7}') is None


def test_confirmed_items_wear_a_tick() -> None:
    assert "✓" not in row(MAP, "region", "r4")
    assert "✓" in row(Confirm(items=("r4",)).apply(replace(MAP)), "region", "r4")
