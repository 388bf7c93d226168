"""The sheet of all commands and the help page: both from the one table, so that neither can tell of another."""

from __future__ import annotations

from html import escape
from pathlib import Path

from rgviz.commands import COMMANDS, Command, spoken

PLACE = "<!-- commands -->"
"""where the page has room for the table"""


def sheet() -> str:
    """All commands with their keys, group by group, as HTML."""
    groups: dict[str, list[Command]] = {}
    for c in COMMANDS:
        groups.setdefault(c.group, []).append(c)
    return "".join(
        f"<section><h3>{escape(name)}</h3><table>{''.join(map(_row, commands))}</table></section>"
        for name, commands in groups.items()
    )


def help_page(static: Path) -> str:
    """``help.html`` of the folder of static files, with the table in it."""
    return (static / "help.html").read_text(encoding="utf-8").replace(PLACE, sheet())


def _row(command: Command) -> str:
    keys = " ".join(f"<kbd>{escape(spoken(k))}</kbd>" for k in command.keys)
    return f"<tr><td>{keys}</td><td>{escape(command.title)}</td></tr>"
