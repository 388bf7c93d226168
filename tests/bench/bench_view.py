"""How fast the view is, by the browsers' own clock: python tests/bench/bench_view.py [LINES]

Two pages of one Chromium with software rendering, 1280 x 800, look at a synthetic office.

* edit to other browser: from the key that relabels a region in one page to the pixels that show it in the other
* first picture:         from asking for the page to the painted map, in a page of its own
* click to inspector:    from the release of the mouse button to the facts standing in the panel
* hand to preview:       from a move of the pointer that draws a cut to both halves of the room on the overlay
* pick:                  CPU time of finding what lies under the pointer
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from pathlib import Path

for folder in ("browser", "rgviz"):
    sys.path.insert(0, str(Path(__file__).parents[1] / folder))

import numpy as np  # noqa: E402
from make_project import make_project  # noqa: E402
from office_map import big_office  # noqa: E402
from pilot import FLAGS, Pilot, chromium  # noqa: E402
from playwright.sync_api import Browser, sync_playwright  # noqa: E402

from rgcore.model.records import Region  # noqa: E402
from rgviz.app import App  # noqa: E402
from rgviz.picking import Item  # noqa: E402

NOW = "performance.timeOrigin + performance.now()"
STAMP_INPUT = f"""() => {{ for (const kind of ["keydown", "pointerup"])
  window.addEventListener(kind, () => {{ window.inputAt = {NOW}; }}, true); }}"""
WATCH_FLOOR = f"""(name) => {{ const m = window.__viserMutable, scene = m.scene, old = scene.onAfterRender;
  const shape = () => {{ let n = 0;
    m.nodeRefFromName[name]?.traverse(o => {{ n += o.geometry?.attributes.position.count || 0; }}); return n; }};
  const before = shape(); window.seenAt = null;
  scene.onAfterRender = (renderer, s, camera) => {{ old(renderer, s, camera);
    if (window.seenAt !== null || !shape() || shape() === before) return;
    const gl = renderer.getContext(), pixel = new Uint8Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);   // waits until the frame is painted
    window.seenAt = {NOW}; scene.onAfterRender = old; }}; }}"""
WATCH_TEXT = f"""(text) => {{ window.seenAt = null;
  const check = () => {{
    if (window.seenAt === null && document.body.innerText.includes(text)) window.seenAt = {NOW}; }};
  new MutationObserver(check).observe(document.body, {{subtree: true, childList: true, characterData: true}}); }}"""


WATCH_SKETCH = f"""() => {{ const rg = window.rg, paint = rg.handlers.sketch; window.movedAt = window.sketchedAt = null;
  window.addEventListener("pointermove", () => {{ window.movedAt = {NOW}; window.sketchedAt = null; }}, true);
  rg.handlers.sketch = (m) => {{ paint(m); if ((m.strokes || []).some(k => k.fill)) window.sketchedAt = {NOW}; }}; }}"""


def main() -> None:
    wanted = int(sys.argv[1]) if len(sys.argv) > 1 else 5000
    map_ = big_office(wanted)
    with tempfile.TemporaryDirectory() as folder:
        app = App(port=0)
        app.open_project(make_project(Path(folder) / "big.rg", map_))
        print(", ".join(f"{len(getattr(map_, kind))} {kind}" for kind in ("lines", "regions", "gateways", "objects")))
        try:
            with sync_playwright() as p:
                chrome = p.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
                _say("first picture", [_first_picture(chrome, app.url) for _ in range(3)])
                _measure(app, [Pilot(chrome, app.url, size=(1280, 800)) for _ in range(2)])
        finally:
            app.stop()


def _first_picture(chrome: Browser, url: str) -> float:
    """ms by the page's own clock, until a frame with the lines of the map was painted."""
    page = Pilot(chrome, url, size=(1280, 800))
    page.frames(1)
    took = float(page.page.evaluate("performance.now()"))
    page.close()
    return took


def _measure(app: App, pages: list[Pilot]) -> None:
    a, b = pages
    a.page.evaluate(STAMP_INPUT)
    rooms = [r for r in app.map.regions.values() if r.class_ in ("TOMA", "CC")]
    chosen = rooms[:: max(1, len(rooms) // 10)][:10]

    clicks, edits, frames = [], [], []
    for n, room in enumerate(chosen):
        x, y = room.boundary[0][0] + 2.9, (room.boundary[0][1] + room.boundary[2][1]) / 2
        a.key("Escape")
        a.see("Reduction")
        a.page.evaluate(WATCH_TEXT, "Made by")
        a.click(x, y)
        a.page.wait_for_function("() => window.seenAt !== null")
        clicks.append(a.page.evaluate("window.seenAt - window.inputAt"))

        view = min(app.views.values(), key=lambda v: v.client.client_id)
        app.worker.post(view.select, (Item("region", room.id),))  # whatever stands that small under the pointer
        a.see("Robot box")
        a.page.wait_for_timeout(500)

        to = "CC" if room.class_ == "TOMA" else "TOMA"
        b.page.evaluate(WATCH_FLOOR, f"/floors/c{to}")
        a.key("4" if to == "CC" else "3")
        b.page.wait_for_function("() => window.seenAt !== null")
        edits.append(b.page.evaluate("window.seenAt") - a.page.evaluate("window.inputAt"))
        a.page.wait_for_timeout(500)
        if n < 3:
            began = time.perf_counter()
            a.frames(10)
            frames.append((time.perf_counter() - began) * 100)
    _say("hand to preview", _previews(a, chosen))
    _say("pick", _picks(app, a))
    _say("click to inspector", clicks)
    _say("edit to other browser", edits)
    _say("one frame", frames)


def _previews(a: Pilot, rooms: list[Region]) -> list[float]:
    a.key("Escape")
    a.key("x")
    a.page.wait_for_function("() => window.rg.hand.sketch.title")
    a.page.evaluate(WATCH_SKETCH)
    out = []
    for room in rooms:
        (x0, y0), (x1, y1) = room.boundary[0], room.boundary[2]
        x = (x0 + x1) / 2
        a.page.mouse.move(*a.at(x, y0 + 0.1 * (y1 - y0)))
        a.page.mouse.down()
        a.page.wait_for_timeout(400)
        a.page.mouse.move(*a.at(x, y0 + 0.9 * (y1 - y0)))
        a.page.wait_for_function("() => window.sketchedAt !== null")
        out.append(a.page.evaluate("window.sketchedAt - window.movedAt"))
        a.key("Escape")
        a.page.mouse.up()
        a.page.wait_for_timeout(200)
    a.key("Escape")
    return out


def _picks(app: App, a: Pilot) -> list[float]:
    picker, camera = app.picker(app.map), next(iter(app.views.values())).client.camera
    eye, out = np.asarray(camera.position, float), []
    for room in list(app.map.regions.values())[::10]:
        target = np.array([*room.box.center, 0.0])
        began = time.process_time()
        picker.at(camera, (0.5, 0.5), (eye, target - eye))
        out.append(1000 * (time.process_time() - began))
    return out


def _say(name: str, values: list[float]) -> None:
    median, worst = statistics.median(values), max(values)
    print(f"{name:<22} median {median:4.0f} ms, worst {worst:4.0f} ms of {len(values)}")


if __name__ == "__main__":
    main()
