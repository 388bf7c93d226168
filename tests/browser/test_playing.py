"""Playing how a log is mapped, in a real browser."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from pilot import Pilot
from short_log import short_log

from rgviz.app import App

Open = Callable[..., Pilot]
SCANS = 300
ROBOT = "() => { const p = window.__viserMutable.nodeRefFromName['/play/robot']?.position; return p && [p.x, p.y]; }"


@pytest.fixture
def playing(tmp_path: Path) -> Iterator[App]:
    """The app, playing the first scans of the demo log into a new project."""
    app = App(port=0)
    app.play_log(short_log(tmp_path / "short.log", SCANS), tmp_path / "short.rg", "max")
    yield app
    app.stop()


def scrub(p: Pilot, scan: int) -> None:
    p.field("Scan").fill(str(scan))
    p.page.keyboard.press("Enter")


def robot(p: Pilot) -> np.ndarray:
    return np.array(p.page.evaluate(ROBOT))


def test_a_log_is_played_paused_scrubbed_and_becomes_a_project(playing: App, tmp_path: Path, open_page: Open) -> None:
    p = open_page(playing.url, nodes=())
    p.see(re.compile("in-[A-Z]{2,4}"), timeout=90_000)
    p.until(lambda: playing.playback.player is not None and playing.playback.player.at > 60, timeout=60_000)
    p.button("Pause").click()
    p.button("Play").wait_for()
    player = playing.playback.player
    assert player is not None
    p.until(lambda: not player.busy)
    there = player.at
    p.see(f"scan {there + 1} of {SCANS}")
    p.wait_nodes("/play/robot", "/play/echoes", "/play/way", "/points/echoes")
    p.shot("playing")
    assert np.allclose(robot(p), player.tape.pose(there)[:2], atol=1e-3)

    scrub(p, 21)
    p.see(f"scan 21 of {SCANS}")
    p.until(lambda: np.allclose(robot(p), player.tape.pose(20)[:2], atol=1e-3))
    assert np.linalg.norm(player.tape.pose(20)[:2] - player.tape.pose(there)[:2]) > 0.1
    p.shot("scrubbed")

    q = open_page(playing.url, nodes=())
    q.see(f"scan 21 of {SCANS}")
    q.wait_nodes("/play/robot")
    assert np.allclose(robot(q), robot(p), atol=1e-6), "all browsers see the same moment"
    q.page.get_by_role("button", name="+1", exact=True).click()
    p.see(f"scan 22 of {SCANS}")

    guest = open_page(playing.view_url, nodes=())
    guest.button("Play").click()
    guest.see("This link is for looking")
    assert not player.busy
    guest.page.get_by_label("Follow", exact=True).check()
    guest.until(lambda: near_middle(guest, player.tape.pose(21)))

    p.page.get_by_label("Follow", exact=True).check()
    p.until(lambda: near_middle(p, player.tape.pose(21)))
    assert not near_middle(q, player.tape.pose(21)), "each browser follows for itself"

    p.choose("Speed", "max")
    p.button("Play").click()
    p.see("Reduction", timeout=90_000)
    p.wait_nodes("/lines/lines")
    p.page.wait_for_function("() => window.__viserSceneTree.getState()['/play/robot'] === undefined")
    assert playing.session is not None
    assert len(playing.session.project.trajectory) == SCANS
    p.shot("played")

    p.button("Play the log").click()
    p.see(re.compile(f"of {SCANS}"))
    p.button("Back to the map").click()
    p.see("Reduction")


def near_middle(p: Pilot, pose: np.ndarray) -> bool:
    left, top, right, bottom = p.canvas_box()
    x, y = p.at(pose[0], pose[1])
    return abs(x - (left + right) / 2) < 30 and abs(y - (top + bottom) / 2) < 30


def test_the_log_of_a_project_that_is_not_there_is_asked_for(app: App, open_page: Open) -> None:
    p = open_page(app.url)
    p.see("rgviz play LOG -o office.rg")
    assert not p.button("Play the log").is_visible()
