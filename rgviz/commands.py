"""Every command once: the table feeds the keys, the command palette, the buttons of the panel and the help text."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rgcore.model.records import REGION_CLASSES
from rgviz.theme import CLASS_TITLES

if TYPE_CHECKING:
    from rgviz.view import View


@dataclass(frozen=True)
class Command:
    """``keys``: "Z", "cmd/ctrl+Z" ... as viser names them, the first one shown; ``run`` acts for who asked."""

    name: str
    title: str
    run: Callable[[View], None]
    keys: tuple[str, ...] = ()


def _relabel(class_: str) -> Callable[[View], None]:
    return lambda view: view.relabel(class_)


COMMANDS: tuple[Command, ...] = (
    Command("undo", "Undo", lambda v: v.undo(), ("cmd/ctrl+Z",)),
    Command("redo", "Redo", lambda v: v.redo(), ("cmd/ctrl+shift+Z", "cmd/ctrl+Y")),
    Command("clear", "Select nothing", lambda v: v.select(()), ("escape",)),
    Command("fit", "Show the whole map", lambda v: v.fit(), ("F",)),
    Command("zoom", "Zoom to the selection", lambda v: v.fit_selection(), ("Z",)),
    Command("turn", "2D / 3D", lambda v: v.turn(), ("V",)),
    Command("rename", "Rename the selection", lambda v: v.edit_name(), ("N",)),
    Command("box", "Make an object of the selected lines", lambda v: v.make_object(), ("B",)),
    Command("delete", "Delete the selected gateway or object", lambda v: v.delete(), ("delete", "backspace")),
    *(
        Command(f"class-{c}", f"Relabel the region as {c} ({CLASS_TITLES[c]})", _relabel(c), (str(n),))
        for n, c in enumerate(REGION_CLASSES, 1)
    ),
)
BY_NAME = {c.name: c for c in COMMANDS}


def split_key(key: str) -> tuple[str, str | None]:
    """``cmd/ctrl+shift+Z`` as ("Z", "cmd/ctrl+shift")."""
    modifier, _, letter = key.rpartition("+")
    return letter, modifier or None


def spoken(key: str) -> str:
    """A key as people write it: ``Ctrl+Shift+Z``."""
    words = {"cmd/ctrl": "Ctrl", "shift": "Shift", "escape": "Esc", "delete": "Del", "backspace": "Backspace"}
    return "+".join(words.get(part, part.upper()) for part in key.split("+"))
