"""What people press to play a log. There once for all browsers of a server: they see the same playback."""

from __future__ import annotations

import time
from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, Any

from rgcore.errors import EditError
from rgviz import theme
from rgviz.markup import wrap
from rgviz.play.player import SPEEDS, Player
from rgviz.play.tape import clock, words

if TYPE_CHECKING:
    from rgviz.play.playback import Playback
    from rgviz.view import View

EVENTS = 6
"""that are listed"""
HELD = 0.7
"""s after a hand moved the slider in which only hands move it"""
LAST = 1e6
"""order of what stands below all others"""
STEPS = {"-10": -10, "-1": -1, "+1": 1, "+10": 10}


class Controls:
    """The folder "Play" of the panel on the right."""

    def __init__(self, playback: Playback) -> None:
        self.playback = playback
        gui = self.gui = playback.app.server.gui
        self.folder = gui.add_folder("Play", visible=False)
        self._moved = 0.0
        with self.folder:
            self._told = gui.add_html("")
            self._start = self._button("Play the log", lambda p: p.start())
            self._toggle = self._button("Play", lambda p: p.toggle())
            self._slider = gui.add_slider("Scan", 1, 2, 1, 1)
            self._steps = gui.add_button_group("Step", tuple(STEPS))
            self._speed = gui.add_dropdown("Speed", SPEEDS, initial_value="4x")
            self._leave = self._button("Back to the map", lambda p: p.leave(), order=LAST)
            self._events = gui.add_html("", order=LAST + 1)  # the lowest: it grows, and nothing may slip from the hand
        self._missing = gui.add_html("", order=LAST)  # below all: most people never want it
        self._playing = (self._toggle, self._slider, self._steps, self._speed, self._events)
        self._follow: dict[int, Any] = {}
        self._on(self._slider, lambda p, value: p.seek(int(value) - 1))
        self._on(self._speed, lambda p, value: p.set_speed(value))

        key = gui.add_command("Play the log, or pause", hotkey="P", modifier="shift")

        @key.on_trigger
        async def _(event: Any) -> None:
            self._post(event.client_id, lambda p: p.toggle())

        @self._steps.on_click
        async def _(event: Any) -> None:
            self._post(event.client_id, lambda p: p.step(STEPS.get(event.target.value, 0)))

    def add_follow(self, view: View) -> None:
        """A choice of one browser: whether its picture goes with the robot."""
        with self.folder:
            box = view.client.gui.add_checkbox("Follow", False, hint="the robot, in this browser", visible=False)
        self._follow[view.client.client_id] = box

        @box.on_update
        async def _(event: Any) -> None:
            if event.client is not None:
                view.post(self.playback.follow, view.client.client_id, bool(box.value))

    def forget(self, client_id: int) -> None:
        """A browser is gone."""
        self._follow.pop(client_id, None)

    def show(self, told: str, start: str | None, player: Player | None, leave: str | None, missing: str = "") -> None:
        """``start`` and ``leave`` are the titles of those buttons, None hides them; without a player there is none.
        ``missing``: why the log cannot be played."""
        _set(self.folder, visible=bool(told or start or player or leave))
        _set(self._missing, content=missing)
        _set(self._told, content=told)
        _set(self._start, visible=start is not None)
        _set(self._leave, visible=leave is not None)
        if start is not None:
            _set(self._start, label=start)
        if leave is not None:
            _set(self._leave, label=leave)
        for part in (*self._playing, *self._follow.values()):
            _set(part, visible=player is not None)
        if player is not None:
            _set(self._events, content=events(player))
            _set(self._toggle, label="Pause" if player.busy else "Play")
            _set(self._speed, value=player.speed)
            _set(self._slider, max=max(player.tape.total, 2))
            if time.monotonic() - self._moved > HELD:
                _set(self._slider, value=max(player.at, 0) + 1)

    # ---- parts ------------------------------------------------------------------------------------

    def _button(self, title: str, press: Callable[[Playback], None], order: float | None = None) -> Any:
        button = self.gui.add_button(title, order=order)

        @button.on_click
        async def _(event: Any) -> None:
            self._post(event.client_id, press)

        return button

    def _on(self, part: Any, moved: Callable[[Playback, Any], None]) -> None:
        """What a hand does; what the app sets itself is not heard."""

        @part.on_update
        async def _(event: Any) -> None:
            if event.client is not None:
                value = part.value
                self._post(event.client_id, lambda p: moved(p, value), part is self._slider)

    def _post(self, client_id: int, press: Callable[[Playback], None], slides: bool = False) -> None:
        self.playback.app.ask(client_id, lambda view: self._press(view, press, slides))

    def _press(self, view: View, press: Callable[[Playback], None], slides: bool) -> None:
        """All browsers see the same playback: one that came to look does not take the map from the others."""
        if view.guest:
            self.playback.refresh()
            raise EditError("This link is for looking. What is played is chosen in the other one; Follow works here.")
        if slides:
            self._moved = time.monotonic()
        press(self.playback)


def told(player: Player, names: dict[str, str]) -> str:
    """State, region and time, as HTML."""
    tape, at = player.tape, player.at
    if at < 0:
        return wrap('<div class="rg-h" id="rg-play">Starting ...</div>')
    state, region = tape.place(at)
    where = "a region not known yet" if region is None else " ".join(filter(None, (region, names.get(region))))
    end = clock(float(tape.times[-1]))
    goal = "" if player.goal is None else f", mapping up to {clock(float(tape.times[player.goal]))}"
    note = f'<div class="muted">{escape(tape.note)}</div>' if tape.note else ""
    return wrap(
        f'<div class="rg-h" id="rg-play">{state}<small>{escape(where)}</small></div>'
        f"{clock(float(tape.times[at]))} of {end}"
        f'<span class="muted">, scan {at + 1:,} of {tape.total:,}{goal}</span>'
        f"{_bar(len(tape) / tape.total, (at + 1) / tape.total)}{note}"
    )


def events(player: Player) -> str:
    """The last events, as HTML."""
    tape, at = player.tape, player.at
    rows = "".join(
        f'<tr><td class="n">{clock(float(tape.times[e.scan]))}</td><td class="wide">{escape(words(e))}</td></tr>'
        for e in (tape.last_events(at, EVENTS) if at >= 0 else ())
    )
    return wrap(f'<table id="rg-events">{rows}</table>')


def _bar(mapped: float, shown: float) -> str:
    """How much is mapped, and how much of that was on show."""
    shares = ((mapped, theme.over_white(theme.BRAND)), (shown, theme.BRAND))
    bars = "".join(f'<i style="width:{100 * share:.1f}%;background:{theme.css(color)}"></i>' for share, color in shares)
    return f'<div class="bar" title="mapped, and shown">{bars}</div>'


def _set(part: Any, **values: Any) -> None:
    """Set what is another value: each assignment goes to every browser."""
    for name, value in values.items():
        if getattr(part, name) != value:
            setattr(part, name, value)
