"""The HTML that panels are made of. Every word that came from a person or a file is escaped."""

from __future__ import annotations

import math
from collections.abc import Iterable
from html import escape

from rgcore.model.records import RGMap
from rgviz import theme

Row = tuple[str, str]
"""A label and HTML."""


def wrap(html: str) -> str:
    return f'<div class="rg">{html}</div>'


def heading(kind: str, id_: str = "", name: str = "") -> str:
    small = f"<small>{escape(kind)}{' ' + escape(id_) if id_ and name and name != id_ else ''}</small>" if id_ else ""
    return wrap(f'<div class="rg-h">{escape(name or id_ or kind)}{small}</div>')


def table(rows: Iterable[Row]) -> str:
    return wrap(rows_of(rows))


def rows_of(rows: Iterable[Row]) -> str:
    return "<table>" + "".join(f"<tr><td>{k}</td><td>{v}</td></tr>" for k, v in rows) + "</table>"


def ids(values: Iterable[str], most: int = 8) -> str:
    all_ = list(values)
    more = f" and {len(all_) - most} more" if len(all_) > most else ""
    return (", ".join(escape(v) for v in all_[:most]) + more) or "none"


def points(values: Iterable[tuple[float, float]]) -> str:
    return "<br>".join(f"({x:.2f}, {y:.2f})" for x, y in values) or "none"


def degrees(angle: float) -> str:
    """An angle [rad] in whole degrees, within half a turn either way."""
    return f"{round(math.degrees(math.remainder(angle, math.tau)))}°"


def named(map_: RGMap, region_id: str) -> str:
    r = map_.regions.get(region_id)
    if r is None or r.name in ("", r.id):
        return escape(region_id)
    return f'{escape(r.name)} <span class="muted">{escape(region_id)}</span>'


def class_title(c: str) -> str:
    words = theme.CLASS_TITLES.get(c)
    if words is None:
        return escape(c) or "not classified"
    return escape(words) if "_" in c or c == "opening" else f'{escape(c)} <span class="muted">{escape(words)}</span>'


def when(at: str | None) -> str:
    """A time of the journal, as HTML: ``2026-01-31 12:00 UTC``."""
    return escape((at or "").replace("T", " ").replace("Z", " UTC").replace(":00 UTC", " UTC"))


def figure(title: str, svg: str) -> str:
    return wrap(f'<figure><figcaption class="muted">{escape(title)}</figcaption>{svg}</figure>') if svg else ""


def swatch(fill: str, edge: str, text: str, count: int | None, mark: str = "") -> str:
    box = f'<span class="swatch {mark}" style="background:{fill};border-color:{edge}"></span>'
    number = "" if count is None else f"{count:,}"
    return (
        f'<tr><td style="color:inherit;white-space:normal;width:auto">{box}{text}</td><td class="n">{number}</td></tr>'
    )
