"""Mapping in a process of its own: reports, a project at the end, nothing left of what failed or was stopped."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from short_log import short_log

from rgcore.config import Config
from rgcore.geometry import se2
from rgcore.model.edits import RenameRegion
from rgcore.model.project import Project
from rgcore.model.rerun import plan_rerun
from rgcore.model.staged import read_staged
from rgcore.scans.read import read_log
from rgviz.jobs import Finished, MappingJob, Report, RerunJob, echoes

SCANS = 80
"""enough for every stage to have something to do"""


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return short_log(tmp_path_factory.mktemp("log") / "short.log", SCANS)


def run(log: Path, project: Path, kind: type[MappingJob] = MappingJob) -> tuple[list[Report], Finished]:
    heard: queue.Queue[Any] = queue.Queue()
    kind(log, project, Config(), heard.put)
    reports = []
    while not isinstance(message := heard.get(timeout=120), Finished):
        reports.append(message)
    return reports, message


def test_a_log_becomes_a_project_and_shows_itself_growing(log: Path, tmp_path: Path) -> None:
    reports, ending = run(log, tmp_path / "short.rg")
    assert ending.error is None
    stages = list(dict.fromkeys(r.stage for r in reports))
    assert stages[0] == "read"
    assert stages[-1] == "save"
    assert {"extract", "slam", "places", "lines"} <= set(stages)
    pictures = [r for r in reports if r.points is not None]
    assert pictures
    assert pictures[-1].points.dtype == np.float32  # type: ignore[union-attr]
    assert [r for r in reports if r.map is not None and r.map.lines and r.map.regions]
    with Project.open(tmp_path / "short.rg") as project:
        assert project.map.stats.scans == SCANS
        assert not project.read_only, "the mapping process has let go of it"
        first = next(iter(project.map.regions))
        reports, ending = run(log, tmp_path / "short.rg", RerunJob)
        assert ending.error is None
        assert not [r for r in reports if r.points is not None or r.map is not None], "the map on show stays"
        project.do(RenameRegion(region=first, name="Lab"))
        new = read_staged(project.path)
        assert new is not None
        plan = plan_rerun(project, new)
        assert plan.counts() == {"applied": 1, "shifted": 0, "conflict": 0, "stale": 0}
        project.accept(plan)
        assert (project.run_name, project.map.regions[first].name) == ("0002", "Lab")


def test_echoes_are_those_of_the_scans(log: Path) -> None:
    scans = read_log(log)
    poses = se2.compose(scans.odom_from_base, scans.base_from_laser)[:40]
    points = echoes(scans, poses, 20.0)
    assert points.shape[1] == 2
    assert 1000 < len(points) < 60_000
    first = se2.transform(poses[0], scans.points(0, 20.0))
    assert min(np.linalg.norm(points - p, axis=1).min() for p in first[::20]) < 1e-3


def test_a_damaged_log_is_one_line_and_leaves_nothing(tmp_path: Path) -> None:
    bad = tmp_path / "bad.log"
    bad.write_text("FLASER 3 1.0 abc 2.0\n")
    _, ending = run(bad, tmp_path / "bad.rg")
    assert ending.error is not None
    assert "bad.log" in ending.error
    assert "\n" not in ending.error
    assert not (tmp_path / "bad.rg").exists()


@pytest.mark.parametrize("stage", ["read", "slam"])
def test_a_cancelled_job_leaves_nothing(
    log: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str], stage: str
) -> None:
    heard: queue.Queue[Any] = queue.Queue()
    job = MappingJob(log, tmp_path / "short.rg", Config(), heard.put)
    while heard.get(timeout=60).stage != stage:
        pass
    pid = job._child.pid
    assert pid is not None
    job.cancel()
    assert not (tmp_path / "short.rg").exists()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    assert not [m for m in heard.queue if isinstance(m, Finished)]
    assert capfd.readouterr().err == ""


def test_the_mapping_ends_when_its_parent_is_killed(log: Path, tmp_path: Path) -> None:
    script = (
        "import sys, time; from pathlib import Path\n"
        "from rgcore.config import Config\nfrom rgviz.jobs import MappingJob\n"
        "if __name__ == '__main__':\n"
        f"    job = MappingJob(Path({str(log)!r}), Path({str(tmp_path / 'k.rg')!r}), Config(), lambda m: None)\n"
        "    print(job._child.pid, flush=True)\n    time.sleep(60)\n"
    )
    file = tmp_path / "parent.py"
    file.write_text(script)
    parent = subprocess.Popen([sys.executable, str(file)], stdout=subprocess.PIPE, cwd=Path(__file__).parents[2])
    assert parent.stdout is not None
    child = int(parent.stdout.readline())
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    parent.stdout.close()
    for _ in range(100):
        if not _running(child):
            return
        time.sleep(0.1)
    os.kill(child, signal.SIGKILL)
    pytest.fail("the mapping process outlived its parent")


def _running(pid: int) -> bool:
    try:
        return "\nState:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except FileNotFoundError:
        return False
