"""Mapping again under the eyes of browsers: the outcome, remedies, the other map, what is different, nothing lost."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from make_project import synthetic_run
from pilot import Pilot
from short_log import short_log

from rgcore.config import Config
from rgcore.model.edits import ClassifyRegion, DeleteGateway, MarkClutter, RenameRegion
from rgcore.model.project import Project
from rgcore.model.records import RGMap, replace
from rgcore.model.staged import read_staged, stage
from rgcore.scans.read import read_log
from rgviz import theme
from rgviz.app import App
from rgviz.mapping import map_into

Open = Callable[..., Pilot]


def tab(p: Pilot, name: str) -> None:
    p.page.locator(f'.tabs button[data-arg="{name}"]').click()
    p.page.locator(f'.tabs button.on[data-arg="{name}"]').wait_for()


def press(p: Pilot, do: str, arg: str = "") -> None:
    p.page.locator(f'button[data-do="{do}"][data-arg="{arg}"]').first.click()


def colored(p: Pilot, color: theme.RGB) -> int:
    """Pixels of the picture that have a colour."""
    p.frames(4)
    return int((np.abs(p.picture().astype(int) - color).max(2) < 12).sum())


def other_map(map: RGMap) -> RGMap:
    """What another run finds: r10 is two rooms, r6 a part of the hall, the wall of r4 stands elsewhere, g5 is gone."""
    r10 = map.regions["r10"]
    (x0, y0), (x1, _), (_, y1), _ = r10.boundary
    middle = (x0 + x1) / 2 + 0.1
    half = replace(r10, boundary=((x0, y0), (middle, y0), (middle, y1), (x0, y1)))
    rest = replace(r10, id="r11", name="r11", boundary=((middle, y0), (x1, y0), (x1, y1), (middle, y1)))
    regions = {k: v for k, v in map.regions.items() if k != "r6"} | {"r10": half, "r11": rest}
    moved = {k: replace(v, start=(v.start[0] - 0.25, v.start[1]), end=(v.end[0] - 0.25, v.end[1]))
             for k, v in map.lines.items() if v.regions == ("r4",) and v.start[0] == v.end[0] == 7.8}  # fmt: skip
    assert moved
    gateways = {k: v for k, v in map.gateways.items() if k != "g5" and "r6" not in v.regions}
    return replace(map, regions=regions, lines={**map.lines, **moved}, gateways=gateways)


EDITS = (
    RenameRegion(region="r4", name="Lab"),
    ClassifyRegion(region="r10", class_="store"),
    RenameRegion(region="r6", name="Archive"),
    DeleteGateway(gateway="g2"),
)


def prepare(path: Path) -> None:
    """Edits on the office, and a new run that waits."""
    with Project.open(path) as project:
        for edit in EDITS:
            project.do(edit, by="ann")
        project.do(RenameRegion(region="r3", name="Kitchen"), by="ann")
        project.undo(by="ann")
        stage(path, synthetic_run(other_map(project.base)))


@pytest.fixture
def waiting(office: Path, tmp_path: Path) -> Path:
    shutil.copytree(office, tmp_path / "office.rg")
    prepare(tmp_path / "office.rg")
    return tmp_path / "office.rg"


@pytest.fixture
def app_of() -> Iterator[Callable[[Path], App]]:
    apps: list[App] = []

    def open_(project: Path) -> App:
        apps.append(App(port=0))
        apps[-1].open_project(project)
        return apps[-1]

    yield open_
    for app in apps:
        app.stop()


def test_the_outcome_is_looked_at_decided_and_accepted(
    waiting: Path, app_of: Callable[[Path], App], open_page: Open
) -> None:
    app = app_of(waiting)
    p, q = open_page(app.url), open_page(app.url)
    p.see("A new run waits to be looked at.")
    p.key("Shift+N")
    p.see("Accept the new run")
    p.see(re.compile("^r6 has no clear counterpart"))
    tab(q, "Runs")
    q.see("relabel r10 as store")
    p.shot("outcome")

    press(p, "place", "0001/2")
    p.frames(3)
    left, top, right, bottom = p.canvas_box()
    x, y = p.at(*app.again.outcomes[1].place)  # type: ignore[misc]
    assert abs(x - (left + right) / 2) < 40, "the camera did not go to the edit"
    assert abs(y - (top + bottom) / 2) < 60
    p.key("f")

    press(p, "choose", "0001/2 0")
    q.page.locator('button.on[data-do="choose"][data-arg="0001/2 plan"]').wait_for()
    app.worker.post(app.opened.do, RenameRegion(region="r5", name="Made meanwhile"))
    q.see("rename r5 to Made meanwhile")
    p.page.locator('button.on[data-do="choose"][data-arg="0001/2 plan"]').wait_for()

    press(p, "accept")
    q.see("Run 2")
    q.gone("A new run waits to be looked at.")
    q.see("rename r6 to Archive")
    project = app.opened.project
    assert [o.title for o in project.conflicts] == ["rename r6 to Archive"]
    assert project.map.regions["r5"].name == "Made meanwhile"
    assert "g2" not in project.map.gateways
    p.see(re.compile("^Undo: relabel r10 as store: "))
    p.shot("accepted")
    press(q, "settle", "0001/3 0")
    p.see("Undo: rename r6 to Archive: let it go")
    p.gone("Edits that wait")
    assert not project.conflicts
    app.stop()

    again = app_of(waiting)
    r = open_page(again.url)
    r.see("Undo: rename r6 to Archive: let it go")
    for _ in range(3):
        r.key("Control+z")
    r.see(re.compile("^Redo: rename r5 to Made meanwhile"))
    tab(r, "Runs")
    r.see("rename r6 to Archive")
    tab(r, "History")
    r.see("rename r4 to Lab")
    r.shot("after-restart")


def test_the_new_map_is_looked_at_by_one_and_edited_by_another(
    waiting: Path, app_of: Callable[[Path], App], open_page: Open
) -> None:
    app = app_of(waiting)
    p, q = open_page(app.url), open_page(app.url)
    tab(p, "Runs")
    p.see("Accept the new run")
    p.key("Shift+J")
    p.wait_nodes("/new/lines/lines")
    assert not p.visible("/lines/lines")
    assert q.visible("/lines/lines")
    p.click(15.2, 9.5)
    p.see("r11")
    assert p.field("Name").count() == 0, "the new run is for looking"
    p.key("4")
    p.see("Not done")
    q.click(5.5, 3.5)
    q.see("Robot box")
    q.key("4")
    q.see("Undo: relabel r4 as CC")
    press(p, "which", "both")
    p.wait_nodes("/was/walls")
    assert colored(p, theme.WAS) > 50, "the wall that stood elsewhere does not show"
    p.shot("both")
    p.key("Shift+J")
    p.page.wait_for_function("() => window.__viserSceneTree.getState()['/new/lines/lines'] === undefined")
    assert p.visible("/lines/lines")
    press(q, "tab", "Runs")
    q.see("Discard it")
    press(q, "discard")
    p.gone("A new run waits to be looked at.")
    assert read_staged(waiting) is None
    assert app.opened.project.run_name == "0001"
    assert app.map.regions["r4"].class_ == "CC"


def test_what_is_different_has_colours_a_legend_and_a_list(
    waiting: Path, app_of: Callable[[Path], App], open_page: Open
) -> None:
    app = app_of(waiting)
    p = open_page(app.url)
    tab(p, "Runs")
    p.see("Accept the new run")
    p.key("Shift+J")
    p.key("Shift+K")
    p.wait_nodes("/changes/red", "/changes/amber")
    assert colored(p, theme.REMOVED) > 100
    assert colored(p, theme.CHANGED) > 100
    p.see(re.compile("split r10"))
    p.shot("changes")
    row = p.page.locator('button[data-do="difference"]', has_text="closed g5")
    row.click()
    p.frames(3)
    p.key("Shift+K")
    p.page.wait_for_function("() => window.__viserSceneTree.getState()['/changes/red'] === undefined")
    press(p, "accept")
    p.see("Run 2")
    press(p, "compare", "run 0001")
    p.wait_nodes("/changes/red")
    p.see(re.compile("split r10"))
    p.shot("changes-after")


def test_a_guest_sees_it_and_decides_nothing(waiting: Path, app_of: Callable[[Path], App], open_page: Open) -> None:
    app = app_of(waiting)
    p = open_page(app.view_url)
    tab(p, "Runs")
    p.see("relabel r10 as store")
    assert p.page.locator('button[data-do="accept"], button[data-do="start"], button[data-do="choose"]').count() == 0
    for do, arg in (("accept", ""), ("discard", ""), ("start", ""), ("choose", "0001/2 0"), ("settle", "0001/2 0")):
        p.page.evaluate("([d, a]) => window.rg.send({type: 'press', do: d, arg: a})", [do, arg])
    p.see("Not done")
    p.page.wait_for_timeout(300)
    app.worker.wait()
    assert (app.opened.project.run_name, app.again.job) == ("0001", None)
    assert not app.again.chosen
    assert read_staged(waiting) is not None
    press(p, "which", "new")
    p.wait_nodes("/new/lines/lines")


def test_a_log_is_mapped_again_while_the_map_is_edited(
    tmp_path: Path, app_of: Callable[[Path], App], open_page: Open
) -> None:
    log = short_log(tmp_path / "short.log", 150)
    map_into(tmp_path / "short.rg", read_log(log), Config()).close()
    app = app_of(tmp_path / "short.rg")
    region, line = next(iter(app.map.regions)), max(app.map.lines.values(), key=lambda v: v.support)
    p, q = open_page(app.url), open_page(app.url)
    p.key("Shift+N")
    p.see("the log of this map")
    p.type_into("Find a setting", "lines distance")
    press(p, "setting", "lines.distance")
    p.type_into("lines distance [m]", "-3")
    p.see("Not done")
    p.type_into("lines distance [m]", "0.06")
    p.shot("again-form")
    press(p, "start")
    q.see(re.compile("^Mapping again"))
    press(p, "cancel")
    q.gone("Mapping again:")
    assert read_staged(tmp_path / "short.rg") is None
    press(p, "start")
    q.see(re.compile("^Mapping again"))
    app.worker.post(app.opened.do, RenameRegion(region=region, name="Made meanwhile"))
    app.worker.post(app.opened.do, MarkClutter(lines=(line.id,)))
    p.see("Accept the new run", timeout=180_000)
    q.see("A new run waits to be looked at.")
    app.worker.wait()
    press(p, "accept")
    q.see(re.compile("Undo: "))
    p.see("Run 2")
    p.see("lines.distance = 0.06")
    assert app.map.regions[region].name == "Made meanwhile"


def test_killed_while_a_new_run_waits_it_waits_on(
    serve: Callable[[], tuple[subprocess.Popen[str], str]], tmp_path: Path, open_page: Open
) -> None:
    """``serve`` opens office.rg of this folder."""
    prepare(tmp_path / "office.rg")
    process, url = serve()
    p = open_page(url)
    p.key("Shift+N")
    p.see("relabel r10 as store")
    p.click(5.5, 3.5)
    p.see("Robot box")
    p.key("4")
    p.see("Undo: relabel r4 as CC")
    process.send_signal(signal.SIGKILL)
    process.wait()
    process, url = serve()
    q = open_page(url)
    q.see("Undo: relabel r4 as CC")
    q.key("Shift+N")
    q.see("Accept the new run")
    q.see("relabel r4 as CC")
    press(q, "accept")
    q.see("Run 2")
    q.see("Undo: relabel r4 as CC")
