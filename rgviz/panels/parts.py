"""Parts that panels are made of: HTML that follows the map, fields that count when they are finished, small buttons.

Our own HTML acts through ``data-do`` and ``data-arg``: the page reports what was pressed (``bridge.Press``), and the
panel that made it knows what to do.
"""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, Any

from rgcore.errors import EditError
from rgviz.commands import BY_NAME, Command, spoken

if TYPE_CHECKING:
    from rgviz.view import View

Committed = Callable[[str], None]
"""Called with the finished text of a field."""


class Parts:
    """Widgets of a panel that are built, refreshed and removed together."""

    def __init__(self, view: View) -> None:
        self.view, self.gui = view, view.client.gui
        self._parts: list[Any] = []
        self._fields: dict[str, Committed] = {}
        self._refreshers: list[Callable[[], None]] = []

    def clear(self) -> None:
        for part in reversed(self._parts):  # a folder takes what is in it along
            part.remove()
        self._parts, self._fields, self._refreshers = [], {}, []

    def refresh(self) -> None:
        """Show the map as it is now."""
        for refresh in self._refreshers:
            refresh()

    def commit(self, field: str, value: str) -> bool:
        """A field is finished; False if it is none of these."""
        if field not in self._fields:
            return False
        self._fields[field](value)
        return True

    def add(self, part: Any) -> Any:
        self._parts.append(part)
        return part

    def html(self, content: Callable[[], str]) -> Any:
        """HTML that is sent again when it has become another."""
        handle = self.add(self.gui.add_html(content()))
        self.follow(lambda: set_html(handle, content()))
        return handle

    def text(self, label: str, read: Callable[[], str], committed: Committed, visible: bool = True) -> Any:
        handle = self.add(self.gui.add_text(label, read(), visible=visible))
        self._fields[handle._impl.uuid] = committed
        self.follow(lambda: setattr(handle, "value", read()))
        return handle

    def number(self, label: str, value: float, committed: Committed, step: float = 0.001) -> Any:
        handle = self.add(self.gui.add_number(label, value, step=step))
        self._fields[handle._impl.uuid] = committed
        return handle

    def follow(self, refresh: Callable[[], None]) -> None:
        self._refreshers.append(refresh)


def set_html(handle: Any, content: str) -> None:
    """Nothing is sent for what stands there already."""
    if handle.content != content:
        handle.content = content


def press(do: str, arg: str, html: str, kind: str = "", hint: str = "") -> str:
    """A button of our own HTML; ``html`` is its face and must be escaped already."""
    title = f' title="{escape(hint)}"' if hint else ""
    return f'<button class="{kind}" data-do="{do}" data-arg="{escape(arg)}"{title}>{html}</button>'


def command_button(command: Command, title: str | None = None) -> str:
    key = f"<kbd>{escape(spoken(command.keys[0]))}</kbd>" if command.keys else ""
    return press(
        "command", command.name, f"{escape(title or command.title)} {key}", "cmd", command.title if title else ""
    )


def command_named(name: str) -> Command:
    """Raises EditError for a name that no command has: it came from a browser."""
    if name not in BY_NAME:
        raise EditError("there is no such command")
    return BY_NAME[name]


def number_of(text: str, label: str) -> float:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        raise EditError(f"{label} must be a number, not '{text[:20]}'") from None
