"""What the tab of the runs says, as HTML. Every word that came from a person or a file is escaped."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

from rgcore.config import Config
from rgcore.model.diff_text import TITLES as KINDS
from rgcore.model.outcome import LEAVE, Choice, Outcome
from rgcore.model.project import Project
from rgviz import theme
from rgviz.again.comparing import COLORS, TITLES, Comparison
from rgviz.again.kinds import KIND_COLORS, by_need
from rgviz.again.logs import Log
from rgviz.again.settings import search, settings, value_of
from rgviz.markup import wrap
from rgviz.panels.parts import press
from rgviz.status import STAGES

if TYPE_CHECKING:
    from rgviz.again.again import Again

MOST = 6
"""settings that a search shows"""
MOST_ROWS = 120
"""outcomes or differences of a kind that are listed"""
MEANS = {
    "applied": "made as before",
    "shifted": "made, but look at it",
    "conflict": "the new map contradicts it: it waits for you",
    "stale": "what it is about is not there: it waits for you",
}
LOOKS = {"now": "Map as it is", "new": "New run", "both": "Both"}


def run(project: Project) -> str:
    """Which run is on show, and what it was made with."""
    info = project.run_info
    own = ", ".join(f"{k} = {v}" for k, v in info.settings.items()) or "default settings"
    return wrap(
        f'<div class="rg-h">Run {int(project.run_name)}<small>of {escape(info.log)}, {info.scans:,} scans</small></div>'
        f'<p class="muted">{escape(own)}</p>'
    )


def status(again: Again) -> str:
    """One line above everything, in every browser: how far a new run is."""
    if again.job is not None:
        r = again.pace.report
        share = f" {100 * r.done / r.total:.0f} %" if r is not None and r.total > 1 else ""
        told = f"Mapping again: {STAGES.get(r.stage, r.stage).lower() if r is not None else 'starting'}{share}"
    elif again.staged is not None:
        told = "A new run waits to be looked at."
    else:
        return ""
    return wrap(f'<div class="rg-h">{escape(told)} {press("tab", "Runs", "Runs", "cmd")}</div>')


def logs(choices: Sequence[Log], chosen: int) -> str:
    """The logs on offer, one of them chosen."""
    rows = "".join(
        press(
            "log",
            str(n),
            f"<b>{escape(log.title)}</b><small>{'the log of this map' if log.own else 'another log'}</small>",
            "row on" if n == chosen else "row",
        )
        for n, log in enumerate(choices)
    )
    none = '<p class="error">Its log is not here. Start rgviz with <code>--log LOG</code>, or put it beside.</p>'
    return wrap(rows or none)


def found_settings(config: Config, text: str, chosen: Mapping[str, str]) -> str:
    """The settings that a search finds: a click takes one into the form."""
    if not text.strip():
        return wrap('<p class="muted">by a word: <code>gap</code>, <code>noise</code>, <code>region</code>. Enter.</p>')
    found = [s for s in search(text) if s.name not in chosen]
    rows = ""
    for s in found[:MOST]:
        value, usual = value_of(config, s.name), value_of(Config(), s.name)
        now = value if value == usual else f"{value} (default {usual})"
        face = f"<b>{escape(s.name)}</b> {escape(now)} {escape(s.unit)}<small>{escape(s.reason)}</small>"
        rows += press("setting", s.name, face, "row", "set it for the new run")
    more = f'<p class="muted">and {len(found) - MOST} more</p>' if len(found) > MOST else ""
    return wrap((rows + more) or '<p class="muted">no setting of that name</p>')


def chosen_settings(config: Config, values: Mapping[str, str]) -> str:
    """What the chosen settings mean, and how to let go of them."""
    rows = ""
    for name in values:
        s = settings()[name]
        told = f"{value_of(config, name)} now, {value_of(Config(), name)} by default"
        bounds = f"; {s.bounds}" if s.bounds else ""
        rows += (
            f'<div class="finding"><b>{escape(name)}</b><small> {escape(told + bounds)}</small> '
            f"{press('unset', name, '×', 'cmd', 'as it is now')}</div>"
        )
    return wrap(rows)


def start(trouble: str) -> str:
    why = f'<p class="error">{escape(trouble)}</p>' if trouble else ""
    go = press("start", "", "Map again", "cmd main", "in a process of its own; the map can be edited meanwhile")
    return wrap(f'{why}<div class="cmds">{go}</div>')


def mapping(what: str, progress: str, may: bool) -> str:
    """How far the mapping is; the map can be edited meanwhile."""
    stop = press("cancel", "", "Cancel", "cmd", "all stays as it is") if may else ""
    return progress + wrap(f'<p class="muted">{escape(what)}. You can go on editing.</p><div class="cmds">{stop}</div>')


def proposal(outcomes: Sequence[Outcome], choices: Mapping[int, Choice], which: str, ready: bool, may: bool) -> str:
    """What becomes of each edit, what can be decided about it, and the decision on the whole."""
    if not ready and not outcomes:
        return wrap('<p class="muted">The new run is there. Looking at what becomes of the edits ...</p>')
    looks = "".join(press("which", k, title, "chip on" if k == which else "chip") for k, title in LOOKS.items())
    rows, decided = "", {key_of(outcomes[n]): choice for n, choice in choices.items()}
    numbers = {key_of(o): n for n, o in enumerate(by_need(outcomes), 1)}
    for kind in KIND_COLORS:
        some = [o for o in outcomes if o.kind == kind]
        if some:
            listed = "".join(_outcome(o, numbers[key_of(o)], decided.get(key_of(o)), may) for o in some[:MOST_ROWS])
            opened = " open" if kind != "applied" or len(some) <= 3 else ""
            head = f"{_dot(theme.css(KIND_COLORS[kind]))}<b>{len(some)} {kind}</b> <small>{MEANS[kind]}</small>"
            rows += f"<details{opened}><summary>{head}</summary>{listed}{_more(some)}</details>"
    rows = rows or '<p class="muted">There are no edits to carry over.</p>'
    buttons = ""
    if may:
        face = "Accept the new run" if ready else "Looking at the last edit ..."
        buttons = press("accept", "", face, "cmd main", "it becomes the current run; undo goes on as before")
        buttons += press("discard", "", "Discard it", "cmd", "all stays as it is")
    return wrap(f'<div class="cmds">{buttons}</div><div class="chips">{looks}</div>{rows}')


def waiting(outcomes: Sequence[Outcome], may: bool) -> str:
    """Edits that a new run could not take over, with what can be done about each."""
    rows = ""
    for number, o in enumerate(by_need(outcomes)[:MOST_ROWS], 1):
        faces = (press("settle", f"{key_of(o)} {n}", escape(r.name), "cmd") for n, r in enumerate(o.remedies))
        rows += _finding("wait-place", o, number, "".join(faces) if may else "")
    return wrap(rows + _more(outcomes))


def comparing(titles: Mapping[str, str], chosen: str | None, comparison: Comparison | None, trouble: str) -> str:
    """With what to compare, what the colours mean, and every difference."""
    chips = "".join(
        press("compare", "" if k == chosen else k, escape(t), "chip on" if k == chosen else "chip")
        for k, t in titles.items()
    )
    told = ""
    if chosen is not None and comparison is None:
        told = f'<p class="error">{escape(trouble)}</p>' if trouble else '<p class="muted">Comparing ...</p>'
    elif comparison is not None:
        told = _legend(comparison) + _differences(comparison)
    return wrap(f'<div class="chips">{chips}</div>{told}')


def key_of(outcome: Outcome) -> str:
    """What a browser calls an edit by."""
    run, number = outcome.key
    return f"{run}/{number}"


def _outcome(o: Outcome, number: int, choice: Choice | None, may: bool) -> str:
    faces = ""
    if may:
        key = key_of(o)
        options = (
            [(str(n), r.name, r) for n, r in enumerate(o.remedies)] if o.waits else [(LEAVE, "leave it out", LEAVE)]
        )
        for arg, title, meant in options:
            on = choice == meant
            faces += press("choose", f"{key} {'plan' if on else arg}", escape(title), "cmd on" if on else "cmd")
    return _finding("place", o, number, faces)


def _finding(do: str, o: Outcome, number: int, buttons: str) -> str:
    """A row that leads to the place of an edit, and what can be done about it."""
    pin = f'<span class="pin" style="background:{theme.css(KIND_COLORS[o.kind])}">{number}</span>'
    told = f"<small>{escape(o.reason)}</small>" if o.reason else ""
    hint = f"go to ({o.place[0]:.1f}, {o.place[1]:.1f})" if o.place is not None else "nobody can say where that is now"
    row = press(do, key_of(o), f"{pin}<b>{escape(o.title)}</b>{told}", "row", hint)
    return f'<div class="finding">{row}<div class="cmds">{buttons}</div></div>'


def _legend(c: Comparison) -> str:
    counts = c.counts
    rows = "".join(
        f'<span class="key">{_stroke(theme.css(color), colour == "red")}{TITLES[colour]} <b>{counts[colour]}</b></span>'
        for colour, color in COLORS.items()
    )
    lengths = f"walls: {c.diff.walls_added:.1f} m new, {c.diff.walls_removed:.1f} m gone"
    return f'<div class="keys">{rows}</div><p class="muted">{lengths}; {escape(c.diff.frame)}</p>'


def _differences(c: Comparison) -> str:
    out = ""
    for kind, title in KINDS.items():
        some = [(n, d) for n, d in enumerate(c.diff.differences) if d.kind == kind]
        rows = "".join(
            press(
                "difference",
                str(n),
                f"{_dot(theme.css(COLORS[d.colour]))}<b>{d.what}</b> {escape(d.text)}",
                "row",
                "go there",
            )
            for n, d in some[:MOST_ROWS]
        )
        if some:
            opened = " open" if kind != "lines" else ""
            out += f"<details{opened}><summary>{title} <b>{len(some)}</b></summary>{rows}{_more(some)}</details>"
    return out or '<p class="muted">No difference.</p>'


def _more(some: Sequence[object]) -> str:
    return f'<p class="muted">and {len(some) - MOST_ROWS:,} more</p>' if len(some) > MOST_ROWS else ""


def _dot(color: str) -> str:
    return f'<span class="dot" style="background:{color}"></span>'


def _stroke(color: str, dashes: bool) -> str:
    return f'<span class="stroke" style="border-top:4px {"dashed" if dashes else "solid"} {color}"></span>'
