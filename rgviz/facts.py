"""What the panels say about the map and its items, as HTML. Every word that came from a person or a file is escaped."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from rgcore.model.records import Gateway, Line, MapObject, Note, Provenance, Region, RGMap
from rgviz import plots, theme
from rgviz.figures import Figures
from rgviz.picking import Item

Row = tuple[str, str]
"""A label and HTML."""
EDITS = 5
"""of an item that are named, the last ones"""


def item(map_: RGMap, i: Item, figures: Figures | None = None, titles: Mapping[int, str] | None = None) -> str:
    """The facts of one item; ``figures`` add what the evidence of the run says, ``titles`` name edits by number."""
    if i.kind == "note":
        return note(map_, map_.notes[i.id])
    tables: dict[str, Any] = {"region": region, "gateway": gateway, "line": line, "object": object_}
    told, thing = tables[i.kind](map_, i.id, figures)
    return f"{told}{origin(thing.provenance, titles or {})}{noted(map_, i.id)}"


def region(map_: RGMap, id_: str, figures: Figures | None = None) -> tuple[str, Region]:
    r = map_.regions[id_]
    along, across = r.box.size
    rows = [
        ("Area", f"{area(r):.1f} m²"),
        ("Robot box", f"{along:.2f} × {across:.2f} m, {degrees(r.box.yaw)}"),
        ("Main axes", ", ".join(degrees(a) for a in r.axes) or "none"),
        ("Accuracy", "not driven: no evidence" if r.accuracy is None else f"{100 * r.accuracy:.1f} cm"),
        *_fit(figures, r),
        ("Scans inside", f"{r.scans:,}"),
        ("Lines", f"{len(map_.lines_of(id_)):,}"),
        ("Gateways", ids(map_.gateways_of(id_))),
        ("Objects", ids(map_.objects_of(id_))),
    ]
    return heading("Region", r.id, r.name) + table(rows) + scores(r.class_scores), r


def region_plots(map_: RGMap, r: Region, figures: Figures | None) -> str:
    """Where its lines point to, and what its parameters were chosen from."""
    ends = np.array([(v.start, v.end) for v in map_.lines.values() if v.regions and v.regions[0] == r.id])
    plot = _figure("Directions of its lines", plots.angle_histogram(ends.reshape(-1, 2, 2), r.axes))
    curve = figures.curve(r.id) if figures is not None else None
    if curve is not None:
        plot += _figure("Lines against accuracy, as tried", plots.trade_off(curve))
    return plot


def _fit(figures: Figures | None, r: Region) -> list[Row]:
    """Accuracy that a few wild readings do not sway, of the map as it stands."""
    fit = figures.fit(r) if figures is not None else None
    if fit is None or not fit.echoes:
        return []
    median = "none" if math.isnan(fit.median) else f"{100 * fit.median:.1f} cm"
    return [
        ("Median error", f'{median} <span class="muted">of {fit.echoes:,} readings</span>'),
        ("Within 10 cm", f"{100 * fit.within_10:.0f} %"),
        ("Not predicted", f"{100 * fit.missed:.0f} %"),
    ]


def gateway(map_: RGMap, id_: str, _: Figures | None = None) -> tuple[str, Gateway]:
    g = map_.gateways[id_]
    rows = [
        ("Class", class_title(g.class_)),
        ("Between", " and ".join(named(map_, r) for r in g.regions) or "none"),
        ("Width", f"{g.width:.2f} m"),
        ("Confidence", f"{100 * g.confidence:.0f} %"),
        ("Driven through", "yes" if g.passed else "no, only seen"),
        ("Directions", ", ".join(degrees(a) for a in g.traversal_directions) or "none"),
        ("Crossing-points", points(g.crossing_points)),
        ("Gateway-points", points(g.gateway_points)),
        ("Posts", points(g.posts)),
    ]
    return heading("Gateway", g.id, g.name) + table(rows), g


def line(map_: RGMap, id_: str, figures: Figures | None = None) -> tuple[str, Line]:
    v = map_.lines[id_]
    (x0, y0), (x1, y1) = v.start, v.end
    scans = figures.scans_of(v) if figures is not None else None
    rows = [
        ("Length", f"{math.hypot(x1 - x0, y1 - y0):.2f} m"),
        ("Heading", f"{math.degrees(math.atan2(y1 - y0, x1 - x0)):.1f}°"),
        ("Support", _counts(v.support, "segment") + (f" of {_counts(scans, 'scan')}" if scans else "")),
        ("Residual", "unknown" if v.residual is None else f"{1000 * v.residual:.1f} mm"),
        ("Uncertainty", deviation(v)),
        ("Region", ", ".join(named(map_, r) for r in v.regions) or "none"),
        ("Kind", "clutter: a thing, no wall" if v.clutter else "wall"),
        ("Start, end", points((v.start, v.end))),
    ]
    return heading("Line", v.id) + table(rows), v


def _counts(number: int, what: str) -> str:
    return f"{number:,} {what}{'s' * (number != 1)}"


def deviation(v: Line) -> str:
    """How sure the mapper is of where a line lies: one standard deviation across its middle, and of its direction."""
    if v.deviation is None:
        return "unknown"
    across, turn = v.deviation
    return f"± {1000 * across:.1f} mm across, ± {math.degrees(turn):.2f}°"


def object_(map_: RGMap, id_: str, _: Figures | None = None) -> tuple[str, MapObject]:
    o = map_.objects[id_]
    rows = [
        ("Size", " × ".join(f"{s:.2f}" for s in o.size) + " m"),
        ("Centre", f"({', '.join(f'{c:.2f}' for c in o.center)}) m"),
        ("Turned", degrees(o.yaw)),
        ("Region", named(map_, o.region) if o.region else "none"),
        ("Lines", f"{sum(i in map_.lines for i in o.lines)} of {len(o.lines)}"),
        ("Confidence", f"{100 * o.confidence:.0f} %"),
    ]
    return heading("Object", o.id, o.label) + table(rows), o


def note(map_: RGMap, n: Note) -> str:
    rows = [
        ("About", escape(n.item) if n.item else "a place"),
        ("At", points((n.place,))),
        ("By", escape(n.provenance.by or "somebody")),
        ("When", when(n.provenance.at) or "unknown"),
    ]
    return heading("Note", n.id) + wrap(f"<p>{escape(n.text)}</p>") + table(rows)


def origin(p: Provenance, titles: Mapping[int, str]) -> str:
    """Who made an item, when, by which edits, and whether somebody has found it right."""
    rows = [("Made by", provenance(p))]
    told = [f"<li>{escape(titles.get(n, f'edit {n}'))}</li>" for n in p.edits[-EDITS:]]
    if told:
        more = f"<li>and {len(p.edits) - EDITS} before</li>" if len(p.edits) > EDITS else ""
        rows.append(("Edits", f"<ul>{''.join(reversed(told))}{more}</ul>"))
    state = f'<span class="tick">✓ confirmed</span> by {escape(p.by or "somebody")}' if p.confirmed else "to check"
    return table([*rows, ("Review", state)])


def noted(map_: RGMap, id_: str) -> str:
    """The notes on an item."""
    texts = [n.text for n in map_.notes.values() if n.item == id_]
    return wrap("".join(f'<div class="note">{escape(t)}</div>' for t in texts)) if texts else ""


def many(map_: RGMap, items: tuple[Item, ...]) -> str:
    """The facts of several items of one kind."""
    kind = items[0].kind
    rows = [("Selected", ids(i.id for i in items))]
    if kind == "line":
        total = sum(math.dist(map_.lines[i.id].start, map_.lines[i.id].end) for i in items)
        rows.append(("Length", f"{total:.2f} m in all"))
    if kind == "region":
        rows.append(("Area", f"{sum(area(map_.regions[i.id]) for i in items):.1f} m² in all"))
    return heading(f"{len(items)} {kind}s") + table(rows)


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
    plot = _figure("Lines against accuracy, as tried", plots.trade_off(curve)) if curve is not None else ""
    keys = '<p class="muted"><kbd>?</kbd> shows all keys.</p>'
    return wrap(f'<div class="rg-h">{escape(title)}</div>{_table(rows)}<div class="muted">{hint}</div>{keys}') + plot


def legend(map_: RGMap) -> str:
    """Swatches with the counts of everything that is drawn."""
    out = ""
    for c, n in _counted(r.class_ for r in map_.regions.values()):
        own = theme.class_color(c)
        out += _swatch(theme.css(theme.over_white(own)), theme.css(own), class_title(c), n)
    gate = theme.css(theme.GATEWAY)
    for c, n in _counted(g.class_ for g in map_.gateways.values()):
        out += _swatch(gate, gate, class_title(c), n, "opening")
    if map_.objects:
        color = theme.css(theme.OBJECT)
        out += _swatch(theme.css(theme.over_white(theme.OBJECT, 0.55)), color, "object", len(map_.objects))
    marks = ((theme.POST, "post"), (theme.CROSSING, "crossing-point"), (theme.GATEWAY_POINT, "gateway-point"))
    if map_.gateways:
        out += "".join(_swatch(theme.css(color), theme.css(color), text, None, text) for color, text in marks)
    if map_.notes:
        color = theme.css(theme.NOTE)
        out += _swatch(color, color, "note", len(map_.notes), "note-mark")
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


def scores(values: dict[str, float]) -> str:
    """Class scores as small bars, the best first."""
    rows = ""
    for c, v in sorted(values.items(), key=lambda kv: -kv[1]):
        share = min(max(float(v), 0.0), 1.0)
        color = theme.css(theme.class_color(c))
        bar = f'<div class="bar"><i style="width:{100 * share:.0f}%;background:{color}"></i></div>'
        rows += f'<tr><td>{escape(c)}</td><td class="wide">{bar}</td><td class="n">{share:.2f}</td></tr>'
    return wrap(f"<table>{rows}</table>") if rows else ""


def area(r: Region) -> float:
    """m² inside the outline, without holes."""
    return _shoelace(r.boundary) - sum(abs(_shoelace(h)) for h in r.holes)


def class_title(c: str) -> str:
    words = theme.CLASS_TITLES.get(c)
    if words is None:
        return escape(c) or "not classified"
    return escape(words) if "_" in c or c == "opening" else f'{escape(c)} <span class="muted">{escape(words)}</span>'


def provenance(p: Provenance) -> str:
    if p.source == "auto":
        return "the mapper"
    who = ("a person" if p.source == "human" else "the mapper, edited") + (f" by {escape(p.by)}" if p.by else "")
    return f'{who} <span class="muted">{when(p.at)}</span>' if p.at else who


def when(at: str | None) -> str:
    """A time of the journal, as HTML: ``2026-01-31 12:00 UTC``."""
    return escape((at or "").replace("T", " ").replace("Z", " UTC").replace(":00 UTC", " UTC"))


def _figure(title: str, svg: str) -> str:
    return wrap(f'<figure><figcaption class="muted">{escape(title)}</figcaption>{svg}</figure>') if svg else ""


def heading(kind: str, id_: str = "", name: str = "") -> str:
    small = f"<small>{escape(kind)}{' ' + escape(id_) if id_ and name and name != id_ else ''}</small>" if id_ else ""
    return wrap(f'<div class="rg-h">{escape(name or id_ or kind)}{small}</div>')


def named(map_: RGMap, region_id: str) -> str:
    r = map_.regions.get(region_id)
    if r is None or r.name in ("", r.id):
        return escape(region_id)
    return f'{escape(r.name)} <span class="muted">{escape(region_id)}</span>'


def ids(values: Iterable[str], most: int = 8) -> str:
    all_ = list(values)
    more = f" and {len(all_) - most} more" if len(all_) > most else ""
    return (", ".join(escape(v) for v in all_[:most]) + more) or "none"


def points(values: Iterable[tuple[float, float]]) -> str:
    return "<br>".join(f"({x:.2f}, {y:.2f})" for x, y in values) or "none"


def degrees(angle: float) -> str:
    """An angle [rad] in whole degrees, within half a turn either way."""
    return f"{round(math.degrees(math.remainder(angle, math.tau)))}°"


def wrap(html: str) -> str:
    return f'<div class="rg">{html}</div>'


def table(rows: Iterable[Row]) -> str:
    return wrap(_table(rows))


def _table(rows: Iterable[Row]) -> str:
    return "<table>" + "".join(f"<tr><td>{k}</td><td>{v}</td></tr>" for k, v in rows) + "</table>"


def _swatch(fill: str, edge: str, text: str, count: int | None, mark: str = "") -> str:
    box = f'<span class="swatch {mark}" style="background:{fill};border-color:{edge}"></span>'
    number = "" if count is None else f"{count:,}"
    return (
        f'<tr><td style="color:inherit;white-space:normal;width:auto">{box}{text}</td><td class="n">{number}</td></tr>'
    )


def _counted(classes: Iterable[str]) -> list[tuple[str, int]]:
    return sorted(Counter(classes).items(), key=lambda kv: (-kv[1], kv[0]))


def _shoelace(ring: Iterable[tuple[float, float]]) -> float:
    a = np.asarray(list(ring))
    b = np.roll(a, -1, 0)
    return float((a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]).sum() / 2)
