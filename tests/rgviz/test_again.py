"""The form of a new run, its words and its drawings; what comes from browsers and files is never trusted."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from make_project import make_project, synthetic_run
from office_map import office_map
from test_facts import HOSTILE, Words
from test_panels import buttons_of

from rgcore.config import Config
from rgcore.errors import EditError, RgError, SettingError
from rgcore.model.edits import ClassifyRegion, RenameRegion
from rgcore.model.history import Do
from rgcore.model.outcome import LEAVE, Outcome, Remedy
from rgcore.model.project import Project
from rgcore.model.records import RGMap, replace
from rgcore.model.staged import read_staged, stage
from rgcore.scans.bags import USUAL
from rgviz.again import words
from rgviz.again.comparing import Comparison, dashed, drawings, old_walls
from rgviz.again.kinds import KIND_COLORS, by_need
from rgviz.again.logs import Log, logs_for
from rgviz.again.looking import pins
from rgviz.again.others import read_map
from rgviz.again.settings import search, settings, value_of, with_values
from rgviz.panels.runs_tab import RunsTab

MAP = office_map(4, 1, 2)


def outcome(number: int, kind: Any, reason: str = "", **more: Any) -> Outcome:
    entry = Do(number=number, at="2026-01-01T00:00:00Z", edit=RenameRegion(region="r4", name="x"))
    return Outcome(run="0001", entry=entry, title=f"edit {number}", kind=kind, reason=reason, **more)


def test_every_setting_of_a_map_is_on_offer_with_unit_and_bounds() -> None:
    assert "localize.window" not in settings()
    gap = settings()["lines.gap"]
    assert (gap.unit, gap.bounds, gap.default) == ("m", "≥ 0, ≤ 5", 0.2)
    assert all(s.reason and s.unit for s in settings().values())
    assert [s.name for s in search("lines GAP")] == ["lines.gap"]
    assert search("noise")[0].name == "extract.noise", "names before reasons"
    assert search("no such setting") == []


def test_values_are_judged_and_what_a_run_had_stays() -> None:
    base = with_values(Config(), {"lines.gap": "0.35", "adapt.on": "false"})
    assert (base.lines.gap, base.adapt.on) == (0.35, False)
    new = with_values(base, {"slam.max_range": " 12\n"})
    assert (new.lines.gap, new.slam.max_range) == (0.35, 12)
    assert value_of(base, "adapt.on") == "false"
    for name, text in (
        ("lines.gap", "-1"),
        ("lines.gap", "wide"),
        ("lines.gap", "1\n[slam]"),
        ("x.y", "1"),
        ("a", "1"),
    ):
        with pytest.raises(SettingError):
            with_values(Config(), {name: text})


def test_logs_are_the_own_then_the_named_then_those_beside(tmp_path: Path) -> None:
    for name in ("b.log", "a.clf.gz", "notes.txt", ".hidden.log", "own.log"):
        (tmp_path / name).write_text("")
    (tmp_path / "folder.log").mkdir()
    elsewhere = tmp_path / "elsewhere" / "named.csv"
    found = logs_for(tmp_path / "p.rg", (tmp_path / "own.log", USUAL), [elsewhere])
    assert [log.title for log in found] == ["own.log", "named.csv", "a.clf.gz", "b.log"]
    assert [log.own for log in found] == [True, False, False, False]
    assert logs_for(tmp_path / "gone" / "p.rg", None, []) == []


def test_the_outcome_lists_what_needs_a_person_first_with_its_remedies() -> None:
    outcomes = [
        outcome(1, "applied"),
        outcome(2, "stale", "r4 is gone", remedies=(Remedy(name="apply to r5"), Remedy(name="let it go"))),
        outcome(3, "conflict", "no", place=(1.0, 2.0), remedies=(Remedy(name="let it go"),)),
    ]
    html = words.proposal(outcomes, {1: outcomes[1].remedies[0]}, "now", ready=True, may=True)
    pressed = [(do, arg) for do, arg in buttons_of(html) if do in ("place", "choose")]
    assert pressed == [
        ("place", "0001/3"), ("choose", "0001/3 0"),
        ("place", "0001/2"), ("choose", "0001/2 plan"), ("choose", "0001/2 1"),
        ("place", "0001/1"), ("choose", "0001/1 leave"),
    ]  # fmt: skip
    assert "r4 is gone" in Words(html).text
    assert [o.entry.number for o in by_need(outcomes)] == [3, 2, 1]
    assert pins(by_need(outcomes)) == [
        {"x": 1.0, "y": 2.0, "text": "1", "color": words.theme.css(KIND_COLORS["conflict"]), "big": True}
    ]
    guest = words.proposal(outcomes, {}, "new", ready=True, may=False)
    assert {do for do, _ in buttons_of(guest)} == {"place", "which"}


def test_nothing_from_outside_is_markup() -> None:
    bad = outcome(1, "conflict", HOSTILE, remedies=(Remedy(name=HOSTILE),))
    told = [
        words.proposal([bad], {}, "now", True, True),
        words.waiting([bad], True),
        words.logs([Log(Path(HOSTILE))], 0),
        words.start(HOSTILE),
        words.mapping(HOSTILE, "", True),
        words.comparing({"run 0001": HOSTILE}, "run 0001", None, HOSTILE),
        words.found_settings(Config(), HOSTILE, {}),
    ]
    for html in told:
        assert Words(html).tags.isdisjoint({"img", "script"}), html


@pytest.fixture
def tab(tmp_path: Path) -> tuple[RunsTab, list[Any]]:
    """The tab of a browser, and what it asked for."""
    asked: list[Any] = []
    waiting = outcome(1, "applied")
    again = SimpleNamespace(
        outcomes=[waiting], logs=[Log(tmp_path / "a.log")], config=Config(),
        start=lambda *a: asked.append(a), choose=lambda *a: asked.append(a), accept=lambda: asked.append("accept"),
    )  # fmt: skip
    app = SimpleNamespace(again=again, session=None, others=SimpleNamespace(titles={"run 0001": "run 1"}))
    view = SimpleNamespace(
        app=app, client=SimpleNamespace(gui=None), guest=False, must_edit=lambda: None,
        go_to_place=lambda *a: asked.append(a), looking=SimpleNamespace(comparison=None, choose=lambda w: None),
    )  # fmt: skip
    return RunsTab(view), asked  # type: ignore[arg-type]


def test_a_browser_may_only_press_what_is_on_offer(tab: tuple[RunsTab, list[Any]]) -> None:
    t, asked = tab
    wrong = {
        "log": ("1", "-1", "../../etc/passwd", "²"), "setting": ("lines", "x.y", "localize.window"),
        "place": ("0001/2", "", "0001/1"), "choose": ("0001/1 0", "0001/1 x", "0002/1 leave"), "settle": ("0001/1 0",),
        "compare": ("run 0002", "/etc"), "difference": ("0",),
    }  # fmt: skip
    for do, args in wrong.items():
        for arg in args:
            with pytest.raises(EditError):
                t.doers[do](arg)
    assert asked == []
    t.doers["setting"]("lines.gap")
    t.doers["log"]("0")
    t.doers["start"]("")
    t.doers["choose"]("0001/1 leave")
    assert asked == [(0, {"lines.gap": "0.2"}), (t.view.app.again.outcomes[0], LEAVE)]


def other(map: RGMap) -> RGMap:
    """A room less, another class, a door less, a wall elsewhere."""
    regions = {k: v for k, v in map.regions.items() if k != "r6"}
    regions["r4"] = replace(regions["r4"], class_="CC")
    gateways = {k: v for k, v in map.gateways.items() if k != "g3"}
    moved = next(v for v in map.lines.values() if v.regions == ("r4",) and v.start[0] == v.end[0] == 4.0)
    line = replace(moved, start=(5.0, moved.start[1]), end=(5.0, moved.end[1]))
    return replace(map, regions=regions, gateways=gateways, lines={**map.lines, line.id: line})


def test_differences_are_drawn_where_they_are_and_what_is_gone_in_dashes() -> None:
    c = Comparison.of("another", MAP, other(MAP))
    drawn = drawings(c)
    assert c.counts == {"green": 1, "red": 3, "amber": 1}
    assert np.allclose(drawn["green"].ends[:, :, 0], 5.0)  # type: ignore[union-attr]
    amber = drawn["amber"].ends[..., :2].reshape(-1, 2)  # type: ignore[union-attr]
    assert np.allclose([amber.min(0), amber.max(0)], [MAP.regions["r4"].boundary[0], MAP.regions["r4"].boundary[2]])
    red = drawn["red"].ends  # type: ignore[union-attr]
    assert len(red) > 20
    assert np.hypot(*(red[:, 1] - red[:, 0])[:, :2].T).max() < 0.7
    assert len(old_walls(c)["walls"].ends) == len(MAP.lines)  # type: ignore[union-attr]
    html = words.comparing({"x": "another"}, "x", c, "")
    assert len([1 for do, _ in buttons_of(html) if do == "difference"]) == 5


def test_dashes_cover_a_stroke_from_end_to_end() -> None:
    parts = dashed(np.array([[[0.0, 0.0], [3.0, 0.0]], [[1.0, 1.0], [1.0, 1.1]]]))
    assert np.allclose(parts[0, 0], 0)
    assert np.allclose(parts[-2, 1], (3, 0))
    assert np.allclose(parts[-1], [[1, 1], [1, 1.1]])
    drawn = np.hypot(*(parts[:-1, 1] - parts[:-1, 0]).T).sum()
    assert 0.4 < drawn / 3 < 0.7


def test_maps_to_compare_with_are_projects_runs_and_files(tmp_path: Path) -> None:
    path = make_project(tmp_path / "office.rg", MAP)
    with Project.open(path) as project:
        project.do(ClassifyRegion(region="r4", class_="lab"))
        stage(path, synthetic_run(other(MAP)))
        assert read_staged(path) is not None
    for where in (path, path / "runs" / "0001"):
        map_, trajectory = read_map(where)
        assert map_.regions["r4"].class_ == "lab"
        assert trajectory is not None
    with pytest.raises(RgError):
        read_map(tmp_path)
