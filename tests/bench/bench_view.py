"""How fast the view is, by the browsers' own clock: python tests/bench/bench_view.py [LINES | huge]

Two pages of one Chromium with software rendering, 1280 x 800, look at a synthetic office of 5,000 lines; ``huge``: of
1,000 regions and 100,000 lines. A busy machine makes every clock slow, so what it costs in CPU time stands beside it:
of this process, which serves, and of Chromium with its software renderer.

* edit to other browser: from the key that relabels a region in one page to the pixels that show it in the other
* first picture:         from asking for the page to the painted map, panels in their place, in a page of its own
* click to inspector:    from the release of the mouse button to the facts standing in the panel
* edit of a line:        the same, where the edit changes the largest layer: a line is deleted
* hand to preview:       from a move of the pointer that draws a cut to both halves of the room on the overlay
* pick:                  CPU time of finding what lies under the pointer
"""

from __future__ import annotations

import contextlib
import math
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

for folder in ("browser", "rgviz"):
    sys.path.insert(0, str(Path(__file__).parents[1] / folder))

import numpy as np  # noqa: E402
from make_project import make_project  # noqa: E402
from office_map import big_office, huge_office  # noqa: E402
from pilot import FLAGS, READY, Pilot, chromium  # noqa: E402
from playwright.sync_api import Browser, sync_playwright  # noqa: E402

from rgcore.model.records import Region  # noqa: E402
from rgviz.app import App  # noqa: E402
from rgviz.picking import Item  # noqa: E402

NOW = "performance.timeOrigin + performance.now()"
STAMP_INPUT = f"""() => {{ for (const kind of ["keydown", "pointerup"])
  window.addEventListener(kind, () => {{ window.inputAt = {NOW}; }}, true); }}"""
WATCH_SHAPE = f"""(name) => {{ const m = window.__viserMutable, scene = m.scene, old = scene.onAfterRender;
  const shape = () => {{ let n = 0;
    m.nodeRefFromName[name]?.traverse(o => {{ n += o.geometry?.attributes.position.count || 0; }}); return n; }};
  const before = shape(); window.seenAt = null;
  scene.onAfterRender = (renderer, s, camera) => {{ old(renderer, s, camera);
    if (window.seenAt !== null || !shape() || shape() === before) return;
    const gl = renderer.getContext(), pixel = new Uint8Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);   // waits until the frame is painted
    window.seenAt = {NOW}; scene.onAfterRender = old; }}; }}"""
FIRST_PICTURE = f"""(() => {{ const wait = setInterval(() => {{ const m = window.__viserMutable;
  if (!m || !m.scene || !m.scene.userData.rgviz) return;
  clearInterval(wait);
  const old = m.scene.onAfterRender;
  m.scene.onAfterRender = (renderer, s, camera) => {{ old(renderer, s, camera);
    let drawn = 0;
    m.nodeRefFromName["/lines/lines"]?.traverse(o => {{ drawn += o.geometry?.attributes.position.count || 0; }});
    if (camera !== m.camera || !drawn || !({READY})(["/floors", "/gateways/posts"])) return;
    const gl = renderer.getContext(), pixel = new Uint8Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);   // waits until the frame is painted
    window.firstPicture = performance.now(); m.scene.onAfterRender = old; }}; }}, 5); }})()"""
WATCH_TEXT = f"""(text) => {{ window.seenAt = null;
  const check = () => {{
    if (window.seenAt === null && document.body.innerText.includes(text)) window.seenAt = {NOW}; }};
  new MutationObserver(check).observe(document.body, {{subtree: true, childList: true, characterData: true}}); }}"""


WATCH_SKETCH = f"""() => {{ const rg = window.rg, paint = rg.handlers.sketch; window.movedAt = window.sketchedAt = null;
  window.addEventListener("pointermove", () => {{ window.movedAt = {NOW}; window.sketchedAt = null; }}, true);
  rg.handlers.sketch = (m) => {{ paint(m); if ((m.strokes || []).some(k => k.fill)) window.sketchedAt = {NOW}; }}; }}"""


def main() -> None:
    asked = sys.argv[1] if len(sys.argv) > 1 else "5000"
    map_ = huge_office() if asked == "huge" else big_office(int(asked))
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


class Took(NamedTuple):
    """ms by the browsers' clock, and of CPU time of the server and of Chromium."""

    clock: float
    server: float = math.nan
    chromium: float = math.nan


def _spent() -> tuple[float, float]:
    """CPU time so far [ms] of this process, and of the Chromium that it started."""
    rows: dict[int, list[tuple[int, float]]] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            words = stat.read_text().rpartition(")")[2].split()
            ticks = (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")
            rows.setdefault(int(words[1]), []).append((int(stat.parent.name), 1000 * ticks))

    def below(process: int) -> float:
        return sum(ticks + below(child) for child, ticks in rows.get(process, []))

    return 1000 * time.process_time(), below(os.getpid())


@contextlib.contextmanager
def _costs(out: list[Took], clock: Callable[[], float]) -> Iterator[None]:
    """Note down what is done meanwhile: ``clock`` is asked at its end."""
    server, chromium = _spent()
    yield
    took, (now, there) = clock(), _spent()
    out.append(Took(took, now - server, there - chromium))


def _first_picture(chrome: Browser, url: str) -> Took:
    """Until a frame with the lines of the map was painted, by the page's own clock."""
    context = chrome.new_context(viewport={"width": 1280, "height": 800})
    page, out = context.new_page(), []  # type: ignore[var-annotated]
    page.add_init_script(FIRST_PICTURE)
    with _costs(out, lambda: float(page.evaluate("window.firstPicture"))):
        page.goto(url)
        page.wait_for_function("() => window.firstPicture", timeout=60_000)
    context.close()
    return out[0]


def _measure(app: App, pages: list[Pilot]) -> None:
    a, b = pages
    a.page.evaluate(STAMP_INPUT)
    view = min(app.views.values(), key=lambda v: v.client.client_id)
    rooms = [r for r in app.map.regions.values() if r.class_ in ("TOMA", "CC")]
    chosen = rooms[:: max(1, len(rooms) // 10)][:10]

    def latency(page: Pilot) -> float:
        return float(page.page.evaluate("window.seenAt") - a.page.evaluate("window.inputAt"))

    clicks: list[Took] = []
    edits: list[Took] = []
    lines: list[Took] = []
    frames: list[Took] = []
    for n, room in enumerate(chosen):
        x, y = room.boundary[0][0] + 2.9, (room.boundary[0][1] + room.boundary[2][1]) / 2
        a.key("Escape")
        a.see("Reduction")
        a.page.evaluate(WATCH_TEXT, "Made by")
        with _costs(clicks, lambda: latency(a)):
            a.click(x, y)
            a.page.wait_for_function("() => window.seenAt !== null")

        app.worker.post(view.select, (Item("region", room.id),))  # whatever stands that small under the pointer
        a.see("Robot box")
        a.page.wait_for_timeout(500)
        to = "CC" if room.class_ == "TOMA" else "TOMA"
        b.page.evaluate(WATCH_SHAPE, f"/floors/c{to}")
        with _costs(edits, lambda: latency(b)):
            a.key("4" if to == "CC" else "3")
            b.page.wait_for_function("() => window.seenAt !== null")

        app.worker.post(view.select, (Item("line", app.map.lines_of(room.id)[0]),))
        a.see("Residual")
        a.page.wait_for_timeout(500)
        b.page.evaluate(WATCH_SHAPE, "/lines/lines")
        with _costs(lines, lambda: latency(b)):
            a.key("Delete")
            b.page.wait_for_function("() => window.seenAt !== null")
        a.page.wait_for_timeout(500)
        if n < 3:
            began = time.perf_counter()
            with _costs(frames, lambda: (time.perf_counter() - began) * 1000):  # noqa: B023 - asked at once
                a.frames(10)
    _say("hand to preview", _previews(a, chosen))
    _say("pick", _picks(app, a))
    _say("click to inspector", clicks)
    _say("edit to other browser", edits)
    _say("edit of a line", lines)
    _say("ten frames", frames)


def _previews(a: Pilot, rooms: list[Region]) -> list[Took]:
    a.key("Escape")
    a.key("x")
    a.page.wait_for_function("() => window.rg.hand.sketch.title")
    a.page.evaluate(WATCH_SKETCH)
    out: list[Took] = []
    for room in rooms:
        (x0, y0), (x1, y1) = room.boundary[0], room.boundary[2]
        x = (x0 + x1) / 2
        a.page.mouse.move(*a.at(x, y0 + 0.1 * (y1 - y0)))
        a.page.mouse.down()
        a.page.wait_for_timeout(400)
        with _costs(out, lambda: float(a.page.evaluate("window.sketchedAt - window.movedAt"))):
            a.page.mouse.move(*a.at(x, y0 + 0.9 * (y1 - y0)))
            a.page.wait_for_function("() => window.sketchedAt !== null")
        a.key("Escape")
        a.page.mouse.up()
        a.page.wait_for_timeout(200)
    a.key("Escape")
    return out


def _picks(app: App, a: Pilot) -> list[Took]:
    picker, camera = app.picker(app.map), next(iter(app.views.values())).client.camera
    eye, out = np.asarray(camera.position, float), []
    for room in list(app.map.regions.values())[::10]:
        target = np.array([*room.box.center, 0.0])
        began = time.process_time()
        picker.at(camera, (0.5, 0.5), (eye, target - eye))
        out.append(Took(1000 * (time.process_time() - began)))
    return out


def _say(name: str, values: list[Took]) -> None:
    median, worst = statistics.median(v.clock for v in values), max(v.clock for v in values)
    cost = ""
    if not math.isnan(values[0].server):
        server, chrome = (statistics.median(v[n] for v in values) for n in (1, 2))
        cost = f"; CPU: server {server:4.0f} ms, Chromium {chrome:5.0f} ms"
    print(f"{name:<22} median {median:5.0f} ms, worst {worst:5.0f} ms of {len(values):2}{cost}", flush=True)


if __name__ == "__main__":
    main()
