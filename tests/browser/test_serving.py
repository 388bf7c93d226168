"""Downloads, mapping under the eyes of a browser, and nothing lost when the server is killed."""

from __future__ import annotations

import io
import json
import re
import signal
import subprocess
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from pilot import Pilot
from short_log import short_log

from rgviz.app import App
from rgviz.jobs import Finished, Report

Open = Callable[..., Pilot]
ROOM = (5.5, 3.5)
ECHOES = """() => { let n = 0; window.__viserMutable.nodeRefFromName["/points/echoes"]?.traverse(
  o => { n = Math.max(n, o.geometry?.attributes.position?.count || 0); }); return n; }"""


def test_downloads_hold_the_corrected_map(app: App, open_page: Open) -> None:
    p = open_page(app.url)
    p.click(*ROOM)
    p.see("Robot box")
    p.type_into("Name", "Copy room")
    p.see("Undo: rename r4 to Copy room")
    got = p.download("JSON")
    assert got.suggested_filename == "office.json"
    document = json.loads(Path(got.path()).read_text())
    assert document["format"] == "rgmap"
    assert {r["id"]: r["name"] for r in document["regions"]}["r4"] == "Copy room"
    assert len(document["lines"]) == len(app.map.lines)
    scene = trimesh.load(io.BytesIO(Path(p.download("GLB").path()).read_bytes()), file_type="glb")
    assert np.allclose(sorted(np.ptp(scene.bounds, axis=0))[1:], [12, 19], atol=0.3)
    assert Path(p.download("SVG").path()).read_text().lstrip().startswith("<")
    rows = np.loadtxt(p.download("TUM").path())
    assert rows.shape == (len(app.opened.project.trajectory), 8)


def test_no_page_without_the_link(app: App, open_page: Open, browser: object) -> None:
    context = browser.new_context()  # type: ignore[attr-defined]
    page = context.new_page()
    answer = page.goto(app.url.split("?")[0])
    assert answer.status == 401
    assert "open the link" in page.content()
    assert page.request.get(app.url.split("/?")[0] + "/export/map.json").status == 401
    context.close()


def test_another_page_cannot_drive_the_editor(app: App, open_page: Open) -> None:
    """A page of another origin in the same browser, cookie and all, gets no websocket."""
    import http.server

    p = open_page(app.url)
    other = http.server.ThreadingHTTPServer(("127.0.0.1", 0), http.server.SimpleHTTPRequestHandler)
    other.RequestHandlerClass.log_message = lambda *_: None  # type: ignore[assignment, method-assign]
    threading.Thread(target=other.serve_forever, daemon=True).start()
    q = p.context.new_page()
    q.goto(f"http://127.0.0.1:{other.server_port}/")
    attempt = """(u) => new Promise(r => { const w = new WebSocket(u, ['viser-v1.1.1']);
      w.onopen = () => r('open'); w.onerror = () => r('refused'); })"""
    assert q.evaluate(attempt, f"ws://127.0.0.1:{app.gate.port}/") == "refused"
    assert p.page.evaluate(attempt, f"ws://127.0.0.1:{app.gate.port}/") == "open"
    assert p.page.evaluate(attempt, f"ws://127.0.0.1:{other.server_port}/") == "refused", "the page may only talk to us"
    other.shutdown()
    other.server_close()
    p.errors.clear()


def test_a_log_is_mapped_before_ones_eyes(tmp_path: Path, open_page: Open, monkeypatch: pytest.MonkeyPatch) -> None:
    log = short_log(tmp_path / "short.log", 400)
    app = App(port=0)
    reached, go_on, hear = threading.Event(), threading.Event(), app._hear_job

    def held(message: Report | Finished) -> None:
        """However fast the machine is: it waits until somebody has looked at the way of the whole log."""
        hear(message)
        if isinstance(message, Report) and message.stage == "slam" and message.done == message.total:
            reached.set()
            go_on.wait(60)

    monkeypatch.setattr(app, "_hear_job", held)
    try:
        p = open_page(app.url, nodes=())
        app.map_log(log, tmp_path / "short.rg")
        p.until(reached.is_set, timeout=90_000)
        p.wait_nodes("/growing/path", "/points/echoes")
        p.see("Finding the robot's way")
        p.see(re.compile(r"^100 %"))
        assert p.page.evaluate(ECHOES) > 1000, "the map was not seen growing"
        p.shot("mapping")
        go_on.set()
        p.see("Reduction", timeout=90_000)
        p.wait_nodes("/lines/lines", "/floors/cTOMA")
        assert (tmp_path / "short.rg" / "current").exists()
        p.page.wait_for_function("() => window.__viserSceneTree.getState()['/growing/path'] === undefined")
        p.shot("mapped")
    finally:
        go_on.set()
        app.stop()


def test_a_log_that_cannot_be_mapped_says_why_on_the_page(
    tmp_path: Path, open_page: Open, capfd: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "broken.log"
    log.write_text("this is not a laser log\n")
    app = App(port=0)
    try:
        p = open_page(app.url, nodes=())
        app.map_log(log, tmp_path / "broken.rg")
        p.see("The map could not be made", timeout=60_000)
        p.see(re.compile("broken.log"))
        p.shot("failed")
        assert not (tmp_path / "broken.rg").exists()
    finally:
        app.stop()
    told = [line for line in capfd.readouterr().err.splitlines() if line.startswith("rgviz: ")]
    assert len(told) == 1
    assert "broken.log" in told[0]


def test_an_edit_survives_kill_9_and_a_reload(
    serve: Callable[[], tuple[subprocess.Popen[str], str]], open_page: Open
) -> None:
    process, url = serve()
    p = open_page(url)
    p.click(*ROOM)
    p.see("Robot box")
    p.choose("Class", "CC")
    p.see("Undo: relabel r4 as CC")
    process.send_signal(signal.SIGKILL)
    process.wait()

    process, url = serve()
    p = open_page(url)
    p.see("Undo: relabel r4 as CC")
    p.click(*ROOM)
    p.see("Robot box")
    assert p.field("Class").input_value() == "CC"
    p.page.reload()
    p.wait_nodes("/lines/lines")
    p.button(re.compile("^Undo: relabel")).click()
    p.see("Redo: relabel r4 as CC")

    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert "Traceback" not in err
    assert process.returncode == 130


def test_a_second_server_opens_the_project_read_only(
    serve: Callable[[], tuple[subprocess.Popen[str], str]], open_page: Open
) -> None:
    first, _ = serve()
    _, url = serve()
    p = open_page(url)
    p.see("Read-only")
    p.see(f"process {first.pid}")
    p.click(*ROOM)
    p.see("Robot box")
    assert p.field("Name").count() == 0
    p.key("4")
    p.see("Not done")
    p.shot("read-only")


def test_a_download_tells_beside_it_what_the_format_could_not_carry(app: App, open_page: Open) -> None:
    p = open_page(app.url)
    p.download("DXF")
    p.see("does not hold")
    p.see("crossing-points and gateway-points")
    p.see("class scores, confidence, accuracy")
    inside = "(e) => { const r = e.getBoundingClientRect(); return r.top > 0 && r.bottom < innerHeight + 1; }"
    p.until(lambda: p.page.locator(".lost").evaluate(inside))
    p.shot("download")
    p.download("JSON")
    p.see("holds the whole map")
    p.gone("class scores, confidence")
