"""The project folder: written whole, never half; one writes, others read; every acknowledged edit is there."""

from __future__ import annotations

import errno
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rgcore.errors import EditError, ProjectError
from rgcore.model import folder
from rgcore.model.base import decode_map, encode_map
from rgcore.model.draft import object_from_lines
from rgcore.model.edits import ClassifyRegion, DeleteGateway, LabelObject, MoveObject, RenameRegion
from rgcore.model.project import Project
from rgcore.model.records import RGMap

ROOT = Path(__file__).parents[2]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "office.rg"


@pytest.fixture
def made(path: Path, run: SimpleNamespace) -> Path:
    Project.create(path, run).close()
    return path


def child(code: str, *args: str) -> subprocess.Popen[str]:
    """Another process that runs ``code``; PATH is its first argument."""
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code), *args],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def test_a_project_opens_as_it_was_made(path: Path, run: SimpleNamespace, office: RGMap) -> None:
    with Project.create(path, run) as project:
        assert (project.map, project.read_only, project.notes) == (office, False, [])
    assert {p.name for p in path.iterdir()} == {"project.toml", "current", "lock", "runs"}
    with Project.open(path) as project:
        assert project.map == office
        assert project.name == "office"
        assert np.array_equal(project.trajectory.map_from_base, run.trajectory.map_from_base)
        info = project.run_info
        assert (info.log, info.scans, info.beams, info.points) == ("office.log", 40, 31, 7000)
        assert (info.settings, info.config["lines"]["gap"]) == ({"lines.gap": 0.3}, 0.2)
        assert info.seconds == {"extract": 0.1, "slam": 1.235}
        assert info.notes == ("2 lines of unknown kinds",)


def test_the_points_are_the_echoes_in_the_map_frame(path: Path, run: SimpleNamespace) -> None:
    with Project.create(path, run) as project:
        points, scans = project.points, project.point_scans
        assert (points.dtype, scans.dtype) == (np.float32, np.int32)
        robots = run.trajectory.map_from_base[scans, :2]
        assert np.allclose(np.hypot(*(points - robots).T), 1.5, atol=1e-4)
        assert (np.diff(scans) >= 0).all()
        cells = np.floor(points / 0.04)
        assert 100 < len(points) <= len(np.unique(cells, axis=0)) * 1.01


def test_edits_undo_and_redo_survive_closing(path: Path, run: SimpleNamespace, office: RGMap) -> None:
    with Project.create(path, run) as project:
        project.do(ClassifyRegion(region="r3", class_="CC"), by="ann")
        project.do(object_from_lines(project.map, ["l6", "l7"]))
        project.do(DeleteGateway(gateway="g1"))
        project.undo(by="bob")
        before = project.map
    with Project.open(path) as project:
        assert project.map == before
        assert project.map.regions["r3"].provenance.by == "ann"
        assert project.history.redo_title == "delete g1"
        assert "g1" not in project.redo().gateways
        for _ in range(3):
            project.undo()
        assert project.map == office
        with pytest.raises(EditError, match="nothing to undo"):
            project.undo()


def test_a_refused_edit_leaves_no_trace(made: Path) -> None:
    with Project.open(made) as project:
        before = project.map
        with pytest.raises(EditError, match="there is no region r9"):
            project.do(ClassifyRegion(region="r9", class_="CC"))
        with pytest.raises(EditError, match="this cannot be recorded"):
            project.do(ClassifyRegion(region="r1", class_="CC"), by="x" * 100)
        assert project.map is before
        assert (made / "runs/0001/edits.jsonl").read_bytes() == b""


def test_an_edit_that_changes_nothing_is_not_recorded(made: Path) -> None:
    with Project.open(made) as project:
        project.do(ClassifyRegion(region="r3", class_="CC"))
        project.undo()
        project.do(ClassifyRegion(region="r3", class_="TOMA"))
        assert project.history.undo_title is None
        assert project.history.redo_title == "relabel r3 as CC"


def test_the_base_is_lossless_and_one_record_a_line(office: RGMap) -> None:
    data = encode_map(office)
    again = decode_map(data)
    assert again == office
    assert encode_map(again) == data
    assert [list(again.lines), list(again.regions)] == [list(office.lines), list(office.regions)]
    lines = data.decode().splitlines()
    assert sum('"id":' in line for line in lines) == 9 + 3 + 2 + 1
    assert all(line.count('"id":') <= 1 for line in lines)


def test_the_same_run_gives_the_same_base(tmp_path: Path, run: SimpleNamespace) -> None:
    for name in ("a.rg", "b.rg"):
        Project.create(tmp_path / name, run).close()
    a, b = ((tmp_path / name / "runs/0001/base.json").read_bytes() for name in ("a.rg", "b.rg"))
    assert a == b


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda p: shutil.rmtree(p), "there is no such project; map the log again"),
        (lambda p: (p / "project.toml").unlink(), r"holds no project\.toml"),
        (lambda p: (p / "project.toml").write_text("version = ["), r"project\.toml: damaged"),
        (lambda p: (p / "project.toml").write_text("version = 99\nshape = 1"), "made by a newer rgviz.*pip install -U"),
        (lambda p: (p / "current").unlink(), "current: names no run of this project; write one of 0001"),
        (lambda p: (p / "current").write_text("../../etc"), "current: names no run of this project; write one of 0001"),
        (lambda p: (p / "current").write_bytes(b"\xff\xfe"), "current: names no run"),
        (lambda p: shutil.rmtree(p / "runs"), "holds no finished run; map the log again"),
        (lambda p: (p / "runs/0001/base.json").unlink(), r"base\.json: cannot be read: No such file"),
        (lambda p: (p / "runs/0001/base.json").write_bytes(b"{}"), r"base\.json: damaged"),
        (lambda p: (p / "runs/0001/base.json").write_bytes(b'{"version": 9}'), r"base\.json: damaged"),
        (lambda p: (p / "runs/0001/run.json").write_bytes(b"["), r"run\.json: damaged"),
        (lambda p: (p / "runs/0001/trajectory.npz").write_bytes(b"PK\3\4junk"), r"trajectory\.npz: damaged"),
        (lambda p: (p / "runs/0001/edits.jsonl").unlink(), r"edits\.jsonl: cannot read the journal"),
        (lambda p: (p / "runs/0001/conflicts.json").write_text("x"), r"conflicts\.json: damaged"),
    ],
)
def test_damage_is_one_line_with_the_remedy(made: Path, damage: object, words: str) -> None:
    damage(made)  # type: ignore[operator]
    with pytest.raises(ProjectError, match=words) as error:
        Project.open(made)
    assert "\n" not in str(error.value)


def test_damaged_points_are_told_when_they_are_wanted(made: Path) -> None:
    (made / "runs/0001/points.npz").write_bytes(b"junk")
    with Project.open(made) as project, pytest.raises(ProjectError, match=r"points\.npz: damaged"):
        _ = project.points


def test_a_file_is_no_project(tmp_path: Path) -> None:
    (tmp_path / "office.log").touch()
    with pytest.raises(ProjectError, match=r"office\.log: a file, not a project"):
        Project.open(tmp_path / "office.log")


def test_creating_never_overwrites(made: Path, tmp_path: Path, run: SimpleNamespace) -> None:
    for there in (made, tmp_path):
        with pytest.raises(ProjectError, match="there is something already; choose another name"):
            Project.create(there, run)
    (tmp_path / "file.rg").touch()
    with pytest.raises(ProjectError, match="there is something already"):
        Project.create(tmp_path / "file.rg", run)


def test_creating_takes_over_what_a_killed_one_left_and_the_cache(path: Path, run: SimpleNamespace) -> None:
    (path / "cache").mkdir(parents=True)
    (path / "runs/.0001.tmp").mkdir(parents=True)
    (path / "project.toml").write_text("half")
    assert not Project.exists(path)
    with Project.create(path, run) as project:
        assert project.run_name == "0001"
    assert Project.exists(path)
    assert [p.name for p in (path / "runs").iterdir()] == ["0001"]


@pytest.mark.parametrize("at", range(8))
def test_a_full_disk_while_creating_leaves_no_project(
    path: Path, run: SimpleNamespace, at: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill_disk(monkeypatch, after=at)
    with pytest.raises(ProjectError, match="cannot be written: No space left on device; make room"):
        Project.create(path, run)
    assert not path.exists()
    monkeypatch.undo()
    Project.create(path, run).close()


def fill_disk(monkeypatch: pytest.MonkeyPatch, after: int) -> None:
    """The first ``after`` files can be written, no more."""
    from rgcore.model import disk

    count = []
    real = disk.write_file

    def write_file(path: Path, data: bytes) -> None:
        count.append(path)
        if len(count) > after:
            path.write_bytes(data[: len(data) // 2])
            raise OSError(errno.ENOSPC, "No space left on device")
        real(path, data)

    monkeypatch.setattr(disk, "write_file", write_file)
    monkeypatch.setattr(folder, "write_file", write_file)


def test_a_full_disk_while_mapping_again_leaves_the_project_as_it_was(
    made: Path, run: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Project.open(made) as project:
        project.do(RenameRegion(region="r1", name="Flur"))
        for at in range(7):
            fill_disk(monkeypatch, after=at)
            with pytest.raises(ProjectError, match="No space left"):
                project.add_run(run)
            monkeypatch.undo()
            assert (project.run_name, project.map.regions["r1"].name) == ("0001", "Flur")
        project.do(RenameRegion(region="r2", name="Lab"))
    with Project.open(made) as project:
        assert project.run_name == "0001"
        assert [project.map.regions[r].name for r in ("r1", "r2")] == ["Flur", "Lab"]


def test_the_second_process_reads_and_is_told_who_writes(made: Path) -> None:
    other = child(
        """
        import sys
        from rgcore.model.edits import RenameRegion
        from rgcore.model.project import Project
        project = Project.open(sys.argv[1])
        project.do(RenameRegion(region="r1", name="Flur"))
        print("open", flush=True)
        sys.stdin.read()
        """,
        str(made),
    )
    try:
        assert other.stdout is not None
        assert other.stdout.readline() == "open\n"
        with Project.open(made) as project:
            assert project.read_only
            assert project.holder is not None
            assert project.holder.pid == other.pid
            assert project.map.regions["r1"].name == "Flur"
            with pytest.raises(ProjectError, match=rf"read-only: process {other.pid} on .* holds it; close it there"):
                project.do(RenameRegion(region="r1", name="Gang"))
            with pytest.raises(ProjectError, match="read-only"):
                project.undo()
    finally:
        other.kill()
        other.communicate()
    with Project.open(made) as project:  # a killed process holds nothing
        assert not project.read_only
        project.do(RenameRegion(region="r1", name="Gang"))


def test_without_locks_of_files_a_project_is_read_and_the_remedy_told(
    made: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rgcore.model.lock.fcntl", None)
    with Project.open(made) as project, pytest.raises(ProjectError, match="run rgviz in WSL, Linux or macOS"):
        project.do(RenameRegion(region="r1", name="Gang"))


def test_a_closed_project_refuses(made: Path) -> None:
    project = Project.open(made)
    project.close()
    project.close()
    with pytest.raises(ProjectError, match="read-only: it is closed"):
        project.do(RenameRegion(region="r1", name="Gang"))


def test_killed_under_edits_every_acknowledged_one_is_there(made: Path) -> None:
    """kill -9 at chance moments; the child tells the label it set only after ``do`` has returned."""
    rng = np.random.default_rng(7)
    acknowledged = 0
    for _ in range(5):
        other = child(
            """
            import sys
            from rgcore.model.edits import LabelObject
            from rgcore.model.project import Project
            project, number = Project.open(sys.argv[1]), int(sys.argv[2])
            while True:
                number += 1
                project.do(LabelObject(object="o1", label=str(number)))
                print(number, flush=True)
            """,
            str(made),
            str(acknowledged),
        )
        assert other.stdout is not None
        for _ in range(int(rng.integers(1, 40))):
            acknowledged = int(other.stdout.readline())
        os.kill(other.pid, signal.SIGKILL)
        rest = other.stdout.read()  # what it told before it died
        other.communicate()
        acknowledged = int(rest.splitlines()[-1]) if rest.endswith("\n") else acknowledged
        with Project.open(made) as project:
            there = int(project.map.objects["o1"].label)
            assert there in (acknowledged, acknowledged + 1)  # the last one may be on the disk and not yet told
            assert len(project.history.done) == there
            acknowledged = there


def test_on_a_full_disk_an_edit_is_refused_and_nothing_breaks(made: Path) -> None:
    """A real limit on the size of files, in another process: the write breaks off in the middle of the entry."""
    other = child(
        """
        import resource, sys
        from rgcore.errors import ProjectError
        from rgcore.model.edits import LabelObject
        from rgcore.model.project import Project
        with Project.open(sys.argv[1]) as project:
            project.do(LabelObject(object="o1", label="first"))
            size = (project.path / "runs/0001/edits.jsonl").stat().st_size
            resource.setrlimit(resource.RLIMIT_FSIZE, (size + 50, resource.RLIM_INFINITY))
            for _ in range(2):
                try:
                    project.do(LabelObject(object="o1", label="second"))
                except ProjectError as e:
                    print(e)
            print(project.map.objects["o1"].label, (project.path / "runs/0001/edits.jsonl").stat().st_size == size)
            resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
            project.do(LabelObject(object="o1", label="third"))
        """,
        str(made),
    )
    out, _ = other.communicate(timeout=60)
    assert other.returncode == 0
    *refused, state = out.splitlines()
    assert len(refused) == 2
    assert all("the edit was not kept: File too large; make room and try again" in line for line in refused)
    assert state == "first True"
    with Project.open(made) as project:
        assert (project.map.objects["o1"].label, len(project.history.done), project.notes) == ("third", 2, [])


def test_a_torn_journal_is_told_and_the_project_goes_on(made: Path) -> None:
    with Project.open(made) as project:
        project.do(RenameRegion(region="r1", name="Flur"))
        project.do(RenameRegion(region="r2", name="Lab"))
    journal = made / "runs/0001/edits.jsonl"
    journal.write_bytes(journal.read_bytes()[:-9])
    with Project.open(made) as project:
        assert [project.map.regions[r].name for r in ("r1", "r2")] == ["Flur", "Room 1"]
        assert "the last entry was torn" in project.notes[0]
        project.do(RenameRegion(region="r2", name="Lab 2"))
    with Project.open(made) as project:
        assert (project.map.regions["r2"].name, project.notes) == ("Lab 2", [])


def test_threads_may_edit_at_once(made: Path) -> None:
    with Project.open(made) as project:

        def work(me: int) -> None:
            for i in range(10):
                project.do(MoveObject(object="o1", center=(me, i, 0.5), size=(1.0, 1.0, 1.0), yaw=0.0), by=f"t{me}")

        threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
        for t in threads:
            t.start()
        for t in threads:
            t.join()
        assert [d.entry.number for d in project.history.done] == list(range(1, 41))
        last = project.map
    with Project.open(made) as project:
        assert project.map == last


def test_mapping_again_keeps_the_edits_and_lists_what_it_cannot(
    made: Path, office: RGMap, run: SimpleNamespace
) -> None:
    without = {k: v for k, v in office.regions.items() if k != "r3"}
    run.map = RGMap(lines=office.lines, regions=without, gateways=office.gateways, objects=office.objects)
    with Project.open(made) as project:
        project.do(RenameRegion(region="r2", name="Lab"), by="ann")
        project.do(ClassifyRegion(region="r3", class_="kitchen"), by="bob")
        project.do(LabelObject(object="o1", label="shelf"))
        project.undo()
        (conflict,) = project.add_run(run)
        assert (conflict.kind, conflict.entry.by, conflict.run) == ("stale", "bob", "0001")
        assert str(conflict) == "relabel r3 as kitchen: r3 has no clear counterpart in the new map"
        assert project.run_name == "0002"
        project.undo()
        assert project.map.regions["r2"].name == "Room 1"
        project.redo()
    with Project.open(made) as project:
        assert project.conflicts == (conflict,)
        assert project.map.regions["r2"].name == "Lab"
        assert project.map.regions["r2"].provenance.by == "ann"
        assert project.add_run(run) == (conflict,)  # still told after one more run
        assert project.run_name == "0003"
