"""What the panels say about the map and its items, as HTML. Every word that came from a person or a file is escaped."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from html import escape

import numpy as np

from rgcore.model.records import Gateway, Line, MapObject, Provenance, Region, RGMap
from rgviz import theme
from rgviz.commands import COMMANDS, spoken
from rgviz.picking import Item

Row = tuple[str, str]
"""A label and HTML."""


def item(map_: RGMap, i: Item) -> str:
    """The facts of one item."""
    if i.kind == "region":
        return region(map_, map_.regions[i.id])
    if i.kind == "gateway":
        return gateway(map_, map_.gateways[i.id])
    if i.kind == "line":
        return line(map_, map_.lines[i.id])
    return object_(map_, map_.objects[i.id])


def region(map_: RGMap, r: Region) -> str:
    along, across = r.box.size
    rows = [
        ("Area", f"{area(r):.1f} m²"),
        ("Robot box", f"{along:.2f} × {across:.2f} m, {degrees(r.box.yaw)}"),
        ("Main axes", ", ".join(degrees(a) for a in r.axes) or "none"),
        ("Accuracy", "not driven: no evidence" if r.accuracy is None else f"{100 * r.accuracy:.1f} cm"),
        ("Scans inside", str(r.scans)),
        ("Lines", str(len(map_.lines_of(r.id)))),
        ("Gateways", ids(map_.gateways_of(r.id))),
        ("Objects", ids(map_.objects_of(r.id))),
        ("Made by", provenance(r.provenance)),
    ]
    return heading("Region", r.id, r.name) + table(rows) + scores(r.class_scores)


def gateway(map_: RGMap, g: Gateway) -> str:
    rows = [
        ("Between", " and ".join(named(map_, r) for r in g.regions) or "none"),
        ("Width", f"{g.width:.2f} m"),
        ("Confidence", f"{100 * g.confidence:.0f} %"),
        ("Driven through", "yes" if g.passed else "no, only seen"),
        ("Directions", ", ".join(degrees(a) for a in g.traversal_directions) or "none"),
        ("Crossing-points", points(g.crossing_points)),
        ("Gateway-points", points(g.gateway_points)),
        ("Posts", points(g.posts)),
        ("Made by", provenance(g.provenance)),
    ]
    return heading("Gateway", g.id, g.name) + table(rows)


def line(map_: RGMap, v: Line) -> str:
    (x0, y0), (x1, y1) = v.start, v.end
    rows = [
        ("Length", f"{math.hypot(x1 - x0, y1 - y0):.2f} m"),
        ("Heading", degrees(math.atan2(y1 - y0, x1 - x0))),
        ("Support", f"{v.support} segments"),
        ("Residual", "unknown" if v.residual is None else f"{1000 * v.residual:.1f} mm"),
        ("Region", ", ".join(named(map_, r) for r in v.regions) or "none"),
        ("Start, end", points((v.start, v.end))),
        ("Made by", provenance(v.provenance)),
    ]
    return heading("Line", v.id) + table(rows)


def object_(map_: RGMap, o: MapObject) -> str:
    rows = [
        ("Size", " × ".join(f"{s:.2f}" for s in o.size) + " m"),
        ("Centre", f"({', '.join(f'{c:.2f}' for c in o.center)}) m"),
        ("Turned", degrees(o.yaw)),
        ("Region", named(map_, o.region) if o.region else "none"),
        ("Lines", f"{sum(i in map_.lines for i in o.lines)} of {len(o.lines)}"),
        ("Confidence", f"{100 * o.confidence:.0f} %"),
        ("Made by", provenance(o.provenance)),
    ]
    return heading("Object", o.id, o.label) + table(rows)


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


def overview(map_: RGMap, title: str) -> str:
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
    hint = "<p>Click a region, a gateway, a line or an object to see and change it. Shift+click selects more lines.</p>"
    return wrap(f'<div class="rg-h">{escape(title)}</div>{_table(rows)}<div class="muted">{hint}</div>')


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
    return wrap(f"<table>{out}</table>")


def keys() -> str:
    """The keys of all commands."""
    rows = [(f"<kbd>{escape(spoken(c.keys[0]))}</kbd>", escape(c.title)) for c in COMMANDS if c.keys]
    return wrap("<table>" + "".join(f"<tr><td>{k}</td><td>{t}</td></tr>" for k, t in rows) + "</table>")


def downloads(name: str, endings: Mapping[str, str]) -> str:
    """Links to the exports, by ending and title."""
    out = ""
    for end, title in endings.items():
        attributes = f'href="/export/map{end}" download="{escape(name)}{end}" title="{escape(title)}"'
        out += f'<a class="file" {attributes}>{end[1:].upper()}</a>'
    return wrap(out)


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
    who = "a person" if p.source == "human" else "the mapper, edited"
    when = f' <span class="muted">{escape(p.at.replace("T", " ").replace("Z", " UTC"))}</span>' if p.at else ""
    return f"{who}{when}"


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
