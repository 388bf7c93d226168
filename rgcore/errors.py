"""Every error that the library raises on purpose, drawn once.

RgError                     one line for a person: what is wrong, where, and the remedy
├── InputError              a file that cannot be read: names the file and, where there is one, the line
├── SettingError            a setting that does not exist or is out of bounds: names the setting
├── EditError               an edit that the map refuses: a sentence that says why
├── ProjectError            a project folder that cannot be opened or written
└── QueryError              a question to a map about a place that is not there
    └── NoRoute             no way from one place to another: a sentence that says why
"""

from __future__ import annotations

from pathlib import Path


class RgError(Exception):
    """Base of all errors that are a message to the user rather than a bug."""


class InputError(RgError):
    """A file that cannot be used: ``office.log:17: <what is wrong>; <remedy>``."""

    def __init__(self, path: str | Path, message: str, line: int | None = None) -> None:
        where = f"{path}:{line}" if line is not None else f"{path}"
        super().__init__(f"{where}: {message}")
        self.path, self.line = Path(path), line


class SettingError(RgError):
    """A setting that does not exist or whose value is out of bounds."""


class EditError(RgError):
    """An edit that the map refuses; the text is a sentence meant for the person who made it."""


class ProjectError(RgError):
    """A project folder that cannot be opened, locked or written."""


class QueryError(RgError):
    """A question to a map about a place that is not there."""


class NoRoute(QueryError):
    """There is no way from one place to another; the text is a sentence that says why."""


def one_line(e: BaseException) -> str:
    """What an error says, in one line; of the system's errors the file and the reason."""
    if isinstance(e, OSError) and e.filename is not None:
        return f"{e.filename}: {e.strerror}"
    return " ".join(str(e).split())
