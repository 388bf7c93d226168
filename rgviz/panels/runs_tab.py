"""The tab of the runs: map the log again, what becomes of the edits, what waits, what is different between runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from rgcore.errors import EditError
from rgcore.model.outcome import LEAVE, Outcome
from rgviz import status
from rgviz.again import words
from rgviz.again.looking import Looking
from rgviz.again.settings import settings, value_of, with_values
from rgviz.panels.tab import Doer, Tab

if TYPE_CHECKING:
    from rgviz.view import View

AROUND = 3.0
"""m that are shown around the place of an outcome or a difference"""


class RunsTab(Tab):
    """What the form holds (which log, which settings) is this browser's alone; what runs and waits is everybody's."""

    title = "Runs"

    def __init__(self, view: View) -> None:
        super().__init__(view)
        self.log = 0
        self.text = ""
        self.values: dict[str, str] = {}
        self._built: tuple[Any, ...] = ()

    @property
    def doers(self) -> Mapping[str, Doer]:
        return {
            "log": self._choose_log,
            "setting": self._add_setting,
            "unset": self._drop_setting,
            "start": self._start,
            "cancel": self._cancel,
            "accept": self._accept,
            "discard": self._discard,
            "which": self.looking.choose,
            "place": self._go_to_outcome,
            "choose": self._choose,
            "wait-place": self._go_to_waiting,
            "settle": self._settle,
            "compare": self._compare,
            "difference": self._go_to_difference,
        }

    @property
    def looking(self) -> Looking:
        return self.view.looking

    def build(self) -> None:
        app, gui = self.view.app, self.parts.gui
        self._built = self._shape
        self._pin(True)
        if app.session is None:
            self.parts.html(lambda: words.wrap('<p class="muted">The map is being made.</p>'))
            return
        again = app.again
        self.parts.html(lambda: words.run(app.opened.project))
        if again.staged is not None:
            with self.parts.add(gui.add_folder("New run")):
                self.parts.html(
                    lambda: words.proposal(again.outcomes, again.choices, self.looking.which, again.ready, self._may)
                )
        if self._waiting:
            with self.parts.add(gui.add_folder("Edits that wait")):
                self.parts.html(lambda: words.waiting(self._waiting, self._may))
        if again.job is not None:
            with self.parts.add(gui.add_folder("Mapping again")):
                self.parts.html(lambda: words.mapping(again.what, status.progress(again.pace), self._may))
        elif self._may:
            with self.parts.add(gui.add_folder("Map again", expand_by_default=again.staged is None)):
                self._build_form()
        if app.others.titles:
            with self.parts.add(gui.add_folder("Compare")):
                self.parts.html(
                    lambda: words.comparing(
                        app.others.titles, self.looking.compared, self.looking.comparison, app.others.trouble
                    )
                )

    def refresh(self) -> None:
        if self._built != self._shape:
            self.view.panels.open_tab(self.title)
        else:
            self.parts.refresh()

    def close(self) -> None:
        self._pin(False)
        super().close()

    def _pin(self, on: bool) -> None:
        """The places of the edits are marked on the map while they are listed here."""
        self.looking.pinned = on
        self.looking.show_pins()

    # ---- the form ---------------------------------------------------------------------------------

    def _build_form(self) -> None:
        again = self.view.app.again
        self.parts.html(lambda: words.logs(again.logs, self.log))
        if not again.logs:
            return
        for name in self.values:
            label = f"{name.replace('.', ' ').replace('_', ' ')} [{settings()[name].unit}]"
            self.parts.text(label, self._getter(name), self._setter(name))
        if self.values:
            self.parts.html(lambda: words.chosen_settings(again.config, self.values))
        self.field = self.parts.text("Find a setting", lambda: self.text, self._search)
        self.parts.html(lambda: words.found_settings(again.config, self.text, self.values))
        self.parts.html(lambda: words.start(again.trouble))

    def _getter(self, name: str) -> Callable[[], str]:
        return lambda: self.values[name]

    def _setter(self, name: str) -> Doer:
        def put(text: str) -> None:
            with_values(self.view.app.again.config, {name: text})
            self.values[name] = text

        return put

    def _search(self, text: str) -> None:
        self.text = text

    def _choose_log(self, number: str) -> None:
        self.log = _number(number, len(self.view.app.again.logs))

    def _add_setting(self, name: str) -> None:
        if name not in settings():
            raise EditError("there is no such setting")
        self.values.setdefault(name, value_of(self.view.app.again.config, name))

    def _drop_setting(self, name: str) -> None:
        self.values.pop(name, None)

    def _start(self, _: str) -> None:
        self.view.must_edit()
        self.view.app.again.start(self.log, self.values)

    def _cancel(self, _: str) -> None:
        self.view.must_edit()
        self.view.app.again.cancel()

    # ---- what becomes of the edits ----------------------------------------------------------------

    def _accept(self, _: str) -> None:
        self.view.must_edit()
        self.looking.choose("now")
        self.view.app.again.accept()
        self.values = {}

    def _discard(self, _: str) -> None:
        self.view.must_edit()
        self.view.app.again.discard()

    def _go_to_outcome(self, key: str) -> None:
        self._go(self._outcome(key))

    def _choose(self, arg: str) -> None:
        """``"0001/3 1"``: the second remedy of that edit; ``leave``: it shall wait; ``plan``: as the plan says."""
        self.view.must_edit()
        key, _, what = arg.partition(" ")
        outcome, again = self._outcome(key), self.view.app.again
        if what == "plan":
            again.choose(outcome, None)
        elif what == LEAVE:
            again.choose(outcome, LEAVE)
        else:
            again.choose(outcome, outcome.remedies[_number(what, len(outcome.remedies))])

    def _go_to_waiting(self, key: str) -> None:
        self._go(_find(self._waiting, key))

    def _settle(self, arg: str) -> None:
        """``"0001/3 1"``: an edit that waits is settled by its second remedy."""
        key, _, number = arg.partition(" ")
        outcome = _find(self._waiting, key)
        self.view.settle(outcome, outcome.remedies[_number(number, len(outcome.remedies))])

    # ---- what is different ------------------------------------------------------------------------

    def _compare(self, key: str) -> None:
        if key and key not in self.view.app.others.titles:
            raise EditError("that is not there to compare with any more")
        self.looking.compare(key or None)

    def _go_to_difference(self, number: str) -> None:
        comparison = self.looking.comparison
        if comparison is None:
            raise EditError("nothing is being compared any more")
        differences = comparison.diff.differences
        self.view.go_to_place(differences[_number(number, len(differences))].place, AROUND)

    # ---- parts ------------------------------------------------------------------------------------

    @property
    def _may(self) -> bool:
        """Whether this browser may map again and accept, whatever it looks at."""
        return not self.view.guest and not self.view.app.read_only

    @property
    def _waiting(self) -> tuple[Outcome, ...]:
        session = self.view.app.session
        return session.project.conflicts if session is not None else ()

    @property
    def _shape(self) -> tuple[Any, ...]:
        """What decides which widgets there are."""
        app = self.view.app
        again = app.again
        there = (again.job is None, again.staged is None, bool(self._waiting), bool(app.others.titles), self._may)
        return (app.session is None, *there, tuple(self.values))

    def _outcome(self, key: str) -> Outcome:
        return _find(tuple(self.view.app.again.outcomes), key)

    def _go(self, outcome: Outcome) -> None:
        if outcome.place is None:
            raise EditError("Nobody can say where that is in the new map.")
        self.view.go_to_place(outcome.place, AROUND)


def _find(outcomes: tuple[Outcome, ...], key: str) -> Outcome:
    found = next((o for o in outcomes if words.key_of(o) == key), None)
    if found is None:
        raise EditError("that edit waits no more")
    return found


def _number(text: str, count: int) -> int:
    """A number from a browser, below ``count``. Raises EditError."""
    if not (text.isascii() and text.isdigit()) or int(text) >= count:
        raise EditError("that is not on offer any more")
    return int(text)
