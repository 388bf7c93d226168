"""What stands below the drawing: scale bar, legend, and what the map was made from."""

from __future__ import annotations

from rgcore.exports.palette import GATEWAY, OBJECT, as_hex, class_color
from rgcore.exports.svg_sheet import INK, PALE, Sheet, layer, n, text
from rgcore.model.records import RGMap

_CAPTIONS = {"CDMA": "CDMA closed hallway", "ODMA": "ODMA open hallway", "TOMA": "TOMA room", "CC": "CC cluttered"}
_SCALES = (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)
"""m, lengths of a scale bar."""
_ROW = 1.4
"""Distance of the rows by the height of text."""


def legend(sheet: Sheet, map: RGMap) -> tuple[list[str], float]:
    """The layer, and its height [m]; the signs wrap where the drawing is narrow."""
    t, left, right = sheet.text, float(sheet.low[0]), float(sheet.high[0])
    length = max((s for s in _SCALES if s <= (right - left) / 4), default=_SCALES[0])
    y = float(-sheet.low[1]) + sheet.margin + 0.8 * t
    out = [_bar(left, y, length, t)]
    start = at = left + length + 1.6 * t
    for label, sign in _signs(map):
        width = (2.2 + 0.5 * len(label)) * t
        if at > start and at + width > right:
            at, y = start, y + _ROW * t
        out.append(f'<g transform="translate({n(at)} {n(y)}) scale({n(t)})">{sign}</g>')
        out.append(f'<text x="{n(at + 1.25 * t)}" y="{n(y)}" fill="{INK}">{text(label)}</text>')
        at += width
    counts = f"{len(map.lines)} lines · {len(map.regions)} regions · {len(map.gateways)} gateways"
    about = " · ".join(filter(None, [map.source.log, counts]))
    y += 1.5 * t
    out.append(f'<text x="{n(left)}" y="{n(y)}" fill="{PALE}">{text(about)}</text>')
    return layer("legend", out, f'font-size="{n(0.85 * t)}"'), y + float(sheet.low[1])


def _bar(x: float, y: float, length: float, t: float) -> str:
    return (
        f'<path d="M{n(x)} {n(y - 0.3 * t)}v{n(0.3 * t)}h{n(length)}v{n(-0.3 * t)}" fill="none" stroke="{INK}" '
        f'stroke-width="{n(0.1 * t)}"/><text x="{n(x + length / 2)}" y="{n(y - 0.35 * t)}" text-anchor="middle" '
        f'fill="{INK}">{length:g} m</text>'
    )


def _signs(map: RGMap) -> list[tuple[str, str]]:
    """Words and signs of the legend, the signs 0.9 wide and 0.7 high above the line of the text."""

    def area(color: str, opacity: float) -> str:
        return (
            f'<rect y="-0.7" width="0.9" height="0.7" fill="{color}" fill-opacity="{opacity}" '
            f'stroke="{color}" stroke-width="0.06"/>'
        )

    def bar(dashes: str) -> str:
        return f'<path d="M0,-0.35h0.9" stroke="{as_hex(GATEWAY)}" stroke-width="0.18" stroke-dasharray="{dashes}"/>'

    classes = sorted({r.class_ for r in map.regions.values() if r.class_})
    out = [(_CAPTIONS.get(name, name), area(as_hex(class_color(name)), 0.3)) for name in classes]
    if map.objects:
        out.append(("object", area(as_hex(OBJECT), 0.35)))
    if any(g.passed for g in map.gateways.values()):
        out.append(("gateway", bar("none")))
    if not all(g.passed for g in map.gateways.values()):
        out.append(("gateway, seen only", bar("0.22 0.12")))
    return out
