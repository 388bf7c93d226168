"""A log becomes a project, or a new run of one that is there; edits are kept and stage results reused."""

from __future__ import annotations

import shutil
from pathlib import Path

from rgcore import pipeline
from rgcore.cache import Cache
from rgcore.config import Config
from rgcore.model import folder
from rgcore.model.project import Project
from rgcore.model.staged import stage
from rgcore.progress import Progress, Watcher, silent
from rgcore.scans.log import ScanLog

SAVE = Progress("save", 0, 1)
"""What a watcher is told when all is computed: from now on the project is written."""


def map_into(path: Path, log: ScanLog, config: Config, watch: Watcher = silent) -> Project:
    """Map ``log`` into the project at ``path`` and open it; edits of an earlier run are kept.

    The stage cache lies in the project, so a second run computes only what its settings change. Whatever stops a first
    run (an error, Ctrl+C) leaves nothing behind. Raises RgError.
    """
    if Project.exists(path):
        with Project.open(path) as project:
            project.must_write()  # tell what is wrong with it before the work, not after
        result = _run(path, log, config, watch)
        return _one_more(path, result)
    folder.claim(path)
    try:
        return create(path, _run(path, log, config, watch), watch)
    except BaseException:
        shutil.rmtree(path, ignore_errors=True)
        raise


def map_beside(path: Path, log: ScanLog, config: Config, watch: Watcher = silent) -> None:
    """Map ``log`` and let the new run wait in the project at ``path``, whoever holds that. Raises RgError."""
    result = _run(path, log, config, watch)
    watch(SAVE)
    stage(path, result)


def create(path: Path, result: pipeline.Run, watch: Watcher) -> Project:
    """A new project of its first run, open. Raises ProjectError; the folder is then without one."""
    watch(SAVE)
    return Project.create(path, result)


def _run(path: Path, log: ScanLog, config: Config, watch: Watcher) -> pipeline.Run:
    return pipeline.run(log, config, Cache(path / "cache"), watch)


def _one_more(path: Path, result: pipeline.Run) -> Project:
    project = Project.open(path)
    try:
        project.add_run(result)
    except BaseException:
        project.close()
        raise
    return project
