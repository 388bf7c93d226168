"""The tools in a real browser, as a person uses them: drawn, dragged, seen before they are done, undone tomorrow."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from pilot import Pilot
from playwright.sync_api import Browser

from rgcore.model.edits import DeleteGateway, DeleteRegion
from rgcore.model.records import Provenance
from rgviz.app import App
from rgviz.picking import Item

Open = Callable[..., Pilot]

# of office_map(4, 1, 2): r4 is the room x 4..7.8, y 0..5, its door g3 at x 5.5..6.4, y 5 to the hall r2
ROOM, DOOR, DOOR_POST = (5.5, 3.5), (5.95, 5.0), (6.4, 5.0)


@pytest.fixture(scope="module")
def shared(office: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[App]:
    """One server for this file; each test leaves the map as it found it."""
    project = tmp_path_factory.mktemp("shared") / "office.rg"
    shutil.copytree(office, project)
    app = App(port=0)
    app.open_project(project)
    yield app
    app.stop()


@pytest.fixture(scope="module")
def desk(shared: App, browser: Browser) -> Iterator[Pilot]:
    """One page for this file: opening one takes longer than most tests."""
    pilot = Pilot(browser, shared.url)
    yield pilot
    pilot.close()


@pytest.fixture
def page(shared: App, desk: Pilot) -> Iterator[Pilot]:
    """The page with no tool, nothing selected and the whole map in view; what a test does is undone behind it."""
    for _ in range(3):
        desk.key("Escape")
    desk.key("f")
    desk.until(lambda: all(not v.selection and not v.hands.busy for v in shared.views.values()))
    desk.frames(2)
    yield desk
    while shared.opened.undo_title:
        shared.worker.post(shared.opened.undo)
        shared.worker.wait()
    assert not desk.errors


def tool(p: Pilot, key: str, title: str) -> None:
    p.key(key)
    p.page.wait_for_function("(t) => window.rg.hand.sketch.title === t", arg=title)


def pull(p: Pilot, *way: tuple[float, float], let_go: bool = True) -> None:
    """Drag from point to point of the map."""
    places = [p.at(*w) for w in way]
    p.page.mouse.move(*places[0])
    p.page.mouse.down()
    for x, y in places[1:]:
        p.page.mouse.move(x, y, steps=4)
    if let_go:
        p.page.mouse.up()


def sketched(p: Pilot, test: str) -> None:
    """Wait until what the tool shows fits."""
    p.page.wait_for_function(f"() => {{ const s = window.rg.hand.sketch; return {test}; }}")


def test_split_a_room_by_a_line_and_merge_it_again(shared: App, page: Pilot) -> None:
    page.click(*ROOM)
    page.see("Robot box")
    tool(page, "x", "Split a region")
    pull(page, (5.9, 0.6), (5.9, 3.0), (5.9, 4.4), let_go=False)
    sketched(page, "s.strokes.filter(k => k.fill).length === 2 && !s.refused")
    page.shot("split-preview")
    assert len(shared.map.regions) == 10, "nothing is done before the hand lets go"
    page.page.mouse.up()
    page.until(lambda: len(shared.map.regions) == 11)
    new = next(r for r in shared.map.regions if r.startswith("ru"))
    page.see("Undo: split r4")
    page.key("4")
    page.until(lambda: shared.map.regions[new].class_ == "CC")
    page.key("Escape")
    page.until(lambda: all(not v.hands.busy for v in shared.views.values()))
    page.click(4.9, 3.5)
    page.click(6.9, 3.5, shift=True)
    page.until(lambda: any(len(v.selection) == 2 for v in shared.views.values()))
    page.shot("split-done")
    page.key("m")
    page.until(lambda: len(shared.map.regions) == 10)
    page.see(re.compile("Undo: merge"))


def test_draw_a_gateway_and_drag_its_post(shared: App, page: Pilot) -> None:
    tool(page, "g", "Add a gateway")
    page.click(4.1, 5.0)
    page.page.mouse.move(*page.at(4.9, 5.0), steps=3)
    sketched(page, "/between/.test(s.note)")
    page.shot("gateway-preview")
    page.click(4.9, 5.0)
    page.until(lambda: any(g.startswith("gu") for g in shared.map.gateways))
    new = next(g for g in shared.map.gateways if g.startswith("gu"))
    assert set(shared.map.gateways[new].regions) == {"r2", "r4"}
    page.key("5")
    page.until(lambda: shared.map.gateways[new].class_ == "opening")
    page.key("Escape")
    sketched(page, "!s.grab && s.handles.length === 5")
    post = max(shared.map.gateways[new].posts)
    before = shared.map.gateways[new].width
    pull(page, post, (post[0] + 0.2, 5.0), (post[0] + 0.35, 5.0))
    page.until(lambda: abs(shared.map.gateways[new].width - before) > 0.2)
    page.see(re.compile("Undo: move gu"))
    page.shot("gateway-moved")


def test_draw_a_missing_wall(shared: App, page: Pilot) -> None:
    tool(page, "l", "Draw a wall")
    pull(page, (4.1, 2.6), (5.5, 2.6), (7.7, 2.6), let_go=False)
    sketched(page, "/m of r4/.test(s.note)")
    page.shot("wall-preview")
    page.page.mouse.up()
    page.until(lambda: any(v.startswith("lu") for v in shared.map.lines))
    page.see("Undo: draw a wall")
    wall = next(v for k, v in shared.map.lines.items() if k.startswith("lu"))
    assert wall.regions == ("r4",)
    assert abs(wall.start[1] - 2.6) < 0.05


def test_rectangle_select_and_seed_a_box(shared: App, page: Pilot) -> None:
    page.click(*ROOM)
    page.key("z")
    page.page.wait_for_timeout(500)
    page.key("Escape")
    page.see("Reduction")
    a, b = page.at(5.3, 0.2), page.at(6.7, 1.1)
    page.page.keyboard.down("Shift")
    page.drag(a, b, steps=4)
    page.page.keyboard.up("Shift")
    page.until(lambda: any(len(v.selection) == 4 for v in shared.views.values()))
    page.see("4 lines")
    page.shot("rectangle")
    page.page.keyboard.down("Control")
    page.drag(page.at(5.3, 0.8), page.at(6.7, 1.1), steps=4)
    page.page.keyboard.up("Control")
    page.until(lambda: any(len(v.selection) == 3 for v in shared.views.values()))
    page.key("b")
    page.until(lambda: any(o.startswith("ou") for o in shared.map.objects))
    box = next(o for k, o in shared.map.objects.items() if k.startswith("ou"))
    assert len(box.lines) == 3
    assert np.allclose(box.center[:2], (5.95, 0.65), atol=0.05)
    page.shot("seeded-by-rectangle")


def test_reshape_by_a_corner_and_a_side(shared: App, page: Pilot) -> None:
    page.click(*ROOM)
    page.see("Robot box")
    tool(page, "o", "Reshape a region")
    sketched(page, "s.handles.length === 8")
    pull(page, (7.8, 0.0), (7.5, 0.3), (7.2, 0.6), let_go=False)
    sketched(page, "s.marks.length === 1 && /m²/.test(s.note)")
    page.shot("reshape")
    page.page.mouse.up()
    page.until(lambda: any(abs(x - 7.2) < 0.05 for x, _ in shared.map.regions["r4"].boundary))
    page.see("Undo: reshape r4")
    page.key("Control+z")
    page.until(lambda: (7.8, 0.0) in shared.map.regions["r4"].boundary)
    page.key("Delete")
    page.page.wait_for_timeout(200)
    assert "r4" in shared.map.regions, "Del in this tool is for corners"


def test_a_floor_is_reviewed_by_keys(shared: App, page: Pilot) -> None:
    page.key("u")
    page.see(re.compile("1 of 1?\\d to check"))
    first = next(v.selection[0].id for v in shared.views.values() if v.selection)
    page.shot("review")
    page.key("c")
    page.until(lambda: _provenance(shared, first).confirmed)
    page.until(lambda: any(v.selection and v.selection[0].id != first for v in shared.views.values()))
    second = next(v.selection[0].id for v in shared.views.values() if v.selection)
    page.key("Shift+Delete")
    page.until(lambda: not _there(shared, second))
    page.until(lambda: any(v.selection and v.selection[0].id not in (first, second) for v in shared.views.values()))
    page.key("Control+z")
    page.until(lambda: _there(shared, second))
    page.key("u")
    page.key("Shift+U")
    page.see(re.compile("to check"))


def _there(app: App, id: str) -> bool:
    return any(id in getattr(app.map, kind) for kind in ("regions", "gateways", "lines", "objects"))


def test_a_note_is_written_on_the_map(shared: App, page: Pilot) -> None:
    page.click(*ROOM)
    page.see("Robot box")
    page.key("t")
    page.page.wait_for_function("() => document.activeElement.id === 'rgviz-ask'")
    page.page.keyboard.type("Glass wall? measure l <b>")
    page.shot("note")
    page.page.keyboard.press("Enter")
    page.until(lambda: len(shared.map.notes) == 1)
    note = next(iter(shared.map.notes.values()))
    assert (note.item, note.text) == ("r4", "Glass wall? measure l <b>")


def test_a_refused_cut_says_why_here_alone_and_esc_ends_it(shared: App, page: Pilot, open_page: Open) -> None:
    other = open_page(shared.url)
    tool(page, "x", "Split a region")
    pull(page, (2.0, 12.3), (4.0, 12.4), (6.0, 12.5))
    page.see("Not done")
    assert other.page.get_by_text("Not done").count() == 0
    page.key("Escape")
    page.key("Escape")
    sketched(page, "!s.title")
    assert shared.opened.undo_title is None


def test_a_tool_lets_go_of_what_another_browser_deletes(shared: App, page: Pilot) -> None:
    page.click(*ROOM)
    page.see("Robot box")
    tool(page, "o", "Reshape a region")
    shared.worker.post(shared.opened.do, DeleteRegion(region="r4"))
    page.see("Put away")
    sketched(page, "!s.title && !s.handles.length")
    shared.worker.post(shared.opened.undo)
    page.until(lambda: "g3" in shared.map.gateways)
    page.click(*DOOR)
    page.see("Crossing-points")
    pull(page, DOOR_POST, (6.6, 5.0), let_go=False)
    shared.worker.post(shared.opened.do, DeleteGateway(gateway="g3"))
    page.until(lambda: "g3" not in shared.map.gateways)
    page.page.mouse.up()
    sketched(page, "!s.grab && !s.handles.length")
    assert "g3" not in shared.map.gateways


def test_what_a_browser_makes_up_is_ignored(shared: App, page: Pilot) -> None:
    page.click(*ROOM)
    page.see("Robot box")
    nonsense = [
        {"type": "pointer", "kind": "press", "x": 1e9, "y": 0, "pixel": 0.01},
        {"type": "pointer", "kind": "cancel", "x": 0, "y": 0, "pixel": 0.01},
        {"type": "pointer", "kind": "press", "x": 0, "y": 0, "pixel": -1},
        {"type": "pointer", "kind": "press", "x": 0, "y": 0, "pixel": 0.01, "handle": "c0.999"},
        {"type": "pointer", "kind": "release", "x": 0, "y": 0, "pixel": 0.01},
        {"type": "answer", "question": 7, "value": "x"},
        {"type": "answer", "question": "x"},
        {"type": "tool", "name": "__class__"},
    ]
    for message in nonsense:
        page.page.evaluate("(m) => window.rg.send(m)", message)
    page.key("4")
    page.until(lambda: shared.map.regions["r4"].class_ == "CC")
    assert shared.opened.undo_title == "relabel r4 as CC"
    assert not page.page.get_by_text("fault in rgviz").count()


def test_many_are_relabelled_in_one_step_and_undone_after_a_restart(
    office: Path, tmp_path: Path, open_page: Open
) -> None:
    project = tmp_path / "office.rg"
    shutil.copytree(office, project)
    app = App(port=0)
    app.open_project(project)
    try:
        p = open_page(app.url)
        view = next(iter(app.views.values()))
        app.worker.post(view.select, tuple(Item("region", r) for r in app.map.regions))
        p.see("10 regions")
        p.key("2")
        p.until(lambda: {r.class_ for r in app.map.regions.values()} == {"ODMA"})
        p.see("Undo: relabel 10 regions as ODMA")
        assert len(app.opened.project.history.done) == 1
    finally:
        app.stop()
    app = App(port=0)
    app.open_project(project)
    try:
        p = open_page(app.url)
        p.see("Undo: relabel 10 regions as ODMA")
        p.key("Control+z")
        p.until(lambda: app.map.regions["r2"].class_ == "CDMA")
    finally:
        app.stop()


def _provenance(app: App, id: str) -> Provenance:
    m = app.map
    for table in (m.regions, m.gateways, m.lines, m.objects):
        if id in table:
            return table[id].provenance  # type: ignore[attr-defined, no-any-return]
    raise KeyError(id)
