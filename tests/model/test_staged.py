"""A new run waits in the project's folder; whoever is killed when, the edits and either run are whole."""

from __future__ import annotations

import os
import shutil
import signal
from pathlib import Path
from typing import Any

import pytest
from two_rooms import make_run

from rgcore.errors import ProjectError
from rgcore.model import disk, folder, staged
from rgcore.model.edits import ClassifyRegion, RenameRegion
from rgcore.model.project import Project
from rgcore.model.records import RGMap, replace
from rgcore.model.rerun import plan_rerun
from rgcore.model.staged import discard, read_staged, stage


@pytest.fixture
def path(tmp_path: Path, run: Any) -> Path:
    with Project.create(tmp_path / "office.rg", run) as project:
        project.do(RenameRegion(region="r2", name="Lab"))
        project.do(ClassifyRegion(region="r3", class_="kitchen"))
        project.do(RenameRegion(region="r1", name="Flur"))
        project.undo()
    return tmp_path / "office.rg"


@pytest.fixture
def again(office: RGMap) -> Any:
    """Another run of the same log, in which r3 is missing."""
    return make_run(replace(office, regions={k: v for k, v in office.regions.items() if k != "r3"}))


def test_a_run_waits_is_looked_at_and_accepted(path: Path, again: Any) -> None:
    with Project.open(path) as project:
        stage(path, again)  # by the process that mapped, while the project is open and edited here
        project.do(RenameRegion(region="r1", name="Corridor"))
    with Project.open(path) as project:
        new = read_staged(path)
        assert new is not None
        plan = plan_rerun(project, new)
        assert plan.counts() == {"applied": 2, "shifted": 0, "conflict": 0, "stale": 1}
        (waits,) = project.accept(plan)
        assert waits.title == "relabel r3 as kitchen"
        assert (project.run_name, project.map.regions["r2"].name) == ("0002", "Lab")
        assert project.history.undo_title == "rename r1 to Corridor"
        assert len(project.points) == len(project.point_scans) > 0
        assert read_staged(path) is None
        with pytest.raises(ProjectError, match="waits there any more"):
            project.accept(plan_rerun(project, new))


def test_what_is_discarded_leaves_all_as_it_was(path: Path, again: Any) -> None:
    before = sorted(p.relative_to(path) for p in path.rglob("*"))
    stage(path, again)
    stage(path, again)
    discard(path)
    discard(path)
    assert sorted(p.relative_to(path) for p in path.rglob("*")) == before


def test_a_full_disk_leaves_the_run_waiting(path: Path, again: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    stage(path, again)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with Project.open(path) as project:
        new = read_staged(path)
        assert new is not None
        for module, name in ((folder, "write_file"), (folder, "replace_file")):
            with monkeypatch.context() as m:
                m.setattr(module, name, full)
                with pytest.raises(ProjectError, match="No space left on device"):
                    project.accept(plan_rerun(project, new))
            assert (project.run_name, project.map.regions["r2"].name) == ("0001", "Lab")
            assert read_staged(path) is not None
        project.accept(plan_rerun(project, new))
        assert project.run_name == "0002"


def test_killed_at_any_moment_the_edits_are_there(path: Path, again: Any, tmp_path: Path) -> None:
    """The process is killed before every single thing that staging and accepting do to the disk."""
    runs = set()
    for moment in range(60):
        one = shutil.copytree(path, tmp_path / f"{moment}.rg")
        child = os.fork()
        if child == 0:
            _killed_at(moment, one, again)
        killed = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
        with Project.open(one) as project:
            runs.add(project.run_name)
            assert project.map.regions["r2"].name == "Lab"
            titles = [d.title for d in project.history.done] + [o.title for o in project.conflicts]
            assert sorted(titles) == ["relabel r3 as kitchen", "rename r2 to Lab"]
            assert project.history.redo_title == "rename r1 to Flur"
            new = read_staged(one)
            if new is not None:
                plan_rerun(project, new)
        if not killed:
            break
    assert not killed
    assert runs == {"0001", "0002"}
    assert moment > 15


def _killed_at(moment: int, path: Path, again: Any) -> None:
    """In a child: stage and accept, but not beyond that many steps on the disk."""
    left = [moment]

    def counted(step: Any) -> Any:
        def run(*args: Any, **rest: Any) -> Any:
            if not left[0]:
                os.kill(os.getpid(), signal.SIGKILL)
            left[0] -= 1
            return step(*args, **rest)

        return run

    for module in (disk, folder, staged):
        for name in ("write_file", "replace_file", "sync_folder"):
            if hasattr(module, name):
                setattr(module, name, counted(getattr(module, name)))
    os.replace = counted(os.replace)
    Path.rename = counted(Path.rename)  # type: ignore[method-assign]
    staged.shutil.rmtree = counted(staged.shutil.rmtree)
    try:
        stage(path, again)
        with Project.open(path) as project:
            new = read_staged(path)
            assert new is not None
            project.accept(plan_rerun(project, new))
        os._exit(0)
    finally:
        os._exit(1)
