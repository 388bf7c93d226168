"""The command line, run as a user runs it."""

from __future__ import annotations

import gzip
import json
import os
import shutil
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from rgcore.model.project import Project
from rgviz import cli
from rgviz.cli import making
from rgviz.demo import LOG, PLAN

sys.path.append(str(Path(__file__).parent / "scans"))

import make_plans


def rgviz(*args: object, cwd: Path | None = None, stdin: str | None = None) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "rgviz.cli", *map(str, args)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, input=stdin, timeout=240)


@pytest.fixture(scope="module")
def short_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The first scans of the demo log, plain text."""
    path = tmp_path_factory.mktemp("logs") / "short.log"
    lines = gzip.decompress(LOG.read_bytes()).decode().splitlines(keepends=True)
    path.write_text("".join(lines[:420]), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def project(short_log: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("projects") / "short.rg"
    done = rgviz("run", short_log, "-o", path)
    assert done.returncode == 0, done.stderr
    assert "regions" in done.stdout
    return path


def test_help_answers_in_under_0_3_s() -> None:
    took = []
    for _ in range(5):
        began = time.perf_counter()
        done = rgviz("--help")
        took.append(time.perf_counter() - began)
        assert "measure" in done.stdout
    assert statistics.median(took) < 0.3


def test_a_log_becomes_a_map_in_every_format(project: Path, tmp_path: Path) -> None:
    for ending in ("json", "glb", "svg", "tum"):
        out = tmp_path / f"map.{ending}"
        done = rgviz("export", project, out)
        assert done.returncode == 0, done.stderr
        assert out.stat().st_size > 1000
    m = json.loads((tmp_path / "map.json").read_text(encoding="utf-8"))
    assert m["format"] == "rgmap"
    assert m["stats"]["lines"] == len(m["lines"]) > 5
    assert len(np.loadtxt(tmp_path / "map.tum")) == m["stats"]["scans"] == 418


def test_measure_tells_the_paper_s_table(project: Path) -> None:
    done = rgviz("measure", project, "--json")
    figures = json.loads(done.stdout)
    assert figures["reduction"] == pytest.approx(figures["segments"] / figures["lines"], abs=0.01)
    assert 0 < figures["accuracy"] < 1
    assert figures["regions"]
    assert "accuracy" in rgviz("measure", project).stdout


def test_edits_are_applied_and_a_wrong_one_is_named(project: Path, tmp_path: Path) -> None:
    first = json.loads(rgviz("measure", project, "--json").stdout)["regions"][0]["id"]
    edits = tmp_path / "edits.jsonl"
    edits.write_text(
        json.dumps({"edit": "RenameRegion", "region": first, "name": "Reception"})
        + "\n"
        + json.dumps({"edit": "RenameRegion", "region": "r999", "name": "Nowhere"})
        + "\n",
        encoding="utf-8",
    )
    done = rgviz("edit", project, edits)
    assert done.returncode == 1
    assert "edits.jsonl:2" in done.stderr
    assert "r999" in done.stderr
    assert "Traceback" not in done.stderr
    assert json.loads(rgviz("measure", project, "--json").stdout)["regions"][0]["name"] == "Reception"


def test_a_new_run_keeps_the_corrections(short_log: Path, project: Path, tmp_path: Path) -> None:
    first = json.loads(rgviz("measure", project, "--json").stdout)["regions"][0]["id"]
    edit = json.dumps({"edit": "RenameRegion", "region": first, "name": "Kept"})
    assert rgviz("edit", project, "-", stdin=edit).returncode == 0
    done = rgviz("run", short_log, "-o", project, "--set", "lines.gap=0.3")
    assert done.returncode == 0, done.stderr
    assert "Kept" in [r["name"] for r in json.loads(rgviz("measure", project, "--json").stdout)["regions"]]


def test_a_robot_put_elsewhere_is_told(tmp_path: Path) -> None:
    lines = [x for x in gzip.decompress(LOG.read_bytes()).decode().splitlines() if x.startswith("FLASER")]
    elsewhere = [x.split() for x in lines[2918:2930]]
    for words in elsewhere:
        words[-9:-3] = lines[365].split()[-9:-3]  # its wheels stood still
    log = tmp_path / "carried.log"
    log.write_text("\n".join([*lines[266:366], *(" ".join(w) for w in elsewhere)]) + "\n", encoding="utf-8")
    done = rgviz("run", log, "-o", tmp_path / "carried.rg")
    assert done.returncode == 0, done.stderr
    told = f"{log}: scan 100 could not be joined to the one before: the robot was moved, or scans are missing"
    assert done.stderr.splitlines().count(told) == 1
    assert told.removeprefix(f"{log}: ") in (tmp_path / "carried.rg/runs/0001/run.json").read_text(encoding="utf-8")


def test_simulate_writes_a_log_and_its_truth(tmp_path: Path) -> None:
    done = rgviz("simulate", PLAN, "-o", tmp_path / "drive.log.gz", "--seed", "3")
    assert done.returncode == 0, done.stderr
    assert {"drive.log.gz", "drive.truth.json", "drive.poses.tum"} <= {p.name for p in tmp_path.iterdir()}


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("run", "absent.log"), "absent.log"),
        (("run", "folder"), "folder"),
        (("run", "empty.log"), "empty.log"),
        (("run", "junk.log"), "junk.log"),
        (("run", "cut.log.gz"), "cut.log.gz"),
        (("run", "short.log", "--set", "slam.max_range=-1"), "slam.max_range"),
        (("run", "short.log", "--config", "absent.toml"), "absent.toml"),
        (("view", "absent.rg", "--no-browser"), "absent.rg"),
        (("measure", "absent.rg"), "absent.rg"),
        (("export", "absent.rg", "x.json"), "absent.rg"),
        (("edit", "absent.rg", "x.jsonl"), "x.jsonl"),
    ],
    ids=lambda x: " ".join(x) if isinstance(x, tuple) else "",
)
def test_bad_input_gets_one_line_that_names_it(
    args: tuple[str, ...], words: str, short_log: Path, tmp_path: Path
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "empty.log").touch()
    (tmp_path / "junk.log").write_bytes(bytes(range(256)) * 20)
    (tmp_path / "cut.log.gz").write_bytes(LOG.read_bytes()[:5000])
    (tmp_path / "short.log").write_bytes(short_log.read_bytes())
    done = rgviz(*args, cwd=tmp_path)
    assert done.returncode == 1, done.stdout
    errors = [line for line in done.stderr.splitlines() if line.startswith("rgviz: ")]
    assert len(errors) == 1
    assert words in errors[0]
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.glob("*.rg"))


def test_an_unknown_ending_lists_the_known_ones(project: Path, tmp_path: Path) -> None:
    done = rgviz("export", project, tmp_path / "map.xyz")
    assert done.returncode == 1
    assert ".json" in done.stderr


def test_usage_errors_exit_with_2() -> None:
    assert rgviz("run").returncode == 2
    assert rgviz("fly").returncode == 2


def test_ctrl_c_leaves_no_half_project(tmp_path: Path) -> None:
    child = subprocess.Popen(
        [sys.executable, "-m", "rgviz.cli", "run", str(LOG), "-o", str(tmp_path / "half.rg")],
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=os.setsid,
    )
    time.sleep(3.0)
    os.killpg(child.pid, signal.SIGINT)
    _, err = child.communicate(timeout=60)
    assert child.returncode == 130, err
    assert "Traceback" not in err
    assert not list(tmp_path.iterdir())


def test_measure_judges_the_trajectory_by_relations(project: Path, tmp_path: Path) -> None:
    rgviz("export", project, tmp_path / "map.tum")
    table = np.loadtxt(tmp_path / "map.tum")
    yaw = 2 * np.arctan2(table[:, 6], table[:, 7])
    d, a = table[200, 1:3] - table[0, 1:3], yaw[0]
    x, y = np.cos(a) * d[0] + np.sin(a) * d[1], -np.sin(a) * d[0] + np.cos(a) * d[1]
    file = tmp_path / "one.relations"
    file.write_text(f"EDGE2 0 200 {x + 0.25:.6f} {y:.6f} {yaw[200] - a:.6f} 1 0 1 1 0 0\n", encoding="utf-8")
    figures = json.loads(rgviz("measure", project, "--json", "--relations", file).stdout)["relations"]
    assert figures["matched"] == 1
    assert figures["trans_mean"] == pytest.approx(0.25, abs=1e-3)
    assert figures["rot_mean"] == pytest.approx(0, abs=0.01)
    assert rgviz("measure", project, "--relations", file, "--rows", "0,1").returncode == 1


def test_a_fault_is_one_line_and_a_traceback_only_where_asked_for(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("by\nzero")

    monkeypatch.setattr(making, "config", fail)
    assert cli.main(["config"]) == 1
    out = capsys.readouterr()
    assert out.err.splitlines() == [
        "rgviz: a fault in rgviz: ZeroDivisionError: by zero; run it again with --debug and report what it says"
    ]
    with pytest.raises(ZeroDivisionError):
        cli.main(["config", "--debug"])


def test_edits_that_are_no_text_are_refused_in_a_line(project: Path, tmp_path: Path) -> None:
    edits = tmp_path / "edits.jsonl"
    edits.write_bytes(b"\x00\xff\xfe")
    done = rgviz("edit", project, edits)
    assert done.returncode == 1
    assert done.stderr.splitlines() == [f"rgviz: {edits}: not a text file (UTF-8); write one edit a line as JSON"]


def test_ctrl_c_inside_a_compiled_kernel_is_no_fault(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stop(*_: object) -> None:
        raise SystemError("returned a result with an exception set") from KeyboardInterrupt()

    monkeypatch.setattr(making, "config", stop)
    assert cli.main(["config"]) == 130
    assert capsys.readouterr().err == "stopped\n"


def test_tables_are_whole_in_a_pipe(project: Path) -> None:
    done = rgviz("measure", project)
    assert "accuracy" in done.stdout
    assert "…" not in done.stdout


def test_export_tells_what_a_format_cannot_carry_and_places_a_map_on_the_earth(project: Path, tmp_path: Path) -> None:
    metres = rgviz("export", project, tmp_path / "map.geojson")
    assert "not in this format: the coordinates are metres of the map frame" in metres.stderr
    placed = rgviz("export", project, tmp_path / "map.geojson", "--georeference=-53.1,8.8,30")
    assert placed.returncode == 0
    assert "metres of the map frame" not in placed.stderr
    features = json.loads((tmp_path / "map.geojson").read_text(encoding="utf-8"))["features"]
    lon, lat = np.array(next(f for f in features if f["id"] == "r1")["geometry"]["coordinates"][0]).T
    assert np.abs(lon - 8.8).max() < 0.01
    assert np.abs(lat + 53.1).max() < 0.01
    wrong = rgviz("export", project, tmp_path / "map.geojson", "--georeference=Bremen")
    assert wrong.returncode == 2
    assert "'Bremen' is not LAT,LON" in wrong.stderr


def test_nav2_files_lie_beside_each_other(project: Path, tmp_path: Path) -> None:
    assert rgviz("export", project, tmp_path / "map.yaml", "--resolution", 0.1).returncode == 0
    names = {p.name for p in tmp_path.iterdir()}
    assert {"map.yaml", "map.pgm", "map-keepout.yaml", "map-speed.pgm"} <= names


def test_lint_gives_remedies_that_edit_takes(project: Path, tmp_path: Path) -> None:
    found = json.loads(rgviz("lint", project, "--json", "--robot-width", 1.5).stdout)
    assert found
    assert any(f["code"] == "narrow-gateway" for f in found)
    told = rgviz("lint", project, "--robot-width", 1.5).stdout
    assert all(f["text"] in told for f in found)
    assert "must be metres" in rgviz("lint", project, "--robot-width", -1).stderr


def test_find_prints_ids(project: Path) -> None:
    found = rgviz("find", project, "kind:region").stdout.split()
    assert "r1" in found
    wrong = rgviz("find", project, "colour:red")
    assert wrong.returncode == 1
    assert wrong.stderr.strip() == "rgviz: colour:red: there is no field colour; did you mean clutter?"


def test_info_tells_what_is_in_a_log_and_a_project(short_log: Path, project: Path) -> None:
    log = json.loads(rgviz("info", short_log, "--json").stdout)
    assert (log["kind"], log["format"], log["beams"], log["odometry"]) == ("log", "carmen", 181, True)
    assert log["way"] > 1
    made = json.loads(rgviz("info", project, "--json").stdout)
    assert made["kind"] == "project"
    assert made["scans"] == log["scans"]
    assert "181" in rgviz("info", short_log).stdout
    assert "there is no such file" in rgviz("info", "nowhere.log").stderr


def test_info_tells_of_floor_plans_and_of_maps_for_other_programs(project: Path, tmp_path: Path) -> None:
    (tmp_path / "plan").write_bytes(make_plans.image())
    assert "180 x 140 pixels" in rgviz("info", tmp_path / "plan").stdout
    (tmp_path / "plan.dxf").write_bytes(make_plans.drawing())
    assert "8 x 6 m" in rgviz("info", tmp_path / "plan.dxf").stdout
    with Project.open(project) as p:
        regions = len(p.map.regions)
    for ending in (".dxf", ".geojson", ".fg.json", ".osm"):
        assert rgviz("export", project, tmp_path / f"map{ending}").returncode == 0
        found = json.loads(rgviz("info", tmp_path / f"map{ending}", "--json").stdout)
        assert found["regions"] == regions
    (tmp_path / "bad.png").write_bytes(make_plans.image()[:60])
    assert "a damaged png" in rgviz("info", tmp_path / "bad.png").stderr


def test_view_refuses_a_backdrop_that_is_no_plan_before_anything_else(project: Path, tmp_path: Path) -> None:
    (tmp_path / "plan.png").write_bytes(b"hello")
    said = rgviz("view", project, "--no-browser", "--backdrop", tmp_path / "plan.png")
    assert said.returncode == 1
    assert "plan.png: no floor plan; expected png, jpg or DXF" in said.stderr


def test_a_map_edited_elsewhere_is_listed_first_and_then_applied(project: Path, tmp_path: Path) -> None:
    copy, drawing = tmp_path / "a.rg", tmp_path / "a.geojson"
    shutil.copytree(project, copy)
    assert rgviz("export", copy, drawing).returncode == 0
    tree = json.loads(drawing.read_text(encoding="utf-8"))
    next(f for f in tree["features"] if f["id"] == "r1")["properties"]["name"] = "Reception"
    drawing.write_text(json.dumps(tree), encoding="utf-8")
    listed = rgviz("import", copy, drawing)
    assert listed.stdout.splitlines()[0] == "rename r1 to Reception"
    assert "1 edits found; --apply makes them" in listed.stdout
    assert rgviz("find", copy, "name:Reception").stdout == ""
    assert "1 edits applied" in rgviz("import", copy, drawing, "--apply").stdout
    assert rgviz("find", copy, "name:Reception").stdout.split() == ["r1"]
    assert "0 edits" in rgviz("import", copy, drawing).stdout
