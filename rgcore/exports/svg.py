"""The map as a drawing: floors in class colours, lines, gateways, objects, names, a legend and a scale bar.

User units are metres, y down (a point (x, y) of the map stands at (x, -y)); every item carries ``data-rg-id``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from math import cos, sin
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from rgcore.exports.options import Options
from rgcore.exports.palette import GATEWAY, OBJECT, as_hex, class_color
from rgcore.geometry.polygons import label_place
from rgcore.model.base import natural
from rgcore.model.records import Gateway, MapObject, Region, RGMap
from rgcore.slam.trajectory import Trajectory

INK, PALE, PAPER = "#20262e", "#6b7480", "#ffffff"
_FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_LONG_SIDE = 1600.0  # px
_PX_PER_M = (8.0, 80.0)
_SCALES = (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)  # m, lengths of a scale bar


@dataclass(frozen=True)
class _Sheet:
    """``low`` and ``high`` [m]: corners of the map; ``px``: pixels a metre; ``text`` [m]: height of usual text."""

    low: np.ndarray
    high: np.ndarray
    px: float
    text: float

    @property
    def margin(self) -> float:
        return 1.6 * self.text

    @property
    def foot(self) -> float:
        """Height of the strip below the map."""
        return 3.4 * self.text

    def stroke(self, metres: float, pixels: float) -> float:
        """A line width in metres, but never finer than so many pixels."""
        return max(metres, pixels / self.px)


def render(map: RGMap, trajectory: Trajectory | None, options: Options) -> bytes:
    """The map as SVG."""
    sheet = _sheet(map)
    x, y = sheet.low[0] - sheet.margin, -sheet.high[1] - sheet.margin
    w, h = sheet.high - sheet.low + 2 * sheet.margin
    h += sheet.foot
    title = map.source.log or "RG map"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{_n(x)} {_n(y)} {_n(w)} {_n(h)}" '
        f'width="{w * sheet.px:.0f}" height="{h * sheet.px:.0f}" '
        f'font-family="Inter, Helvetica Neue, Helvetica, Arial, sans-serif" role="img">',
        f"<title>{_text(title)}</title>",
        f'<rect x="{_n(x)}" y="{_n(y)}" width="{_n(w)}" height="{_n(h)}" fill="{PAPER}"/>',
        *_layer("floors", (_floor(sheet, r) for r in _ordered(map.regions)), 'stroke-linejoin="round"'),
        *_layer("objects", (_object(sheet, o) for o in _ordered(map.objects)), 'stroke-linejoin="round"'),
        *_walls(sheet, map),
        *_layer("gateways", (_gateway(sheet, g) for g in _ordered(map.gateways)), 'stroke-linecap="round"'),
        *_layer("names", (_name(sheet, r) for r in _ordered(map.regions)), _HALO),
        *_foot(sheet, map),
        "</svg>\n",
    ]
    return "\n".join(parts).encode()


_HALO = (
    'text-anchor="middle" stroke="#ffffff" stroke-opacity="0.85" stroke-linejoin="round" paint-order="stroke" '
    'pointer-events="none"'
)


def _sheet(map: RGMap) -> _Sheet:
    points = [p for line in map.lines.values() for p in (line.start, line.end)]
    points += [p for r in map.regions.values() for p in r.boundary]
    points += [p for g in map.gateways.values() for p in g.posts]
    xy = np.array(points or [(0, 0), (4, 3)], float)
    low, high = xy.min(0), xy.max(0)
    longest = max(float((high - low).max()), 1.0)
    return _Sheet(low, high, float(np.clip(_LONG_SIDE / longest, *_PX_PER_M)), longest / 75)


def _layer(name: str, items: Iterable[str], attributes: str = "") -> list[str]:
    return [f'<g id="{name}" {attributes}>', *items, "</g>"]


def _floor(sheet: _Sheet, r: Region) -> str:
    color = as_hex(class_color(r.class_))
    path = "".join(f"M{' '.join(map(_xy, ring))}Z" for ring in (r.boundary, *r.holes) if ring)
    accuracy = "" if r.accuracy is None else f", accuracy {100 * r.accuracy:.1f} cm"
    return (
        f'<path {_about(r.id, r.class_)} d="{path}" fill="{color}" fill-opacity="0.2" fill-rule="evenodd" '
        f'stroke="{color}" stroke-opacity="0.45" stroke-width="{_n(sheet.stroke(0.03, 1))}">'
        f"<title>{_text(f'{r.name or r.id} · {r.class_}{accuracy}')}</title></path>"
    )


def _walls(sheet: _Sheet, map: RGMap) -> list[str]:
    style = f'stroke="{INK}" stroke-width="{_n(sheet.stroke(0.05, 1.6))}" stroke-linecap="round"'
    lines = (f'<path {_about(line.id)} d="M{_xy(line.start)} {_xy(line.end)}"/>' for line in _ordered(map.lines))
    return _layer("lines", lines, style)


def _gateway(sheet: _Sheet, g: Gateway) -> str:
    color, width = as_hex(GATEWAY), sheet.stroke(0.1, 3.0)
    posts = "".join(f'<circle cx="{_n(x)}" cy="{_n(-y)}" r="{_n(width)}"/>' for x, y in g.posts)
    points = "".join(f'<circle cx="{_n(x)}" cy="{_n(-y)}" r="{_n(0.7 * width)}"/>' for x, y in g.crossing_points)
    dashed = "" if g.passed else f' stroke-dasharray="{_n(1.5 * width)} {_n(2 * width)}"'
    name = f"{g.name or g.id} · {g.class_}, {g.width:.2f} m"
    return (
        f'<g {_about(g.id, g.class_)} fill="{color}" stroke-width="{_n(width)}">'
        f'<title>{_text(name)}</title><path d="M{_xy(g.posts[0])} {_xy(g.posts[1])}" stroke="{color}"{dashed}/>'
        f'{posts}<g fill="{PAPER}" stroke="{color}" stroke-width="{_n(0.5 * width)}">{points}</g></g>'
    )


def _object(sheet: _Sheet, o: MapObject) -> str:
    c, s = cos(o.yaw), sin(o.yaw)
    half = [(sx * o.size[0] / 2, sy * o.size[1] / 2) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    corners = [(o.center[0] + c * u - s * v, o.center[1] + s * u + c * v) for u, v in half]
    color = as_hex(OBJECT)
    return (
        f'<path {_about(o.id, o.label)} d="M{" ".join(map(_xy, corners))}Z" fill="{color}" fill-opacity="0.35" '
        f'stroke="{color}" stroke-width="{_n(sheet.stroke(0.03, 1.2))}"><title>{_text(o.label or o.id)}</title></path>'
    )


def _name(sheet: _Sheet, r: Region) -> str:
    """The name where the region is widest, as large as fits; upright in a region that is narrow and tall."""
    if len(r.boundary) < 3:
        return ""
    (x, y), radius = label_place(r.boundary, r.holes)
    name = r.name or r.id
    across, up = _room(r, x, y)
    tall = up > 2 * across and across < 0.6 * len(name) * sheet.text
    fits = 0.9 * max(across, up if tall else 0.0) / (0.58 * max(len(name), 1))
    size = float(np.clip(min(fits, 0.9 * radius), 0.5 * sheet.text, sheet.text))
    lines = [(name, size, INK, 600)]
    if radius > 1.2 * size and r.class_:
        lines.append((r.class_, 0.62 * size, PALE, 400))
    shift = -0.5 * (len(lines) - 1) * 0.95 * size
    turn = " rotate(-90)" if tall else ""
    out = [f'<g {_about(r.id)} transform="translate({_n(x)} {_n(-y)}){turn}" stroke-width="{_n(0.16 * size)}">']
    for i, (text, height, color, weight) in enumerate(lines):
        at = shift + i * 0.95 * size + 0.35 * height
        out.append(
            f'<text y="{_n(at)}" font-size="{_n(height)}" font-weight="{weight}" fill="{color}">{_text(text)}</text>'
        )
    return "".join([*out, "</g>"])


def _room(r: Region, x: float, y: float) -> tuple[float, float]:
    """How far the region reaches through a point, from left to right and from top to bottom [m]."""
    a = np.array(r.boundary, float)
    b = np.roll(a, -1, axis=0)
    out = []
    for axis, at, here in ((1, y, x), (0, x, y)):
        crossing = (a[:, axis] > at) != (b[:, axis] > at)
        p, q = a[crossing], b[crossing]
        hits = p[:, 1 - axis] + (at - p[:, axis]) / (q[:, axis] - p[:, axis]) * (q[:, 1 - axis] - p[:, 1 - axis]) - here
        before, after = hits[hits <= 0], hits[hits > 0]
        reach = min(-before.max(), after.min()) if len(before) and len(after) else 0.0
        out.append(2 * float(reach))
    return out[0], out[1]


def _foot(sheet: _Sheet, map: RGMap) -> list[str]:
    """Scale bar, the classes that occur, and what the map was made from."""
    t = sheet.text
    width = float(sheet.high[0] - sheet.low[0])
    length = max((s for s in _SCALES if s <= width / 4), default=_SCALES[0])
    x, y = float(sheet.low[0]), float(-sheet.low[1]) + sheet.margin + 0.8 * t
    bar = (
        f'<path d="M{_n(x)} {_n(y - 0.3 * t)}v{_n(0.3 * t)}h{_n(length)}v{_n(-0.3 * t)}" fill="none" stroke="{INK}" '
        f'stroke-width="{_n(0.1 * t)}"/><text x="{_n(x + length / 2)}" y="{_n(y - 0.35 * t)}" text-anchor="middle" '
        f'fill="{INK}">{length:g} m</text>'
    )
    out, at = [bar], x + length + 2 * t
    for name in sorted({r.class_ for r in map.regions.values() if r.class_}):
        color = as_hex(class_color(name))
        out.append(
            f'<rect x="{_n(at)}" y="{_n(y - 0.75 * t)}" width="{_n(0.9 * t)}" height="{_n(0.75 * t)}" fill="{color}" '
            f'fill-opacity="0.35" stroke="{color}" stroke-width="{_n(0.06 * t)}"/>'
            f'<text x="{_n(at + 1.2 * t)}" y="{_n(y)}" fill="{INK}">{_text(name)}</text>'
        )
        at += (2.4 + 0.62 * len(name)) * t
    counts = f"{len(map.lines)} lines · {len(map.regions)} regions · {len(map.gateways)} gateways"
    about = " · ".join(filter(None, [map.source.log, counts]))
    out.append(f'<text x="{_n(x)}" y="{_n(y + 1.5 * t)}" fill="{PALE}">{_text(about)}</text>')
    return _layer("legend", out, f'font-size="{_n(0.85 * t)}"')


def _ordered(items: dict[str, Any]) -> list[Any]:
    return [items[id] for id in sorted(items, key=natural)]


def _about(id: str, class_: str = "") -> str:
    return f"data-rg-id={_quoted(id)}" + (f" data-rg-class={_quoted(class_)}" if class_ else "")


def _text(text: str) -> str:
    return escape(_clean(text))


def _quoted(text: str) -> str:
    return quoteattr(_clean(text))


def _clean(text: str) -> str:
    """Without the characters that XML 1.0 does not allow."""
    return _FORBIDDEN.sub("", text)


def _xy(point: tuple[float, float]) -> str:
    return f"{_n(point[0])},{_n(-point[1])}"


def _n(value: float) -> str:
    """A number to the millimetre."""
    return f"{value:.3f}".rstrip("0").rstrip(".") if abs(value) >= 0.0005 else "0"
