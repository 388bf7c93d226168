"""The browser suite: one Chromium for all tests, the real app on a free port, a fresh page a test."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, sync_playwright

sys.path.insert(0, str(Path(__file__).parents[1] / "rgviz"))

from make_project import make_project
from office_map import office_map
from pilot import FLAGS, Pilot, chromium

from rgviz.app import App


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    with sync_playwright() as p:
        b = p.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        yield b
        b.close()


@pytest.fixture
def open_page(browser: Browser) -> Iterator[Callable[..., Pilot]]:
    """Opens pages; none of them may have met a script error."""
    pilots: list[Pilot] = []

    def open_(url: str, *args: object, **kwargs: object) -> Pilot:
        pilots.append(Pilot(browser, url, *args, **kwargs))  # type: ignore[arg-type]
        return pilots[-1]

    yield open_
    errors = [e for p in pilots for e in p.errors]
    for p in pilots:
        p.close()
    assert not errors


@pytest.fixture(scope="session")
def office(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project of a small office, made once; copy it before editing."""
    return make_project(tmp_path_factory.mktemp("office") / "office.rg", office_map(4, 1, 2))


@pytest.fixture
def app(office: Path, tmp_path: Path) -> Iterator[App]:
    """The app with a copy of the small office."""
    project = tmp_path / "office.rg"
    shutil.copytree(office, project)
    a = App(port=0)
    a.open_project(project)
    yield a
    a.stop()


@pytest.fixture
def serve(tmp_path: Path, office: Path) -> Iterator[Callable[[], tuple[subprocess.Popen[str], str]]]:
    """Starts the command line on a copy of the office; gives the process and its link."""
    project = tmp_path / "office.rg"
    shutil.copytree(office, project)
    running: list[subprocess.Popen[str]] = []

    def start() -> tuple[subprocess.Popen[str], str]:
        command = [sys.executable, "-m", "rgviz.cli", "view", str(project), "--port", "0", "--no-browser"]
        root = Path(__file__).parents[2]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=root)
        running.append(process)
        assert process.stdout is not None
        for line in process.stdout:
            if found := re.search(r"http://\S+", line):
                return process, found[0]
        raise AssertionError(process.communicate()[1])

    yield start
    for process in running:
        process.kill()
        process.communicate()
