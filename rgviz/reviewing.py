"""The way through the work list in one browser: what is doubted most comes first, a key says yes or no."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from rgcore.model.doubt import Doubt, next_after
from rgcore.model.edits import Edit
from rgcore.model.records import RGMap
from rgviz import actions
from rgviz.selecting import Items

if TYPE_CHECKING:
    from rgviz.view import View


class Reviewing:
    """All methods run on the editor's thread."""

    def __init__(self, view: View) -> None:
        self.view = view

    def next(self, step: int = 1) -> None:
        """Select and show the item of the work list after (or before) the selected one, and say what is doubted."""
        doubts = self._doubts
        self._show(next_after(doubts if step > 0 else doubts[::-1], self._one))

    def confirm(self) -> None:
        """What is selected is right; from an item of the work list, go on to the next."""
        self._judge(lambda _, items: actions.confirm(items))

    def reject(self) -> None:
        """What is selected is not there; from an item of the work list, go on to the next."""
        self._judge(actions.delete)

    @property
    def _doubts(self) -> list[Doubt]:
        return self.view.app.doubts(self.view.map)

    @property
    def _one(self) -> str | None:
        items = self.view.selection
        return items[0].id if len(items) == 1 else None

    def _judge(self, action: Callable[[RGMap, Items], Edit]) -> None:
        before, one = self._doubts, self._one
        places = [n for n, d in enumerate(before) if d.item == one]
        self.view.act(action)
        if places:
            left = {d.item: d for d in self._doubts}  # what is taken away may take others along
            order = (*before[places[0] + 1 :], *before[: places[0]])
            self._show(next((left[d.item] for d in order if d.item in left), None))

    def _show(self, doubt: Doubt | None) -> None:
        if doubt is None:
            self.view.bridge.tell("say", text="Nothing left to check.")
            return
        self.view.go_to([doubt.item])
        left = self._doubts
        number = [d.item for d in left].index(doubt.item) + 1
        text = f"{number} of {len(left)} to check: {doubt.item} - {'; '.join(doubt.reasons)}"
        self.view.bridge.tell("say", text=text)
