"""The session: the open project, one order for everybody's edits, and who must hear of a change."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from rgcore.errors import EditError, RgError
from rgcore.model.edits import AddBackdrop, Edit
from rgcore.model.outcome import Outcome, Remedy
from rgcore.model.project import Project
from rgcore.model.records import RGMap

T = TypeVar("T")
log = logging.getLogger(__name__)

Listener = Callable[[RGMap, RGMap], None]
"""Called with the map before and after; what an edit left alone is the same object in both."""


class Session:
    """A project that browsers look at together. An edit is on the disk before anyone is told of it."""

    def __init__(self, project: Project) -> None:
        self.project = project
        self._lock = threading.Lock()
        self._listeners: list[Listener] = []

    @property
    def map(self) -> RGMap:
        return self.project.map

    @property
    def undo_title(self) -> str | None:
        return self.project.history.undo_title

    @property
    def redo_title(self) -> str | None:
        return self.project.history.redo_title

    def listen(self, listener: Listener) -> None:
        self._listeners.append(listener)

    def do(self, edit: Edit, by: str | None = None) -> None:
        """Make an edit. Raises EditError or ProjectError with a sentence for a person; nothing is changed then."""
        self._step(lambda: self.project.do(edit, by))

    def lay(self, edit: AddBackdrop, data: bytes, by: str | None = None) -> None:
        """Lay a floor plan, whose file is ``data``, under the map. Raises as ``do``."""
        self._step(lambda: self.project.lay(edit, data, by))

    def undo(self, by: str | None = None) -> None:
        self._step(lambda: self.project.undo(by))

    def redo(self, by: str | None = None) -> None:
        self._step(lambda: self.project.redo(by))

    def settle(self, outcome: Outcome, remedy: Remedy, by: str | None = None) -> None:
        """Settle an edit that waits since a new run."""
        self._step(lambda: self.project.settle(outcome, remedy, by))

    def back_to(self, number: int, by: str | None = None) -> None:
        """The map after ``number`` edits of the history, those that were undone counted on: one step for who looks on.

        Raises EditError if there are not so many, or if one of them cannot be made again; what went before stays.
        """
        self._step(lambda: self._walk(number, by))

    def _walk(self, number: int, by: str | None) -> RGMap:
        history = self.project.history
        if not 0 <= number <= len(history.done) + len(history.undone):
            raise EditError("there is no such edit in the history any more")
        while (stands := len(self.project.history.done)) != number:
            if stands > number:
                self.project.undo(by)
            else:
                self.project.redo(by)
        return self.project.map

    def _step(self, step: Callable[[], RGMap]) -> None:
        with self._lock:
            before, history = self.project.map, self.project.history
            after = step()
            if self.project.history is not history:  # an edit of an older run that is let go changes nothing else
                for listener in self._listeners:
                    listener(before, after)


class Latest(Generic[T]):
    """Something made of the map, kept as long as the map is the same object: for what several browsers need."""

    def __init__(self, make: Callable[[RGMap], T]) -> None:
        self._make = make
        self._last: tuple[RGMap, T] | None = None

    def __call__(self, map_: RGMap) -> T:
        if self._last is None or self._last[0] is not map_:
            self._last = (map_, self._make(map_))
        return self._last[1]


class Worker:
    """One thread that does what the browsers ask for, in the order in which they asked."""

    def __init__(self) -> None:
        self._tasks: queue.SimpleQueue[tuple[Callable[..., None], tuple[Any, ...], Refused | None] | None]
        self._tasks = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, name="rgviz editor", daemon=True)
        self._thread.start()

    def post(self, task: Callable[..., None], *args: Any, refused: Refused | None = None) -> None:
        """Run ``task(*args)`` after all that was posted before; ``refused`` is told, in words, if it cannot be."""
        self._tasks.put((task, args, refused))

    def finish(self) -> None:
        """Let what was posted be done, then end."""
        self._tasks.put(None)
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=10)

    def wait(self) -> None:
        """Return when all that was posted before is done."""
        done = threading.Event()
        self.post(done.set)
        done.wait(timeout=30)

    def _work(self) -> None:
        while (item := self._tasks.get()) is not None:
            task, args, refused = item
            try:
                task(*args)
            except RgError as e:
                if refused is not None:
                    refused(str(e))
            except Exception:
                log.exception("a task of the editor failed")
                if refused is not None:
                    refused("That did not work: a fault in rgviz. The terminal says more.")


Refused = Callable[[str], None]
