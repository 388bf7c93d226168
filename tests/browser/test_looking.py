"""Lists, review, history, strength of layers, light and dark, the sheet of keys, the ruler, the link for looking."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
from pilot import Pilot

from rgcore.model.edits import RenameRegion
from rgviz.app import App

Open = Callable[..., Pilot]
ROOM = (5.5, 3.5)


def tab(p: Pilot, name: str) -> None:
    p.page.locator(f'.tabs button[data-arg="{name}"]').click()
    p.page.locator(f'.tabs button.on[data-arg="{name}"]').wait_for()


def row(p: Pilot, id_: str) -> None:
    p.page.locator(f'button.row[data-arg="{id_}"]').first.click()


def test_a_search_finds_selects_and_goes_there(app: App, open_page: Open) -> None:
    p = open_page(app.url)
    p.key("Shift+F")
    p.see("A search:")
    p.page.wait_for_function("() => document.activeElement.tagName === 'INPUT'")
    p.page.keyboard.type("class:CC")
    p.page.keyboard.press("Enter")
    p.page.wait_for_function("() => document.querySelectorAll('button.row').length === 2")
    row(p, "r8")
    p.see("Robot box")
    view = next(iter(app.views.values()))
    assert [i.id for i in view.selection] == ["r8"]
    p.frames(3)
    left, top, right, bottom = p.canvas_box()
    x, y = p.at(*np.mean(app.map.regions["r8"].boundary, 0))
    assert abs(x - (left + right) / 2) < 40, "the camera did not go there"
    assert abs(y - (top + bottom) / 2) < 60
    p.shot("find")
    p.button("select all found").click()
    p.see("2 regions")
    p.type_into("Search", "clas:CC")
    p.see(re.compile("did you mean class"))
    assert len(view.selection) == 2


def test_a_finding_is_mended_and_the_history_leads_back(app: App, open_page: Open) -> None:
    app.worker.post(app.opened.do, RenameRegion(region="r5", name="office 3"))
    app.worker.wait()
    p = open_page(app.url)
    tab(p, "Review")
    p.see(re.compile("has the name of"))
    p.shot("review")
    p.button("fix").click()
    p.see("Nothing looks wrong.")
    assert app.map.regions["r5"].name != "office 3"
    p.key("u")
    p.see(re.compile("to check:"))
    p.key("c")
    p.see(re.compile("^1 of 27"))
    tab(p, "History")
    p.see("The map as the mapper made it")
    p.shot("history")
    row(p, "0")
    p.page.wait_for_function("() => document.querySelectorAll('.row.undone').length === 3")
    assert app.map.regions["r5"].name == "r5"
    row(p, "1")
    p.page.wait_for_function("() => document.querySelectorAll('.row.undone').length === 2")
    assert app.map.regions["r5"].name == "office 3"


def test_layers_fade_and_one_browser_goes_dark_alone(app: App, open_page: Open) -> None:
    a, b = open_page(app.url), open_page(app.url)
    x, y = 14.0, 3.8

    def seen(p: Pilot) -> np.ndarray:
        p.frames(3)
        px, py = p.at(x, y)
        left, top, *_ = p.canvas_box()
        return p.picture()[int(py - top) - 2 : int(py - top) + 3, int(px - left) - 2 : int(px - left) + 3].mean((0, 1))

    full = seen(a)
    slider = a.page.get_by_label("Floors opacity")
    slider.fill("20")
    faint = seen(a)
    assert (faint > full + 5).any(), "the floor is as strong as before"
    assert np.allclose(faint, 255 - 0.2 * (255 - full), atol=6)
    assert np.allclose(seen(b), full, atol=2), "the other browser's floor faded, too"
    slider.fill("100")
    assert np.allclose(seen(a), full, atol=2)
    a.button("Dark").click()
    a.page.wait_for_function("() => document.documentElement.classList.contains('rg-dark')")
    a.page.wait_for_timeout(300)
    dark = seen(a)
    assert dark.max() < 110
    assert a.picture()[3, 3].max() < 60
    assert b.picture()[3, 3].min() > 240
    from rgviz import theme

    floor = theme.dark(tuple(int(c) for c in full))  # type: ignore[arg-type]
    assert np.allclose(dark, floor, atol=6), "the filter of the page and theme.dark do not agree"
    a.shot("dark")
    tab(a, "Review")
    a.shot("dark-review")


def test_the_sheet_of_keys_comes_and_goes(app: App, open_page: Open) -> None:
    p = open_page(app.url)
    p.key("?")
    p.page.locator("#rg-sheet").wait_for()
    p.see("Confirm, go on to the next")
    box = p.page.locator("#rg-sheet > div").bounding_box()
    assert box is not None
    assert box["y"] >= 0
    p.shot("keys")
    p.page.keyboard.press("Escape")
    p.page.locator("#rg-sheet").wait_for(state="detached")
    answer = p.page.request.get(app.url.split("/?")[0] + "/help")
    assert answer.status == 200
    assert "Confirm, go on to the next" in answer.text()


def test_the_ruler_reads_a_distance(app: App, open_page: Open) -> None:
    p = open_page(app.url)
    p.key("Shift+M")
    p.see("Click from place to place", timeout=5000)
    for place in ((4.0, 0.0), (7.8, 0.0)):
        p.click(*place)
        p.page.wait_for_timeout(150)
    view = next(iter(app.views.values()))
    p.until(lambda: len(getattr(view.hands.tool, "points", ())) == 2)
    from rgviz.tools.measuring import readout

    assert readout(view.hands.tool.points) == "3.80 m at 0°"  # type: ignore[attr-defined]
    p.shot("ruler")


def test_the_link_for_looking_changes_nothing(app: App, open_page: Open) -> None:
    before = app.map
    p = open_page(app.view_url)
    p.see("For looking")
    p.click(*ROOM)
    p.see("Robot box")
    assert p.field("Name").count() == 0
    assert p.page.get_by_role("button", name=re.compile("^Undo")).count() == 0
    p.key("4")
    p.see("Not done")
    for press in (("command", "delete"), ("back", "0"), ("fix", "x"), ("command", "wall")):
        p.page.evaluate("([d, a]) => window.rg.send({type: 'press', do: d, arg: a})", press)
    p.page.evaluate("() => window.rg.send({type: 'commit', field: 'x', value: 'y'})")
    p.key("Delete")
    p.page.wait_for_timeout(500)
    app.worker.wait()
    assert app.map is before
    tab(p, "Find")
    p.see("A search:")
    p.shot("looking")
    q = open_page(app.url)
    q.click(*ROOM)
    q.see("Robot box")
    q.key("4")
    q.see("Undo: relabel r4 as CC")
