"""The report of a map: parsed as a browser would, its numbers those of `rgviz measure`, nothing fetched."""

from __future__ import annotations

import shutil
from concurrent.futures import ThreadPoolExecutor
from html.parser import HTMLParser
from pathlib import Path

import pytest

from rgcore.config import Config
from rgcore.exports.report import ENOUGH, fits, report
from rgcore.model.edits import RenameRegion
from rgcore.model.project import Project
from rgcore.scans.read import read_log
from rgviz.cli import main
from rgviz.demo import LOG
from rgviz.mapping import map_into
from rgviz.measure import figures

NASTY = '<script>alert(1)</script> & "Büro"'
VOID = {"meta", "link", "img", "br", "hr", "input"}


class Page(HTMLParser):
    """Tables by id as rows of cells, and whatever could make a browser fetch something; unbalanced tags fail."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tables: dict[str, list[list[str]]] = {}
        self.addresses: list[str] = []
        self.scripts = 0
        self._open: list[str] = []
        self._table: list[list[str]] = []
        self.feed(text)
        assert not self._open, self._open

    def handle_starttag(self, tag, attrs):
        self.addresses += [v for k, v in attrs if k in ("src", "href", "srcset", "xlink:href", "action", "data")]
        self.scripts += tag == "script"
        if tag == "table":
            self._table = self.tables[dict(attrs)["id"]] = []
        elif tag == "tr":
            self._table.append([])
        elif tag in ("td", "th"):
            self._table[-1].append("")
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.addresses += [v for k, v in attrs if k in ("src", "href", "xlink:href")]

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def handle_data(self, data):
        if self._open and self._open[-1] in ("td", "th"):
            self._table[-1][-1] += data


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    with map_into(tmp_path_factory.mktemp("report") / "office.rg", read_log(LOG)[:600], Config()) as p:
        p.do(RenameRegion(region=next(iter(p.map.regions)), name=NASTY))
        yield p


@pytest.fixture(scope="module")
def text(project):
    return report(project)


def test_numbers_are_those_of_measure(project, text):
    table = Page(text).tables["table1"]
    f = figures(project)
    building = table[1]
    assert building[1:5] == [*map(str, (f["scans"], f["points"], f["segments"], f["lines"]))]
    assert float(building[5]) == pytest.approx(f["reduction"], abs=0.06)
    assert building[-1] == f"{1000 * f['accuracy']:.0f} mm"
    rows = {row[0]: row for row in table[2:]}
    assert len(rows) == len(f["regions"])
    for r in f["regions"]:
        row = rows[f"{r['name']} ({r['id']})"]
        assert (row[1], row[4], row[6]) == (str(r["scans"]), str(r["lines"]), r["class"])
        assert row[-1] == ("-" if r["accuracy"] is None else f"{1000 * r['accuracy']:.0f} mm")


def test_readings_and_segments_of_regions_are_parts_of_the_whole(text):
    table = Page(text).tables["table1"]
    for column in (1, 2, 3):
        assert 0 < sum(int(row[column]) for row in table[2:]) <= int(table[1][column])


def test_shares_are_shares_and_most_readings_are_told(text):
    for row in Page(text).tables["accuracy"][1:]:
        within_5, within_10, missed = (float(c.rstrip(" %")) if c != "-" else 0.0 for c in row[4:])
        assert 0 <= within_5 <= within_10 <= 100 - missed + 0.11
    building = Page(text).tables["accuracy"][1]
    assert float(building[5].rstrip(" %")) > 90


def test_names_of_people_are_text_and_nothing_is_fetched(text):
    page = Page(text)
    assert NASTY in " ".join(row[0] for row in page.tables["table1"])
    assert page.scripts == 0
    assert all(a.startswith("data:") for a in page.addresses)
    assert "url(" not in text
    assert "@import" not in text


def test_settings_and_version_are_told(project, text):
    making = {row[0]: row[1] for row in Page(text).tables["making"]}
    assert making["software"] == project.run_info.software
    assert making["settings"] == "the defaults"


def test_an_old_run_says_what_is_missing(project, tmp_path):
    old = tmp_path / "old.rg"
    shutil.copytree(project.path, old)
    for name in ("segments.npz", "adapt.json"):
        (old / "runs/0001" / name).unlink()
    with Project.open(old) as p:
        assert p.adaptation is None
        text = report(p)
    assert "map the log again" in text
    assert "adapted" not in Page(text).tables


def test_command_writes_the_page_or_says_why_not(project, tmp_path, capsys):
    copy = tmp_path / "copy.rg"
    shutil.copytree(project.path, copy)
    out = tmp_path / "page.html"
    assert main(["report", str(copy), "-o", str(out)]) == 0
    assert Page(out.read_text(encoding="utf-8")).tables["table1"]
    capsys.readouterr()
    for args in ([str(tmp_path / "none.rg")], [str(copy), "-o", str(tmp_path / "no/such/page.html")]):
        assert main(["report", *args]) == 1
        error = capsys.readouterr().err
        assert error.startswith("rgviz: ")
        assert error.count("\n") == 1


def test_opens_in_a_browser_without_a_request_to_elsewhere(text, tmp_path):
    sync_api = pytest.importorskip("playwright.sync_api")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("no Chromium here")
    file: Path = tmp_path / "page.html"
    file.write_text(text, encoding="utf-8")
    asked, errors = [], []

    def look():
        with sync_api.sync_playwright() as p:
            browser = p.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
            page = browser.new_page(viewport={"width": 1100, "height": 900})
            page.on("request", lambda r: asked.append(r.url))
            page.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
            page.goto(file.as_uri())
            seen = page.locator("svg").count(), page.evaluate("document.documentElement.scrollWidth")
            browser.close()
            return seen

    with ThreadPoolExecutor(1) as aside:  # the browser suite keeps a Playwright of its own on this thread
        drawings, wide = aside.submit(look).result()
    assert [a for a in asked if not a.startswith(("file:", "data:"))] == []
    assert errors == []
    assert drawings >= 4
    assert wide <= 1100


def test_what_is_measured_is_honest_about_too_few_scans(project):
    whole, own = fits(project)
    assert whole is not None
    assert 0 <= whole.within_5 <= whole.within_10 <= 1 - whole.missed + 1e-9
    assert whole.median < 0.05
    scans = {r.id: r.scans for r in project.map.regions.values()}
    assert any(f is not None for f in own.values())
    assert all(own[k] is None for k, n in scans.items() if n < ENOUGH)
    f = figures(project)
    assert f["fit"]["within_10_cm"] == pytest.approx(whole.within_10, abs=1e-4)
    assert [r["fit"] is None for r in f["regions"]] == [own[r["id"]] is None for r in f["regions"]]
