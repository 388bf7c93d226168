"""The picture in the README: the demo building in the real app, photographed by the browser suite's own hand.

python tests/browser/picture.py docs/view.png
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from pilot import FLAGS, Pilot, chromium
from playwright.sync_api import sync_playwright

from rgcore.config import Config
from rgcore.scans.read import read_log
from rgviz.app import App
from rgviz.demo import LOG
from rgviz.mapping import map_into


def main(out: Path) -> None:
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as p:
        path = Path(folder) / "office.rg"
        map_into(path, read_log(LOG), Config()).close()
        browser = p.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        app = App(port=0)
        try:
            app.open_project(path)
            pilot = Pilot(browser, app.url, size=(1480, 860))
            room = min(app.map.regions.values(), key=lambda r: abs(r.box.size[0] * r.box.size[1] - 15))
            pilot.click(*(np.mean(room.boundary, 0)))
            pilot.see("Robot box")
            pilot.page.wait_for_timeout(500)
            pilot.frames(3)
            pilot.page.screenshot(path=str(out))
        finally:
            app.stop()
            browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
