"""The project: a folder that holds the runs of a map and what people did to it.

    office.rg/  project.toml  current  lock  cache/
                runs/0001/  run.json  trajectory.npz  points.npz  segments.npz  base.json  adapt.json
                            edits.jsonl  conflicts.json
                backdrops/  floor plans, each under its SHA-256

One process writes (``lock``); others read. A run's folder is written whole under another name, then ``current`` is
flipped.
"""

from __future__ import annotations

import shutil
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rgcore.errors import EditError, ProjectError
from rgcore.lines.adaptation import Adaptation
from rgcore.model import folder
from rgcore.model.edits import Edit
from rgcore.model.edits_backdrops import AddBackdrop
from rgcore.model.folder import RunInfo
from rgcore.model.history import AnyEntry, Do, History, Redo, Settle, Undo, now, replay, step
from rgcore.model.journal import Journal, readable
from rgcore.model.lock import Holder, Lock
from rgcore.model.outcome import Choice, Outcome, Remedy
from rgcore.model.records import RGMap
from rgcore.model.staged import Staged, accept_staged
from rgcore.slam.trajectory import Trajectory

if TYPE_CHECKING:
    from rgcore.model.rerun import Plan
    from rgcore.pipeline import Run


class Project:
    """An open project. All methods may be called from any thread.

    path, name  the folder, and what the project is called
    run_name, run_info, trajectory   of the current run
    kept        edits of earlier runs that are not in its journal: they wait, or there was nothing left to do
    outcomes    what became of the edits in the run that was accepted last through this object
    read_only   another process holds it (``holder`` says who), or its folder cannot be written
    notes       what was found unusual when it was opened, a line each
    """

    def __init__(self, path: Path, lock: Lock) -> None:
        """Use ``create`` or ``open``."""
        self.path = path
        self._lock, self._mutex = lock, threading.RLock()
        self.outcomes: tuple[Outcome, ...] = ()
        self._load()

    @classmethod
    def create(cls, path: str | Path, run: Run) -> Project:
        """Make the folder of a new project from its first run, and open it. Raises ProjectError."""
        path = Path(path)
        made = folder.claim(path)
        lock = Lock(path / "lock")
        try:
            if not lock.held:
                raise ProjectError(f"{path}: {lock.reason}")
            folder.create(path, run)
            return cls(path, lock)
        except BaseException:
            lock.release()
            if made:
                shutil.rmtree(path, ignore_errors=True)
            raise

    @staticmethod
    def exists(path: str | Path) -> bool:
        """Whether there is a project to open; a folder that a killed ``create`` left is none."""
        return (Path(path) / "current").exists()

    @classmethod
    def open(cls, path: str | Path) -> Project:
        """Open a project; read-only where another process has it. Raises ProjectError with the remedy."""
        path = Path(path)
        folder.check(path)
        lock = Lock(path / "lock")
        try:
            return cls(path, lock)
        except BaseException:
            lock.release()
            raise

    def _load(self) -> None:
        self.run_name = folder.current(self.path)
        where = self.path / "runs" / self.run_name
        self.name = folder.check(self.path).name
        self.run_info: RunInfo = folder.read_info(where)
        self.trajectory: Trajectory = folder.read_trajectory(where)
        self.kept: tuple[Outcome, ...] = folder.read_conflicts(where)
        self._points: tuple[np.ndarray, np.ndarray] | None = None
        self._journal = Journal(where / "edits.jsonl")
        self._history, notes = replay(folder.read_base(where), self._journal.entries)
        torn = [] if self.read_only else self._journal.notes  # another process may be writing its last entry right now
        self.notes = [*self._lock.notes, *torn, *notes]

    @property
    def read_only(self) -> bool:
        return not self._lock.held

    @property
    def holder(self) -> Holder | None:
        """Who else holds the project; None if nobody does."""
        return self._lock.holder

    @property
    def map(self) -> RGMap:
        """The corrected map."""
        return self._history.map

    @property
    def base(self) -> RGMap:
        """The map as the pipeline made it."""
        return self._history.base

    @property
    def history(self) -> History:
        return self._history

    @property
    def conflicts(self) -> tuple[Outcome, ...]:
        """The edits that wait for a person: those that a new run could not take over and that are not settled yet."""
        settled = self._history.settled
        return tuple(o for o in self.kept if o.waits and o.key not in settled)

    @property
    def adaptation(self) -> Adaptation | None:
        """How the parameters of merging adapted to the regions of ``base``; None in a run without that."""
        return folder.read_adaptation(self.path / "runs" / self.run_name)

    @property
    def segments(self) -> folder.KeptSegments | None:
        """The lines of all single scans before merging; None in a run of an older version."""
        return folder.read_segments(self.path / "runs" / self.run_name)

    @property
    def points(self) -> np.ndarray:
        """(K, 2) float32 [m] echoes of all scans in the map frame, thinned, for the view."""
        return self._cloud()[0]

    @property
    def point_scans(self) -> np.ndarray:
        """(K,) int32 scan of each of ``points``, rising."""
        return self._cloud()[1]

    def do(self, edit: Edit, by: str | None = None) -> RGMap:
        """Make an edit; it is on the disk when this returns. An edit that changes nothing is not recorded.

        Raises EditError if the map refuses it, ProjectError if the project is read-only or the disk full; nothing is
        changed then.
        """
        checked = edit.checked()
        return self._step(lambda number: Do(number=number, at=now(), by=by, edit=checked))  # type: ignore[arg-type]

    def undo(self, by: str | None = None) -> RGMap:
        """Take the last standing edit back. Raises as ``do``."""
        return self._step(lambda number: Undo(number=number, at=now(), by=by))

    def redo(self, by: str | None = None) -> RGMap:
        """Make the edit again that was taken back last. Raises as ``do``."""
        return self._step(lambda number: Redo(number=number, at=now(), by=by))

    def settle(self, outcome: Outcome, remedy: Remedy, by: str | None = None) -> RGMap:
        """Settle an edit that waits (one of ``conflicts``) by one of its remedies; undo lets it wait again.

        Raises as ``do``, and EditError if it does not wait any more.
        """
        with self._mutex:
            if outcome.key not in {o.key for o in self.conflicts}:
                raise EditError(f"{outcome.title}: waits no more; somebody settled it")
            edit = None if remedy.edit is None else remedy.edit.checked()
            title = f"{outcome.title}: {remedy.name}"[:160]
            run, number = outcome.key
            return self._step(
                lambda n: Settle(number=n, at=now(), by=by, run=run, conflict=number, name=title, edit=edit)
            )

    def add_run(self, run: Run) -> tuple[Outcome, ...]:
        """Make ``run`` the current one, with the edits carried over as a plan proposes; gives ``conflicts``.

        Raises ProjectError if the project is read-only or cannot be written; it is unchanged then.
        """
        from rgcore.model.rerun import plan_rerun  # brings SciPy and Shapely, which nothing else here needs

        with self._mutex:
            self.must_write()
            return self.accept(plan_rerun(self, run))

    def accept(self, plan: Plan, choices: Mapping[int, Choice] | None = None) -> tuple[Outcome, ...]:
        """Make the run of a plan the current one; gives ``conflicts``. Undo and redo go on as before.

        choices  by the index of an outcome in the plan: LEAVE, it shall not be made now but wait; or one of its
                 remedies, which settles it. Without a choice, what is applied or shifted is made, the rest waits.

        Raises ProjectError as ``add_run``, and if the project was edited after the plan was made: then plan again.
        """
        from rgcore.model.rerun import chosen

        with self._mutex:
            self.must_write()
            if plan.history is not self._history or plan.run_name != self.run_name:
                raise ProjectError(f"{self.path}: was edited since the new run was looked at; look at it again")
            entries, kept = chosen(plan, choices or {}, self)
            if isinstance(plan.run, Staged):
                accept_staged(self.path, entries, kept)
            else:
                folder.add_run(self.path, plan.run, entries, kept)
            self._journal.close()
            self._load()
            self.outcomes = tuple(plan.outcomes)
            return self.conflicts

    def add_backdrop(self, data: bytes, name: str, by: str | None = None) -> AddBackdrop:
        """Lay a floor plan (the bytes of a png, jpg or DXF) under the map: its file is kept, then the edit is made.

        ``name`` is what it is called, never a path. It lies in the middle of the map, as large as it says it is, else
        as long as the map; :func:`rgcore.model.edits_backdrops.aligned` brings it to its place. Raises as ``do``, and
        InputError for a file that is no plan.
        """
        from rgcore.model.backdrops import laid  # brings OpenCV

        edit = laid(self.map, data, name)
        self.lay(edit, data, by)
        return edit

    def lay(self, edit: AddBackdrop, data: bytes, by: str | None = None) -> RGMap:
        """``add_backdrop`` with the edit made already (:func:`rgcore.model.backdrops.laid`). Raises as ``do``."""
        with self._mutex:
            self.must_write()
            folder.keep_backdrop(self.path, edit.sha256, data)
            return self.do(edit, by)

    def backdrop(self, sha256: str) -> bytes:
        """The file of a floor plan by its checksum. Raises ProjectError if it is not there."""
        return folder.read_backdrop(self.path, sha256)

    def close(self) -> None:
        """Give the project free for others."""
        with self._mutex:
            self._journal.close()
            self._lock.release()

    def __enter__(self) -> Project:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _step(self, make: Callable[[int], AnyEntry]) -> RGMap:
        with self._mutex:
            self.must_write()
            entry = readable(make(self._journal.next_number))
            after = step(self._history, entry)
            if isinstance(entry, Do) and not after.done[-1].patch:
                return self._history.map
            self._journal.append(entry)
            self._history = after
            return after.map

    def must_write(self) -> None:
        """Raises ProjectError, which says who holds the project, if it is read-only."""
        if self.read_only:
            raise ProjectError(f"{self.path}: open read-only: {self._lock.reason}")

    def _cloud(self) -> tuple[np.ndarray, np.ndarray]:
        with self._mutex:
            if self._points is None:
                self._points = folder.read_points(self.path / "runs" / self.run_name)
            return self._points
