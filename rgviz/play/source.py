"""Which log is played: the one that was given, or that of the project where it is found."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from rgcore.config import Config
from rgcore.model.project import Project
from rgcore.scans.bags import USUAL, Topics
from rgviz.again.settings import config_of
from rgviz.demo import LOG as DEMO


@dataclass(frozen=True)
class Source:
    """A log that can be played. ``project`` is to be made of it; None where that is there, made from ``sha256``."""

    log: Path
    project: Path | None
    config: Config
    topics: Topics = USUAL
    sha256: str | None = None


def find_log(project: Project, given: Source | None) -> tuple[Source | None, str]:
    """The log of a project: the one that was ``given``, or a file of its name beside the project or where we are.

    Whether it is that very log shows when it is read. Without one, a sentence says how to give it.
    """
    name, sha256 = project.run_info.log, project.run_info.sha256
    config = config_of(project.run_info)
    if given is not None:
        return replace(given, project=None, config=config, sha256=sha256), ""
    places = (project.path.parent / name, Path(name), *([DEMO] if name == DEMO.name else []))
    log = next((p for p in places if name and p.exists()), None)
    if log is not None:
        return Source(log, None, config, USUAL, sha256), ""
    why = f"Its log {name or ''} is not here. To play it: rgviz play LOG -o {project.path.name}"
    return None, why
