"""The logs that a browser may choose from. It names one by its number in the list: no text of it becomes a path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rgcore.scans.bags import USUAL, Topics

ENDINGS = (".log", ".clf", ".bag", ".mcap", ".db3", ".npz")
"""Of files beside a project that are offered, gzipped or not; others are named with ``--log``."""
MOST = 40


@dataclass(frozen=True)
class Log:
    """``own``: the log that the current run of the project was made from."""

    path: Path
    topics: Topics = USUAL
    own: bool = False

    @property
    def title(self) -> str:
        return self.path.name


def logs_for(project: Path, own: tuple[Path, Topics] | None, given: Sequence[Path]) -> list[Log]:
    """The project's own log first, then those that were named where the server was started, then what lies beside."""
    out = [Log(*own, own=True)] if own is not None else []
    known = {log.path.resolve() for log in out}
    for path in (*given, *_beside(project)):
        if path.resolve() not in known:
            known.add(path.resolve())
            out.append(Log(path))
    return out


def _beside(project: Path) -> list[Path]:
    try:
        files = sorted(p for p in project.resolve().parent.iterdir() if p.is_file() and _is_log(p))
    except OSError:  # a folder that may not be listed offers nothing
        return []
    return files[:MOST]


def _is_log(path: Path) -> bool:
    return not path.name.startswith(".") and path.name.lower().removesuffix(".gz").endswith(ENDINGS)
