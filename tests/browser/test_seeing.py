"""Opening a map and looking at it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pilot import Pilot

from rgviz.app import App

Open = Callable[..., Pilot]


def test_first_view_shows_the_whole_map(app: App, open_page: Open) -> None:
    p = open_page(app.url)
    picture = p.picture()
    ink = np.abs(picture.astype(int) - 255).sum(2) > 40
    assert 0.15 < ink.mean() < 0.95, "the canvas is blank or full"
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50
    left, top, right, bottom = p.canvas_box()
    for x, y in ((-3.0, 0.0), (16.0, 0.0), (16.0, 12.0), (-3.0, 12.0)):
        px, py = p.at(x, y)
        assert left + 5 < px < right - 5
        assert top + 5 < py < bottom - 5
    width = p.at(16.0, 0.0)[0] - p.at(-3.0, 0.0)[0]
    height = p.at(0.0, 0.0)[1] - p.at(0.0, 12.0)[1]
    assert height > 0, "north is not up"
    assert np.isclose(width / 19.0, height / 12.0, rtol=0.02), "not the same scale both ways"
    assert max(width / (right - left), height / (bottom - top)) > 0.75, "the map does not fill the view"
    assert "token" not in p.page.url
    assert p.page.title() == "office - rgviz"
    p.shot("first-view")


def test_layers_are_switched_for_one_browser_alone(app: App, open_page: Open) -> None:
    a, b = open_page(app.url), open_page(app.url)
    assert a.visible("/lines/lines")
    assert not a.visible("/boxes/boxes")
    a.layer("Lines").uncheck()
    a.layer("Boxes").check()
    a.page.wait_for_function("() => window.__viserSceneTree.getState()['/lines/lines'].effectiveVisibility === false")
    a.page.wait_for_function("() => window.__viserSceneTree.getState()['/boxes/boxes']?.effectiveVisibility")
    assert b.visible("/lines/lines")
    assert not b.visible("/boxes/boxes")
    for title in ("Trajectory", "Main axes"):
        a.layer(title).check()
    a.shot("layers")


def test_turning_to_3d_and_back_keeps_the_place(app: App, open_page: Open) -> None:
    p = open_page(app.url)
    before = p.at(8.0, 6.0)
    p.key("v")
    p.page.wait_for_function("() => window.rg.state.mode === '3d'")
    p.page.wait_for_function("() => window.__viserSceneTree.getState()['/walls/walls'].effectiveVisibility")
    p.shot("solid")
    p.key("v")
    p.page.wait_for_function("() => window.rg.state.mode === '2d'")
    p.key("f")
    p.page.wait_for_timeout(500)
    p.frames(3)
    assert np.allclose(p.at(8.0, 6.0), before, atol=4)


def test_wheel_and_drag_stay_straight_down(app: App, open_page: Open) -> None:
    p = open_page(app.url)
    pixel = p.at(6.0, 9.0)
    p.page.mouse.move(*pixel)
    for _ in range(6):
        p.page.mouse.wheel(0, -240)
        p.frames(4)
    p.page.wait_for_timeout(400)
    assert np.allclose(p.at(6.0, 9.0), pixel, atol=12), "the wheel does not zoom to the pointer"
    scale = p.at(7.0, 9.0)[0] - p.at(6.0, 9.0)[0]
    assert scale > 50
    p.drag(pixel, (pixel[0] + 80, pixel[1] + 50))
    p.page.wait_for_timeout(300)
    assert np.allclose(p.at(6.0, 9.0), (pixel[0] + 80, pixel[1] + 50), atol=12)
    top, floor = p.at(6.0, 9.0, 2.0), p.at(6.0, 9.0, 0.0)
    assert np.hypot(top[0] - floor[0], top[1] - floor[1]) < 0.1 * scale, "things lean in the flat view"
    assert p.picture().std() > 10, "the map vanished on zooming"
    p.shot("zoomed")


def test_a_narrow_window_leaves_the_picture_its_room(app: App, open_page: Open) -> None:
    p = open_page(app.url, size=(1000, 700))
    left, _, right, _ = p.canvas_box()
    assert right - left > 600
    p.shot("narrow")
    p.key("Shift+F")
    p.see("select all found")
    p.until(lambda: p.canvas_box()[0] > left + 200)
    p.key("f")
    p.page.locator('button.row[data-arg="r4"]').first.click()
    p.see("Robot box")
