"""A new run that waits in the project's folder until somebody accepts or discards it; a killed process loses nothing.

runs/.new/   all that a run's folder holds but the edits, which are carried over when it is accepted
"""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rgcore.errors import ProjectError
from rgcore.model import folder
from rgcore.model.disk import sync_folder
from rgcore.model.folder import RunInfo
from rgcore.model.history import AnyEntry
from rgcore.model.outcome import Outcome
from rgcore.model.records import RGMap
from rgcore.slam.trajectory import Trajectory

if TYPE_CHECKING:
    from rgcore.pipeline import Run

_NAME = ".new"


class Staged(NamedTuple):
    """What a plan needs to know of the run that waits."""

    map: RGMap
    trajectory: Trajectory
    info: RunInfo


def stage(path: Path, run: Run) -> None:
    """Let ``run`` wait in the project at ``path``, instead of one that waited there before. Raises ProjectError.

    The process that holds the project may be another one: nothing that it reads or writes is touched.
    """
    new, ready = path / "runs" / f"{_NAME}.tmp", path / "runs" / _NAME
    try:
        shutil.rmtree(new, ignore_errors=True)
        new.mkdir()
        folder.write_evidence(new, run)
        sync_folder(new)
        shutil.rmtree(ready, ignore_errors=True)
        new.rename(ready)
        sync_folder(path / "runs")
    except BaseException as e:
        shutil.rmtree(new, ignore_errors=True)
        if isinstance(e, OSError):
            raise folder.unwritable(path, e) from e
        raise


def read_staged(path: Path) -> Staged | None:
    """The run that waits in a project; None if there is none. Raises ProjectError if it is damaged."""
    where = path / "runs" / _NAME
    if not where.is_dir():
        return None
    return Staged(folder.read_base(where), folder.read_trajectory(where), folder.read_info(where))


def points_of_staged(path: Path) -> np.ndarray:
    """(K, 2) float32 [m] echoes of the run that waits, in its frame. Raises ProjectError."""
    return folder.read_points(path / "runs" / _NAME)[0]


def accept_staged(path: Path, entries: Sequence[AnyEntry], conflicts: Sequence[Outcome]) -> None:
    """Make the run that waits the current one. Raises ProjectError; the project is then as it was."""
    new, name = path / "runs" / _NAME, folder.next_name(path)
    if not new.is_dir():
        raise ProjectError(f"{path}: no new run waits there any more; map the log again")
    try:
        folder.write_edits(new, entries, conflicts)
        sync_folder(new)
        folder.make_current(path, new, name)
    except OSError as e:
        with contextlib.suppress(OSError):
            (path / "runs" / name).rename(new)
        raise folder.unwritable(path, e) from e


def discard(path: Path) -> None:
    """Remove the run that waits, and what an interrupted ``stage`` left; nothing else changes."""
    new, ready = path / "runs" / f"{_NAME}.tmp", path / "runs" / _NAME
    shutil.rmtree(new, ignore_errors=True)
    with contextlib.suppress(OSError):  # none waits
        ready.rename(new)  # at once: half of a run is none
    shutil.rmtree(new, ignore_errors=True)
