"""One order for all edits; told only after it is on the disk; refusals to the one who asked."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
from make_project import make_project
from office_map import office_map

from rgcore.errors import EditError, ProjectError
from rgcore.model.edits import ClassifyRegion, RenameRegion
from rgcore.model.project import Project
from rgcore.model.records import RGMap
from rgviz.session import Session, Worker


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return make_project(tmp_path / "office.rg", office_map(2, 1, 1))


def test_an_edit_is_on_the_disk_before_anyone_hears_of_it(path: Path) -> None:
    with Project.open(path) as project:
        session = Session(project)
        heard: list[tuple[str, bool]] = []

        def listen(before: RGMap, after: RGMap) -> None:
            journal = next(path.glob("runs/*/edits.jsonl")).read_text()
            same = before.regions["r4"] is after.regions["r4"]
            heard.append((after.regions["r3"].class_, same and "ClassifyRegion" in journal))

        session.listen(listen)
        session.do(ClassifyRegion(region="r3", class_="CC"), by="test")
        session.do(ClassifyRegion(region="r3", class_="CC"), by="test")
        assert heard == [("CC", True)], "an edit that changes nothing is not told"
        with pytest.raises(EditError):
            session.do(ClassifyRegion(region="r99", class_="CC"))
        assert len(heard) == 1
        assert session.undo_title == "relabel r3 as CC"
        session.undo()
        assert session.redo_title == "relabel r3 as CC"
        session.redo()
        assert [h[0] for h in heard] == ["CC", "TOMA", "CC"]


def test_a_second_process_would_only_read(path: Path) -> None:
    with Project.open(path), Project.open(path) as second, pytest.raises(ProjectError, match="read-only"):
        Session(second).do(RenameRegion(region="r3", name="x"))


def test_the_worker_keeps_the_order_and_survives_faults() -> None:
    worker, done, told = Worker(), [], []

    def fail(kind: type[Exception]) -> None:
        raise kind("because")

    for n in range(100):
        worker.post(done.append, n)
    worker.post(fail, EditError, refused=told.append)
    worker.post(fail, ValueError, refused=told.append)
    worker.post(fail, EditError)
    worker.post(done.append, 100)
    worker.wait()
    assert done == list(range(101))
    assert told[0] == "because"
    assert "because" not in told[1], "a fault is not explained to a browser"
    worker.finish()
    assert not [t for t in threading.enumerate() if t is worker._thread]
