"""What the panels say about the whole map: its numbers, what the colours mean, what can be had of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from html import escape

from rgcore.model.records import RGMap
from rgviz import plots, theme
from rgviz.figures import Figures
from rgviz.markup import class_title, figure, rows_of, swatch, wrap


def overview(map_: RGMap, title: str, figures: Figures | None = None) -> str:
    """The facts of the whole map, shown while nothing is selected."""
    s = map_.stats
    reduction = f"{s.segments / len(map_.lines):.1f} segments a line" if map_.lines and s.segments else "unknown"
    accuracy = "unknown" if s.accuracy is None else f"{100 * s.accuracy:.1f} cm"
    if s.accuracy is not None and s.accuracy_penalty is not None:
        accuracy += f' <span class="muted">(penalty {s.accuracy_penalty:g} m)</span>'
    rows = [
        ("Log", escape(map_.source.log or "unknown")),
        ("Scans", f"{s.scans:,}"),
        ("Readings", f"{s.points:,}"),
        ("Lines", f"{len(map_.lines):,}"),
        ("Reduction", reduction),
        ("Accuracy", accuracy),
    ]
    hint = "<p>Click a region, a gateway, a line or an object to see and change it. Shift+click selects more.</p>"
    curve = figures.map_curve() if figures is not None else None
    plot = figure("Lines against accuracy, as tried", plots.trade_off(curve)) if curve is not None else ""
    keys = '<p class="muted"><kbd>?</kbd> shows all keys.</p>'
    return wrap(f'<div class="rg-h">{escape(title)}</div>{rows_of(rows)}<div class="muted">{hint}</div>{keys}') + plot


def legend(map_: RGMap) -> str:
    """Swatches with the counts of everything that is drawn."""
    out = ""
    for c, n in _counted(r.class_ for r in map_.regions.values()):
        own = theme.class_color(c)
        out += swatch(theme.css(theme.over_white(own)), theme.css(own), class_title(c), n)
    gate = theme.css(theme.GATEWAY)
    for c, n in _counted(g.class_ for g in map_.gateways.values()):
        out += swatch(gate, gate, class_title(c), n, "opening")
    if map_.objects:
        color = theme.css(theme.OBJECT)
        out += swatch(theme.css(theme.over_white(theme.OBJECT, 0.55)), color, "object", len(map_.objects))
    marks = ((theme.POST, "post"), (theme.CROSSING, "crossing-point"), (theme.GATEWAY_POINT, "gateway-point"))
    if map_.gateways:
        out += "".join(swatch(theme.css(color), theme.css(color), text, None, text) for color, text in marks)
    if map_.notes:
        color = theme.css(theme.NOTE)
        out += swatch(color, color, "note", len(map_.notes), "note-mark")
    return wrap(f"<table>{out}</table>")


def guest() -> str:
    """Why there is nothing to press."""
    return wrap(
        '<div class="rg-h">For looking</div><p class="muted">This link shows the map; edits need the other one.</p>'
    )


def downloads(name: str, endings: Mapping[str, str], last: str | None = None, lost: Sequence[str] | None = None) -> str:
    """Links to the exports, by ending and title; what the ``last`` one could not carry (None: not known yet)."""
    out = ""
    for end, title in endings.items():
        attributes = f'href="/export/map{end}" download="{escape(name)}{end}" title="{escape(title)}"'
        out += f'<a class="file" data-do="download" data-arg="{end}" {attributes}>{end[1:].upper()}</a>'
    if last is None:
        return wrap(out)
    file = f"<b>{escape(name)}{last}</b>"
    if lost is None:
        return wrap(f"{out}<p>{file} is being written ...</p>")
    if not lost:
        return wrap(f"{out}<p>{file} holds the whole map.</p>")
    rows = "".join(f"<li>{escape(what)}</li>" for what in lost)
    return wrap(f"{out}<p>{file}, {escape(endings[last])}, does not hold</p><ul class=lost>{rows}</ul>")


def _counted(classes: Iterable[str]) -> list[tuple[str, int]]:
    return sorted(Counter(classes).items(), key=lambda kv: (-kv[1], kv[0]))
