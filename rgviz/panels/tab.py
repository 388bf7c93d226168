"""What the tabs of the left panel have in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from rgviz.panels.parts import Parts

if TYPE_CHECKING:
    from rgviz.view import View

Doer = Callable[[str], None]
"""Does what a button of ours asks for, told its ``data-arg``. Raises EditError for what makes no sense."""


class Tab:
    """A tab: nothing of it is made or refreshed while it is not open."""

    title = ""

    def __init__(self, view: View) -> None:
        self.view, self.parts = view, Parts(view)

    @property
    def doers(self) -> Mapping[str, Doer]:
        """What its buttons do, by name."""
        return {}

    def build(self) -> None:
        """Put the widgets in place, inside of the panel."""

    def commit(self, field: str, value: str) -> bool:
        """A field is finished; False if it is none of this tab's."""
        return self.parts.commit(field, value)

    def refresh(self) -> None:
        self.parts.refresh()

    def close(self) -> None:
        self.parts.clear()
