"""The hands of one browser: which tool they hold, what they do with it, what the page shows meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import msgspec

from rgcore.errors import EditError, RgError
from rgcore.model.records import RGMap
from rgviz.bridge import Answer, Pointer
from rgviz.selecting import Items
from rgviz.tools.adjusting import Adjust, Drag
from rgviz.tools.tool import Hand, Question, Sketch, Tool, Turn

if TYPE_CHECKING:
    from rgviz.view import View


class Hands:
    """All methods but ``hear`` run on the editor's thread."""

    def __init__(self, view: View) -> None:
        self.view = view
        self.tool: Tool = Adjust()
        self._sketch: Sketch | None = None
        self._question: Question | None = None
        self._asked = 0
        self._waiting: list[Pointer] | None = None

    @property
    def busy(self) -> bool:
        """Whether a tool takes what is pressed on the picture."""
        return self.tool.grab

    def hear(self, pointer: Pointer) -> None:
        """On the server's thread: a move that waits for its turn is overtaken by the next one."""
        if pointer.kind != "move":
            self._waiting = None
            self.view.post(self._do, pointer)
        elif (waiting := self._waiting) is not None:
            waiting[0] = pointer
        else:
            self._waiting = [pointer]
            self.view.post(self._moved, self._waiting)

    def take(self, tool: Tool | None) -> None:
        """Hold this tool; none: what is selected can be dragged."""
        self.tool = tool or Adjust(self.view.selection)
        self.show()

    def finish(self) -> None:
        """Enter."""
        self._turn(lambda tool, m: tool.finish(m))

    def back(self) -> bool:
        """Backspace or Delete; False where the tool has no use for it."""
        turn = self.tool.back(self.view.map)
        if turn is not None:
            self._take_turn(turn)
        return turn is not None

    def cancel(self) -> bool:
        """Esc; False where no tool was held."""
        if isinstance(self.tool, Adjust):
            return False
        self.take(self.tool.cancel())
        return True

    def selected(self, items: Items) -> None:
        self.tool = self.tool.selected(items)
        self.show()

    def map_changed(self) -> None:
        """A tool whose item is gone lets go of it, and says so."""
        kept = self.tool.kept(self.view.map)
        if kept is None:
            self.view.tell("Put away", f"{self.tool.title or 'What you held'}: it is not in the map any more.")
        self.take(None if kept is None else kept.selected(self.view.selection))

    def ask(self, question: Question, value: str = "") -> None:
        """A line of text, at a place of the map."""
        self._question, self._asked = question, self._asked + 1
        x, y = question.at
        self.view.bridge.tell("ask", question=self._asked, label=question.label, x=x, y=y, value=value)

    def answer(self, answer: Answer) -> None:
        question, self._question = self._question, None
        if question is not None and answer.question == self._asked and answer.value and answer.value.strip():
            self.view.do(question.then(self.view.map, answer.value.strip()))

    def show(self) -> None:
        """Tell the page what the tool looks like, if that is another picture than before."""
        sketch = Sketch() if self.view.read_only and not self.tool.grab else self.tool.sketch(self.view.map)
        if sketch != self._sketch:
            self._sketch = sketch
            self.view.bridge.tell("sketch", **msgspec.to_builtins(sketch))

    # ---- parts ------------------------------------------------------------------------------------

    def _moved(self, waiting: list[Pointer]) -> None:
        if self._waiting is waiting:
            self._waiting = None
        self._do(waiting[0])
        self.view.bridge.tell("drawn")

    def _do(self, pointer: Pointer) -> None:
        hand = Hand((pointer.x, pointer.y), pointer.pixel, pointer.handle, pointer.shift, pointer.ctrl)
        self._turn(lambda tool, m: getattr(tool, pointer.kind)(m, hand))

    def _turn(self, do: Callable[[Tool, RGMap], Turn]) -> None:
        try:
            turn = do(self.tool, self.view.map)
        except EditError:
            self._put_back()
            raise
        self._take_turn(turn)

    def _take_turn(self, turn: Turn) -> None:
        before, self.tool = self.tool, turn.tool or Adjust(self.view.selection)
        if turn.edit is not None:
            try:
                self.view.do(turn.edit)
            except RgError:
                self.tool = before
                self._put_back()
                raise
        if turn.select is not None:
            self.view.select(turn.select)
        if turn.ask is not None:
            self.ask(turn.ask)
        self.show()

    def _put_back(self) -> None:
        """After a refusal: a drag is over, what is drawn so far stays to be mended."""
        if isinstance(self.tool, Drag):
            self.tool = Adjust(self.view.selection)
        self.show()
