"""A log becomes a project, or a new run of one that is there; edits are kept and stage results reused."""

from __future__ import annotations

import shutil
from pathlib import Path

from rgcore import pipeline
from rgcore.cache import Cache
from rgcore.config import Config
from rgcore.model import folder
from rgcore.model.project import Project
from rgcore.progress import Watcher, silent
from rgcore.scans.log import ScanLog


def map_into(path: Path, log: ScanLog, config: Config, watch: Watcher = silent) -> Project:
    """Map ``log`` into the project at ``path`` and open it; edits of an earlier run are kept.

    The stage cache lies in the project, so a second run computes only what its settings change. Whatever stops a first
    run (an error, Ctrl+C) leaves nothing behind. Raises RgError.
    """
    if Project.exists(path):
        with Project.open(path) as project:
            project.must_write()  # tell what is wrong with it before the work, not after
        result = pipeline.run(log, config, Cache(path / "cache"), watch)
        return _one_more(path, result)
    folder.claim(path)
    try:
        return Project.create(path, pipeline.run(log, config, Cache(path / "cache"), watch))
    except BaseException:
        shutil.rmtree(path, ignore_errors=True)
        raise


def _one_more(path: Path, result: pipeline.Run) -> Project:
    project = Project.open(path)
    try:
        project.add_run(result)
    except BaseException:
        project.close()
        raise
    return project
