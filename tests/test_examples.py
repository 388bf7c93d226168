"""The examples run, say what they found, and write what they promise."""

from __future__ import annotations

import ast
import csv
import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
GALLERY = Path(__file__).parents[1] / "docs" / "gallery"


def run(name: str, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, EXAMPLES / name, folder], capture_output=True, text=True, timeout=240, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_map_a_log(tmp_path: Path) -> None:
    said = run("01_map_a_log.py", tmp_path)
    assert "3214 scans of 181 beams" in said
    for ending in ("json", "svg", "glb"):
        assert (tmp_path / f"office.{ending}").stat().st_size > 10_000


def test_simulate_a_building(tmp_path: Path) -> None:
    said = run("02_simulate_a_building.py", tmp_path)
    assert (tmp_path / "flat.log.gz").exists()
    assert said.count("narrow_passage at") == 2


def test_relabel_by_script(tmp_path: Path) -> None:
    said = run("03_relabel_by_script.py", tmp_path)
    assert "r1 is Entrance, class LOBBY" in said
    assert "redo would relabel r1 as LOBBY" in said
    assert "refused: there is no region r999" in said
    assert "reopened: Entrance, edited by script" in said


def test_ask_the_map(tmp_path: Path) -> None:
    said = run("04_ask_the_map.py", tmp_path)
    assert "at the start: Hallway 1 (r1, CDMA)" in said
    assert "waypoints" in said
    assert "can only be reached from" in said


def test_bag_to_nav2(tmp_path: Path) -> None:
    said = run("05_bag_to_nav2.py", tmp_path)
    assert "office.bag: 450 scans" in said
    assert "odometry is taken from the transforms" in said
    names = {p.name for p in tmp_path.iterdir()}
    assert {"office.yaml", "office.pgm", "office-keepout.yaml", "office-speed.yaml", "office.route.geojson"} <= names


def test_grid_to_3d(tmp_path: Path) -> None:
    said = run("06_grid_to_3d.py", tmp_path)
    lines, regions, gateways = (int(w) for w in said.split("\n")[0].split() if w.isdigit())
    assert lines > 100
    assert 20 <= regions <= 26
    assert 20 <= gateways <= 28
    assert "no accuracy" in said
    assert (tmp_path / "office.glb").stat().st_size > 10_000


def test_name_twenty_rooms(tmp_path: Path) -> None:
    said = run("07_name_twenty_rooms.py", tmp_path)
    assert "20 rooms named; undo would take back: name " in said
    with (tmp_path / "to_check.csv").open(newline="", encoding="utf-8") as f:
        rows = list(csv.DictReader(f))
    assert rows
    assert all(0 < float(row["doubt"]) <= 1 and row["why"] for row in rows)


def test_lay_a_plan_under_it(tmp_path: Path) -> None:
    said = run("08_lay_a_plan_under_it.py", tmp_path)
    assert "office.dxf: turned by -20.1 degrees" in said
    within = float(said.split("lies within ")[1].split(" mm")[0])
    assert within < 1
    assert (tmp_path / "plan.svg").stat().st_size > 10_000


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda p: p.stem)
def test_the_gallery_shows_an_example_as_it_is(path: Path) -> None:
    """``python docs/make_gallery.py`` writes its page anew."""
    page = (GALLERY / f"{path.stem}.md").read_text(encoding="utf-8")
    assert path.read_text(encoding="utf-8").split('"""', 2)[2].strip() in page
    assert f"({path.stem}.md)" in (GALLERY / "README.md").read_text(encoding="utf-8")
    pictures = re.findall(r"!\[[^]]*\]\(([^)]+)\)", page)
    assert pictures
    assert all((GALLERY / name).stat().st_size > 300 for name in pictures)


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda p: p.stem)
def test_an_example_is_a_gallery_page(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    title, _, story = (ast.get_docstring(ast.parse(text)) or "").partition("\n\n")
    assert title.endswith(".")
    assert "\n" not in title
    assert f"python examples/{path.name}" in story
    assert len(text.splitlines()) <= 70
