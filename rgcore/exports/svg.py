"""The map as a drawing: floors in class colours, lines, gateways, objects, names, a legend and a scale bar.

User units are metres, y down (a point (x, y) of the map stands at (x, -y)); every item carries ``data-rg-id``.
"""

from __future__ import annotations

from math import cos, sin
from typing import Any

import numpy as np

from rgcore.exports.options import Exported, Options
from rgcore.exports.palette import GATEWAY, OBJECT, as_hex, class_color
from rgcore.exports.svg_legend import legend
from rgcore.exports.svg_sheet import INK, PALE, PAPER, Sheet, layer, n, quoted, text, xy
from rgcore.geometry.polygons import label_place
from rgcore.model.base import natural
from rgcore.model.records import Gateway, MapObject, Region, RGMap
from rgcore.slam.trajectory import Trajectory

_LONG_SIDE = 1600.0  # px
_PX_PER_M = (8.0, 80.0)
_HALO = (
    'text-anchor="middle" stroke="#ffffff" stroke-opacity="0.85" stroke-linejoin="round" paint-order="stroke" '
    'pointer-events="none"'
)

_LOST = ("heights, class scores, confidence, crossing-points and gateway-points, who made what",)


def render(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """The map as SVG."""
    sheet = _sheet(map)
    x, y = sheet.low[0] - sheet.margin, -sheet.high[1] - sheet.margin
    w, h = sheet.high - sheet.low + 2 * sheet.margin
    below, height = legend(sheet, map)
    h += height
    title = map.source.log or "RG map"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{n(x)} {n(y)} {n(w)} {n(h)}" '
        f'width="{w * sheet.px:.0f}" height="{h * sheet.px:.0f}" '
        f'font-family="Inter, Helvetica Neue, Helvetica, Arial, sans-serif" role="img">',
        f"<title>{text(title)}</title>",
        f'<rect x="{n(x)}" y="{n(y)}" width="{n(w)}" height="{n(h)}" fill="{PAPER}"/>',
        *layer("floors", (_floor(sheet, r) for r in _ordered(map.regions)), 'stroke-linejoin="round"'),
        *layer("objects", (_object(sheet, o) for o in _ordered(map.objects)), 'stroke-linejoin="round"'),
        *_walls(sheet, map),
        *layer("gateways", (_gateway(sheet, g) for g in _ordered(map.gateways)), 'stroke-linecap="round"'),
        *layer("names", (_name(sheet, r) for r in _ordered(map.regions)), _HALO),
        *below,
        "</svg>\n",
    ]
    return Exported("\n".join(parts).encode(), lost=_LOST)


def _sheet(map: RGMap) -> Sheet:
    points = [p for line in map.lines.values() for p in (line.start, line.end)]
    points += [p for r in map.regions.values() for p in r.boundary]
    points += [p for g in map.gateways.values() for p in g.posts]
    corners = np.array(points or [(0, 0), (4, 3)], float)
    low, high = corners.min(0), corners.max(0)
    longest = max(float((high - low).max()), 1.0)
    return Sheet(low, high, float(np.clip(_LONG_SIDE / longest, *_PX_PER_M)), longest / 85)


def _floor(sheet: Sheet, r: Region) -> str:
    color = as_hex(class_color(r.class_))
    path = "".join(f"M{' '.join(map(xy, ring))}Z" for ring in (r.boundary, *r.holes) if ring)
    accuracy = "" if r.accuracy is None else f", accuracy {100 * r.accuracy:.1f} cm"
    return (
        f'<path {_about(r.id, r.class_)} d="{path}" fill="{color}" fill-opacity="0.2" fill-rule="evenodd" '
        f'stroke="{color}" stroke-opacity="0.45" stroke-width="{n(sheet.stroke(0.03, 1))}">'
        f"<title>{text(f'{r.name or r.id} · {r.class_}{accuracy}')}</title></path>"
    )


def _walls(sheet: Sheet, map: RGMap) -> list[str]:
    style = f'stroke="{INK}" stroke-width="{n(sheet.stroke(0.05, 1.6))}" stroke-linecap="round"'
    lines = (f'<path {_about(line.id)} d="M{xy(line.start)} {xy(line.end)}"/>' for line in _ordered(map.lines))
    return layer("lines", lines, style)


def _gateway(sheet: Sheet, g: Gateway) -> str:
    color, width = as_hex(GATEWAY), sheet.stroke(0.1, 3.0)
    posts = "".join(f'<circle cx="{n(x)}" cy="{n(-y)}" r="{n(width)}"/>' for x, y in g.posts)
    points = "".join(f'<circle cx="{n(x)}" cy="{n(-y)}" r="{n(0.7 * width)}"/>' for x, y in g.crossing_points)
    dashed = "" if g.passed else f' stroke-dasharray="{n(1.5 * width)} {n(2 * width)}"'
    name = f"{g.name or g.id} · {g.class_}, {g.width:.2f} m"
    return (
        f'<g {_about(g.id, g.class_)} fill="{color}" stroke-width="{n(width)}">'
        f'<title>{text(name)}</title><path d="M{xy(g.posts[0])} {xy(g.posts[1])}" stroke="{color}"{dashed}/>'
        f'{posts}<g fill="{PAPER}" stroke="{color}" stroke-width="{n(0.5 * width)}">{points}</g></g>'
    )


def _object(sheet: Sheet, o: MapObject) -> str:
    c, s = cos(o.yaw), sin(o.yaw)
    half = [(sx * o.size[0] / 2, sy * o.size[1] / 2) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    corners = [(o.center[0] + c * u - s * v, o.center[1] + s * u + c * v) for u, v in half]
    color = as_hex(OBJECT)
    return (
        f'<path {_about(o.id, o.label)} d="M{" ".join(map(xy, corners))}Z" fill="{color}" fill-opacity="0.35" '
        f'stroke="{color}" stroke-width="{n(sheet.stroke(0.03, 1.2))}"><title>{text(o.label or o.id)}</title></path>'
    )


def _name(sheet: Sheet, r: Region) -> str:
    """The name where the region is widest, as large as fits; upright in a region that is narrow and tall."""
    if len(r.boundary) < 3:
        return ""
    (x, y), radius = label_place(r.boundary, r.holes)
    name = r.name or r.id
    across, up = _room(r, x, y)
    tall = up > 2 * across and across < 0.6 * len(name) * sheet.text
    fits = 0.9 * max(across, up if tall else 0.0) / (0.58 * max(len(name), 1))
    size = float(np.clip(min(fits, 0.9 * radius), 0.45 * sheet.text, sheet.text))
    lines = [(name, size, INK, 600)]
    if r.class_ and radius > 1.2 * size > 0.8 * sheet.text:
        lines.append((r.class_, 0.62 * size, PALE, 400))
    shift = -0.5 * (len(lines) - 1) * 0.95 * size
    turn = " rotate(-90)" if tall else ""
    out = [f'<g {_about(r.id)} transform="translate({n(x)} {n(-y)}){turn}" stroke-width="{n(0.16 * size)}">']
    for i, (words, height, color, weight) in enumerate(lines):
        at = shift + i * 0.95 * size + 0.35 * height
        out.append(
            f'<text y="{n(at)}" font-size="{n(height)}" font-weight="{weight}" fill="{color}">{text(words)}</text>'
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


def _ordered(items: dict[str, Any]) -> list[Any]:
    return [items[id] for id in sorted(items, key=natural)]


def _about(id: str, class_: str = "") -> str:
    return f"data-rg-id={quoted(id)}" + (f" data-rg-class={quoted(class_)}" if class_ else "")
