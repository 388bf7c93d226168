"""Playing how a log is mapped, without a browser: the tape, the player as time goes by, the child on its leash."""

from __future__ import annotations

import os
import queue
import time
import typing
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from short_log import short_log

from rgcore.config import Config
from rgcore.errors import ProjectError
from rgcore.model.project import Project
from rgcore.online import RegionSoFar, Step
from rgcore.places import automaton as told
from rgcore.scans.read import read_log
from rgviz.app import App
from rgviz.jobs import Finished, Report
from rgviz.mapping import map_into
from rgviz.play.child import Mapped, Opening, Picture, PlayJob, centimetres, thinned
from rgviz.play.player import REPLAY, SPEEDS, Player
from rgviz.play.source import find_log
from rgviz.play.stage import map_so_far
from rgviz.play.tape import LONGEST, MOST_PICTURES, NOMINAL, Tape, clock, timeline, words

RATE = 5.0
PRESSES = ["play", "pause", "seek", "step", "tick", "map", "speed"]
SQUARE = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))


def tape(total: int = 100, mapped: int = 0) -> Tape:
    bearings = np.radians(np.arange(-90.0, 91.0))
    out = Tape(Opening("a.log", np.arange(total) / RATE, bearings, np.array([0.1, 0.0, 0.0])))
    feed(out, mapped)
    return out


def feed(tape: Tape, until: int) -> None:
    """Map on until so many scans are: the robot drives along x, 0.1 m a scan, a wall 2 m ahead of its laser."""
    first = len(tape)
    steps = tuple(
        Step(scan=k, stamp=k / RATE, pose=(0.1 * k, 0.0, 0.0), state="in-TOMA", region=f"r{1 + k // 50}")
        for k in range(first, until)
    )
    ranges = np.full((len(steps), 181), 65535, np.uint16)
    ranges[:, 90] = 200
    tape.add(Mapped(first, steps, ranges))


def picture(scan: int, regions: tuple[RegionSoFar, ...] | None = ()) -> Picture:
    points = np.zeros((0, 2), np.float32)
    return Picture(scan, scan, points, points, regions, None if regions is None else ())


# ---- the time of a log ----------------------------------------------------------------------------


def test_stamps_are_the_pace() -> None:
    times, note = timeline(np.array([1e9, 1e9 + 0.2, 1e9 + 0.7]))
    assert np.allclose(times, [0, 0.2, 0.7])
    assert note == ""


def test_stamps_that_tell_nothing_give_a_usual_pace_and_a_word() -> None:
    times, note = timeline(np.zeros(4))
    assert np.allclose(times, NOMINAL * np.arange(4))
    assert "3 stamps" in note
    times, note = timeline(np.array([0, 0.2, 0.4, 0.1, 0.3, np.nan, 0.7]))
    assert np.allclose(np.diff(times)[[0, 1, 3]], 0.2)
    assert (np.diff(times) > 0).all()
    assert "backwards" in note


def test_a_break_is_not_waited_for() -> None:
    times, note = timeline(np.array([0.0, 0.2, 0.4, 3600.0, 3600.2]))
    assert np.isclose(times[-1], 0.6 + LONGEST)
    assert "1 breaks" in note
    assert len(timeline(np.zeros(1))[0]) == 1


# ---- the tape ---------------------------------------------------------------------------------------


def test_the_tape_gives_back_what_was_told() -> None:
    t = tape(100, 80)
    assert len(t) == 80
    assert np.allclose(t.pose(30), [3.0, 0, 0])
    assert t.place(30) == ("in-TOMA", "r1")
    assert t.place(79) == ("in-TOMA", "r2")
    assert np.allclose(t.echoes(30), [[5.1, 0.0]])
    assert np.allclose(t.way(70, 72)[:, 0], [7.0, 7.1, 7.2])


def test_pictures_are_thinned_not_forgotten_and_share_what_is_equal() -> None:
    t = tape(20_000, 1)
    one = RegionSoFar(id="r1", boundary=SQUARE, class_=None, visited=True)
    for scan in range(0, 20_000, 10):
        again = RegionSoFar(id="r1", boundary=tuple(SQUARE), class_=None, visited=True)
        t.draw(picture(scan, (one,) if scan == 0 else (again,) if scan % 20 else None))
        assert len(t.pictures) <= 1.1 * MOST_PICTURES
    assert t.pictures[0].scan == 0
    assert t.pictures[-1].scan == 19_990
    assert np.diff([p.scan for p in t.pictures]).max() < 20_000 / 50
    assert all(p.regions is not None and p.regions[0] is one for p in t.pictures)
    found = t.picture(5000)
    assert found is not None
    assert found.scan <= 5000
    assert tape(10).picture(5) is None


def test_events_are_those_until_then() -> None:
    t = tape(100, 0)
    at: dict[str, Any] = {"stamp": 0.0, "pose": (0.0, 0.0, 0.0)}
    events = {
        3: (told.RegionFound(scan=3, region="r1", **at),),
        9: (told.RegionLeft(scan=9, region="r1", **at), told.RegionFound(scan=9, region="r2", **at)),
    }
    steps = tuple(Step(scan=k, state="in-CC", events=events.get(k, ()), **at) for k in range(20))
    t.add(Mapped(0, steps, np.zeros((20, 181), np.uint16)))
    assert [words(e) for e in t.last_events(19, 5)] == ["found region r2", "found region r1"]
    assert [words(e) for e in t.last_events(8, 5)] == ["found region r1"]
    assert t.last_events(2, 5) == []


def test_every_event_has_words() -> None:
    values = {"scan": 1, "stamp": 0.0, "pose": (0.0, 0.0, 0.0), "region": "r1", "into": "r2", "gateway": "g1"}
    values |= {"known": False, "class_": "CC", "score": 0.7, "scans": 12, "distance": 0.25}
    said = set()
    for kind in typing.get_args(told.AnyEvent):
        said.add(words(kind(**{k: v for k, v in values.items() if k in kind.__struct_fields__})))
    assert len(said) == len(typing.get_args(told.AnyEvent))
    assert "closed a loop: 12 poses moved by up to 0.25 m" in said
    assert "entered gateway g1, which is new" in said


def test_time_is_told_in_minutes_and_hours() -> None:
    assert [clock(s) for s in (0, 62.9, 3600, 7384)] == ["0:00", "1:02", "1:00:00", "2:03:04"]


def test_the_map_so_far_is_a_map() -> None:
    region = RegionSoFar(id="r1", boundary=SQUARE, class_="CC", visited=True)
    m = map_so_far(picture(5, (region,)), {"r1": "Lab"})
    assert m.regions["r1"].name == "Lab"
    assert m.regions["r1"].box.center == (2.0, 2.0)
    assert m.regions["r1"].boundary is region.boundary


# ---- the player ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("speed", "factor"), [("1x", 1.0), ("4x", 4.0)])
def test_it_plays_at_the_pace_of_the_log(speed: Any, factor: float) -> None:
    p = Player(tape(200, 200), speed, playing=True)
    for _ in range(40):
        p.tick(0.05)
    assert p.at == pytest.approx(2.0 * factor * RATE, abs=1)


def test_what_is_wanted_is_a_little_ahead() -> None:
    p = Player(tape(200), "4x", playing=True)
    assert 4 * 0.5 * RATE <= p.wanted <= 4 * 0.5 * RATE + 2
    p.speed = "max"
    assert p.wanted == 200
    p.pause()
    assert p.wanted == 0


def test_time_waits_for_the_mapping() -> None:
    p = Player(tape(200, 10), "1x", playing=True)
    for _ in range(100):
        p.tick(0.2)
    assert p.at == 9
    feed(p.tape, 200)
    p.tick(0.2)
    assert p.at == 10, "no leap to catch up with the clock"


def test_max_shows_each_moment_that_comes() -> None:
    p = Player(tape(200, 10), "max", playing=True)
    p.tick(0.01)
    assert p.at == 9
    feed(p.tape, 150)
    p.tick(0.01)
    assert p.at == 149


def test_max_runs_through_the_past_at_a_pace_that_can_be_watched() -> None:
    p = Player(tape(2000, 1500), "max", playing=True)
    p.seek(100)
    p.tick(0.2)
    assert p.at == 100 + REPLAY * 0.2


def test_scrubbing_back_is_instant_and_ahead_maps_up_to_there() -> None:
    p = Player(tape(200, 100), "1x", playing=False)
    p.seek(40)
    assert p.at == 40
    assert not p.busy
    assert p.wanted == 100, "nothing to map for that"
    p.seek(150)
    assert p.busy
    assert p.wanted == 151
    feed(p.tape, 130)
    p.tick(0.1)
    assert p.at == 129
    feed(p.tape, 170)
    p.tick(0.1)
    assert p.at == 150
    assert not p.busy
    p.seek(-5)
    assert p.at == 0
    p.seek(10_000)
    assert p.goal == 199


def test_pause_step_and_play_again_at_the_end() -> None:
    p = Player(tape(50, 50), "max", playing=True)
    p.tick(0.1)
    assert p.ended
    assert not p.playing
    p.step(-10)
    assert p.at == 39
    p.step(1)
    assert p.at == 40
    p.seek(49)
    p.play()
    assert p.at == 0
    assert p.playing
    p.pause()
    assert not p.tick(1.0)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from(["play", "pause", "seek", "step", "tick", "map", "speed"]), st.integers(-9, 70)))
)
def test_whatever_is_pressed_a_mapped_scan_is_on_show(presses: list[tuple[str, int]]) -> None:
    p = Player(tape(60), "4x", playing=True)
    for press, n in presses:
        if press == "map":
            feed(p.tape, max(len(p.tape), min(n, p.wanted)))
        elif press == "speed":
            p.speed = SPEEDS[n % 3]
        elif press in ("seek", "step"):
            getattr(p, press)(n)
        elif press == "tick":
            p.tick(abs(n) / 10)
        else:
            getattr(p, press)()
        assert -1 <= p.at < max(len(p.tape), 1)
        assert len(p.tape) <= p.wanted <= 60
        assert p.goal is None or p.at < p.goal < 60
    for _ in range(200):  # left alone, it comes to rest, or plays to the end
        p.tick(1.0)
        feed(p.tape, p.wanted)
    assert not p.busy


# ---- the child ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return short_log(tmp_path_factory.mktemp("log") / "short.log", 60)


def hear(heard: queue.Queue[Any], until: Any) -> list[Any]:
    """All messages up to one for which ``until`` holds."""
    out = [heard.get(timeout=120)]
    while not until(out[-1]):
        assert not isinstance(out[-1], Finished), out[-1]
        out.append(heard.get(timeout=120))
    return out


def test_the_child_maps_as_far_as_it_may_and_makes_the_project_at_the_end(log: Path, tmp_path: Path) -> None:
    heard: queue.Queue[Any] = queue.Queue()
    job = PlayJob(log, tmp_path / "short.rg", Config(), heard.put)
    try:
        opening = hear(heard, lambda m: isinstance(m, Opening))[-1]
        t = Tape(opening)
        assert t.total == 60
        job.allow(25)
        for m in hear(heard, lambda m: isinstance(m, Picture) and m.scan == 24):
            t.draw(m) if isinstance(m, Picture) else t.add(m)
        assert len(t) == 25
        assert not (tmp_path / "short.rg").exists()
        job.allow(60)
        for m in hear(heard, lambda m: isinstance(m, Picture) and m.scan == 59):
            t.draw(m) if isinstance(m, Picture) else t.add(m)
        rest = hear(heard, lambda m: isinstance(m, Finished))
        assert rest[-1].error is None
        assert {"lines", "save"} <= {m.stage for m in rest if isinstance(m, Report)}
    finally:
        job.cancel()
    scans = read_log(log)
    seen = t.echoes(59)
    assert len(seen) == (centimetres(scans, slice(59, 60)) != 65535).sum()
    with Project.open(tmp_path / "short.rg") as project:
        end = project.trajectory.map_from_base[-1]
        assert np.linalg.norm(end[:2] - t.pose(59)[:2]) < 0.2
        assert not project.read_only
        source, _ = find_log(project, None)
        assert source is None, "its log lies elsewhere"
        (tmp_path / "short.log").write_bytes(log.read_bytes())
        source, _ = find_log(project, None)
        assert source is not None
        assert source.sha256 == project.run_info.sha256


def test_leaving_half_way_leaves_nothing(log: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    heard: queue.Queue[Any] = queue.Queue()
    job = PlayJob(log, tmp_path / "short.rg", Config(), heard.put)
    job.allow(20)
    hear(heard, lambda m: isinstance(m, Picture))
    pid = job._child.pid
    assert pid is not None
    job.cancel()
    assert not (tmp_path / "short.rg").exists()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    job.allow(30)  # nobody hears it
    assert capfd.readouterr().err == ""


def test_another_log_than_the_projects_is_refused(log: Path) -> None:
    heard: queue.Queue[Any] = queue.Queue()
    PlayJob(log, None, Config(), heard.put, sha256="0" * 64)
    while not isinstance(message := heard.get(timeout=120), Finished):
        pass
    assert message.error is not None
    assert "not the log that the project was made from" in message.error
    assert "\n" not in message.error


# ---- in the app, without a browser ----------------------------------------------------------------------


@pytest.fixture
def app() -> Iterator[App]:
    a = App(port=0)
    yield a
    a.stop()


def until(true: Callable[[], object]) -> None:
    end = time.monotonic() + 120
    while not true():
        assert time.monotonic() < end, "it never came to pass"
        time.sleep(0.02)


def at(app: App) -> int:
    return -1 if app.playback.player is None else app.playback.player.at


def test_the_log_of_an_open_project_is_watched_and_left_again(log: Path, tmp_path: Path, app: App) -> None:
    path = tmp_path / "short.rg"
    map_into(path, read_log(log), Config()).close()
    with pytest.raises(ProjectError, match=r"rgviz play LOG -o short\.rg"):
        app.play_log(None, path, "max")
    assert app.session is not None
    app.session.project.close()
    (tmp_path / "short.log").write_bytes(log.read_bytes())
    app.play_log(None, path, "max")
    until(lambda: at(app) == 59)
    assert app.session is None
    assert app.read_only
    assert len(app.map.lines) == 0
    with pytest.raises(ProjectError, match="go back to the map"):
        _ = app.opened
    app.worker.post(app.playback.seek, 10)
    until(lambda: at(app) == 10)
    app.worker.post(app.playback.leave)
    until(lambda: app.session is not None)
    assert len(app.map.lines) > 5
    assert not app.read_only
    app.worker.post(app.playback.start)
    until(lambda: app.playback.on and app.playback.player.ended)  # type: ignore[union-attr]
    assert app.playback._job is None, "the tape is shown again, nothing is mapped"


def test_a_log_that_is_being_mapped_can_be_played_instead(log: Path, tmp_path: Path, app: App) -> None:
    app.map_log(log, tmp_path / "short.rg")
    app.playback.speed = "max"
    app.worker.post(app.playback.start)
    until(lambda: app.session is not None)
    assert at(app) == 59, "it was played to the end, then its project opened"
    assert app.session is not None
    assert app.session.project.map.lines


def test_a_log_that_cannot_be_read_is_told_and_leaves_nothing(
    tmp_path: Path, app: App, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bad.log").write_text("not a log\n")
    app.play_log(tmp_path / "bad.log", tmp_path / "bad.rg", "4x")
    until(lambda: app.failure)
    assert "bad.log" in str(app.failure)
    assert not (tmp_path / "bad.rg").exists()
    assert len(capfd.readouterr().err.splitlines()) == 1


@given(st.integers(0, 5000), st.integers(1, 500))
def test_thinning_keeps_within_bounds_and_most_of_what_was_kept(n: int, most: int) -> None:
    points = np.column_stack([np.arange(n), np.arange(n)])
    kept = thinned(points, most)
    assert len(kept) <= most
    assert len(kept) >= min(n, most // 2)
    assert set(kept[:, 0]) <= set(thinned(points[: max(n // 2, 1)], most)[:, 0]) | set(range(n // 2, n))
