"""How fast the view is, by the browsers' own clock: python tests/bench/bench_view.py [LINES]

Two pages of one Chromium with software rendering, 1280 x 800, look at a synthetic office.

* edit to other browser: from the key that relabels a region in one page to the pixels that show it in the other
* click to inspector:    from the release of the mouse button to the facts standing in the panel
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from pathlib import Path

for folder in ("browser", "rgviz"):
    sys.path.insert(0, str(Path(__file__).parents[1] / folder))

from make_project import make_project  # noqa: E402
from office_map import big_office  # noqa: E402
from pilot import FLAGS, Pilot, chromium  # noqa: E402
from playwright.sync_api import sync_playwright  # noqa: E402

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
                _measure(app, [Pilot(chrome, app.url, size=(1280, 800)) for _ in range(2)])
        finally:
            app.stop()


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
    _say("click to inspector", clicks)
    _say("edit to other browser", edits)
    _say("one frame", frames)


def _say(name: str, values: list[float]) -> None:
    median, worst = statistics.median(values), max(values)
    print(f"{name:<22} median {median:4.0f} ms, worst {worst:4.0f} ms of {len(values)}")


if __name__ == "__main__":
    main()
