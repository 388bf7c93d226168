"""The pictures of README and walk-throughs: the demo building in the real app, by the hand of the browser suite.

python tests/browser/picture.py docs
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from pilot import FLAGS, Pilot, chromium
from playwright.sync_api import sync_playwright

from rgcore.config import Config
from rgcore.model.edits import ClassifyRegion, Edit, RenameRegion
from rgcore.model.records import Region
from rgcore.scans.read import read_log
from rgviz.app import App
from rgviz.demo import LOG
from rgviz.mapping import map_into


def main(docs: Path) -> None:
    (docs / "pictures").mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as p:
        path = Path(folder) / "office.rg"
        map_into(path, read_log(LOG), Config()).close()
        browser = p.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        app = App(port=0)
        try:
            app.open_project(path)
            _photograph(app, Pilot(browser, app.url, size=(1480, 860)), docs)
        finally:
            app.stop()
            browser.close()


def _photograph(app: App, pilot: Pilot, docs: Path) -> None:
    def shot(name: str) -> None:
        pilot.page.wait_for_timeout(600)
        pilot.frames(3)
        pilot.page.screenshot(path=str(docs / name))

    def tab(name: str) -> None:
        pilot.page.locator(f'.tabs button[data-arg="{name}"]').click()

    room = min(app.map.regions.values(), key=lambda r: abs(r.box.size[0] * r.box.size[1] - 15))
    pilot.click(*_middle(room))
    pilot.see("Robot box")
    shot("view.png")

    tab("Review")
    pilot.key("u")
    pilot.see("to check:")
    shot("pictures/review.png")

    pilot.key("c")
    tab("Find")
    pilot.type_into("Search", "class:TOMA area>12")
    pilot.see("select all found")
    shot("pictures/find.png")

    view = next(iter(app.views.values()))
    app.worker.post(view.go_to, [room.id])
    pilot.see("Robot box")
    pilot.page.wait_for_timeout(800)  # the camera goes there
    pilot.key("x")
    pilot.see("Drag a line across it")
    (x, y), (along, _) = _middle(room), room.box.size
    pilot.page.mouse.move(*pilot.at(x - along / 3, y))
    pilot.page.mouse.down()
    pilot.page.mouse.move(*pilot.at(x + along / 3, y), steps=6)
    shot("pictures/split.png")
    pilot.page.mouse.up()
    pilot.key("Escape")
    tab("History")
    pilot.key("f")
    shot("pictures/history.png")

    _again(app, pilot, shot)

    tab("Map")
    pilot.button("Dark").click()
    pilot.key("Escape")
    pilot.key("v")
    shot("pictures/solid.png")


def _again(app: App, pilot: Pilot, shot: Callable[[str], None]) -> None:
    """A few edits, then the log is mapped again as if small rooms were niches."""
    small = sorted(app.map.regions.values(), key=lambda r: r.box.size[0] * r.box.size[1])
    edits: list[Edit] = [ClassifyRegion(region=r.id, class_="store") for r in small[:2]]
    edits += [RenameRegion(region=r.id, name=n) for r, n in zip(small[-3:], ("Lab", "Office", "Corridor"), strict=True)]
    for edit in edits:
        app.worker.post(app.opened.do, edit)
    pilot.key("Shift+N")
    pilot.type_into("Find a setting", "min_area")
    pilot.page.locator('button[data-arg="places.min_area"]').click()
    pilot.type_into("places min area [m2]", "12")
    pilot.page.locator('button[data-do="start"]').click()
    pilot.see("Accept the new run", timeout=480_000)
    pilot.page.locator('button[data-do="which"][data-arg="new"]').click()
    pilot.key("f")
    shot("pictures/again.png")
    pilot.key("Shift+K")
    pilot.page.wait_for_timeout(500)
    pilot.page.locator('button[data-do="difference"]').first.scroll_into_view_if_needed()
    shot("pictures/changes.png")
    pilot.page.locator('button[data-do="discard"]').click()
    pilot.key("Shift+K")


def _middle(room: Region) -> tuple[float, float]:
    x, y = np.mean(room.boundary, 0)
    return float(x), float(y)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
