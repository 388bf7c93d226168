"""What the inspector says about the items of a map, as HTML."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from html import escape
from typing import Any

import numpy as np

from rgcore.model.records import Gateway, Line, MapObject, Note, Provenance, Region, RGMap
from rgviz import plots, theme
from rgviz.figures import Figures
from rgviz.markup import Row, class_title, degrees, figure, heading, ids, named, points, table, when, wrap
from rgviz.picking import Item

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
    plot = figure("Directions of its lines", plots.angle_histogram(ends.reshape(-1, 2, 2), r.axes))
    curve = figures.curve(r.id) if figures is not None else None
    if curve is not None:
        plot += figure("Lines against accuracy, as tried", plots.trade_off(curve))
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


def provenance(p: Provenance) -> str:
    if p.source == "auto":
        return "the mapper"
    who = ("a person" if p.source == "human" else "the mapper, edited") + (f" by {escape(p.by)}" if p.by else "")
    return f'{who} <span class="muted">{when(p.at)}</span>' if p.at else who


def _shoelace(ring: Iterable[tuple[float, float]]) -> float:
    a = np.asarray(list(ring))
    b = np.roll(a, -1, 0)
    return float((a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]).sum() / 2)
