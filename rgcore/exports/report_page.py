"""What a report is written with: an HTML page that needs nothing else, tables, figures and inline drawings."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

import numpy as np

from rgcore.exports.svg_sheet import n

STYLE = """
:root { color-scheme: light dark; --ink: #1b2027; --pale: #66707c; --paper: #fff; --card: #f6f7f9; --rule: #d9dde3;
  --accent: #0072b2; --warm: #d55e00; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e9ed; --pale: #98a2ae; --paper: #14171b; --card: #1d2126;
  --rule: #343a42; --accent: #56b4e9; --warm: #f0965a; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.55 Charter, "Bitstream Charter", Georgia,
  "DejaVu Serif", serif; }
main { max-width: 1040px; margin: 0 auto; padding: 48px 28px 72px; }
h1 { font-size: 34px; line-height: 1.15; margin: 0 0 4px; letter-spacing: -0.01em; overflow-wrap: anywhere; }
h2 { font-size: 21px; margin: 52px 0 8px; }
h3 { font-size: 16px; margin: 22px 0 6px; }
p { margin: 8px 0; max-width: 76ch; }
.pale, figcaption, caption, .card span { color: var(--pale); }
table, .card, figcaption, caption, svg text { font-family: Inter, "Helvetica Neue", Helvetica, Arial, "DejaVu Sans",
  sans-serif; }
.cards { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 12px; margin: 26px 0 8px; }
.card { background: var(--card); border-radius: 8px; padding: 14px 16px; }
.card b { display: block; font-size: 25px; line-height: 1.2; font-weight: 600; font-variant-numeric: tabular-nums; }
.card span { font-size: 13px; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; font-variant-numeric: tabular-nums;
  border-top: 2px solid var(--ink); border-bottom: 2px solid var(--ink); margin: 6px 0 4px; }
caption { caption-side: top; text-align: left; padding: 10px 0 6px; font-size: 13.5px; }
caption b, figcaption b { color: var(--ink); }
th { font-weight: 600; border-bottom: 1px solid var(--ink); vertical-align: bottom; }
th, td { padding: 4px 10px 4px 0; text-align: right; }
th:first-child, td:first-child, .text { text-align: left; overflow-wrap: anywhere; }
tbody tr + tr td { border-top: 1px solid var(--rule); }
tr.sum td { font-weight: 600; }
figure { margin: 18px 0; }
figcaption { font-size: 13.5px; margin-top: 8px; max-width: 90ch; }
.sheet { background: #fff; border: 1px solid var(--rule); border-radius: 8px; padding: 10px; }
.sheet svg { display: block; width: 100%; height: auto; max-height: 780px; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: 14px; }
.pair svg, .plot svg { display: block; width: 100%; height: auto; max-height: 420px; background: var(--card);
  border-radius: 8px; }
.pair p { margin: 6px 0 0; font-size: 13.5px; }
.strokes { fill: none; stroke: var(--ink); stroke-linecap: round; vector-effect: non-scaling-stroke; }
.before { stroke-width: 0.6px; stroke-opacity: 0.4; }
.after { stroke-width: 1.4px; }
.plot text { fill: var(--pale); font-size: 12px; }
.plot .axis { stroke: var(--rule); fill: none; }
.plot .tried { fill: var(--pale); fill-opacity: 0.45; }
.plot .front { stroke: var(--accent); stroke-width: 1.6; fill: none; }
.plot .mark { fill: var(--warm); }
.plot .best { fill: var(--accent); }
.plot text.name { fill: var(--ink); font-weight: 600; }
@media (max-width: 640px) { .pair { grid-template-columns: 1fr; } main { padding: 28px 16px 48px; } }
@media print { main { padding: 0; max-width: none; } h2 { break-after: avoid; } figure, tr { break-inside: avoid; } }
"""


def page(title: str, body: Iterable[str]) -> str:
    """A whole page; ``body`` is HTML."""
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<link rel="icon" href="data:,">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n"
        + "\n".join(body)
        + "\n</main>\n</body>\n</html>\n"
    )


def paragraph(text: str, pale: bool = False) -> str:
    return f"<p{' class=pale' if pale else ''}>{escape(text)}</p>"


def heading(text: str, level: int = 2) -> str:
    return f"<h{level}>{escape(text)}</h{level}>"


def cards(items: Iterable[tuple[str, str]]) -> str:
    """Large figures, each with what it is."""
    return (
        '<div class="cards">'
        + "".join(f'<div class="card"><b>{escape(v)}</b><span>{escape(k)}</span></div>' for v, k in items)
        + "</div>"
    )


def table(
    name: str, caption: str, heads: Sequence[str], rows: Iterable[Sequence[object]], sums: int = 0, text: int = 1
) -> str:
    """A table; its first ``sums`` rows are those of the whole, its first ``text`` columns are words."""

    def cells(tag: str, row: Sequence[object]) -> str:
        return "".join(f"<{tag}{' class=text' if i < text else ''}>{escape(str(c))}</{tag}>" for i, c in enumerate(row))

    head = f"<thead><tr>{cells('th', heads)}</tr></thead>" if any(heads) else ""
    lines = [f"<tr{' class=sum' if i < sums else ''}>{cells('td', r)}</tr>" for i, r in enumerate(rows)]
    return (
        f'<div class="wide"><table id="{escape(name)}"><caption>{_caption(caption)}</caption>'
        f"{head}<tbody>{''.join(lines)}</tbody></table></div>"
    )


def figure(content: str, caption: str, kind: str) -> str:
    """``content`` is HTML; ``kind``: "sheet" for drawings on white, "pair" for two side by side, "plot"."""
    return f'<figure><div class="{kind}">{content}</div><figcaption>{_caption(caption)}</figcaption></figure>'


def _caption(text: str) -> str:
    """The words before the first full stop are what the thing is called."""
    name, stop, rest = text.partition(". ")
    return f"<b>{escape(name)}{stop.strip()}</b> {escape(rest)}" if stop else escape(text)


def strokes(ends: np.ndarray, low: np.ndarray, high: np.ndarray, kind: str, title: str) -> str:
    """Straight pieces (K, 2, 2) [m] as one drawing of the box ``low`` .. ``high``; ``kind``: "before" or "after"."""
    margin = 0.02 * float((high - low).max())
    w, h = high - low + 2 * margin
    scale = 1000.0 / max(w, h)  # a whole number is finer than a screen's pixel
    p = np.round((ends - low + margin) * scale).astype(int)
    p[..., 1] = round(h * scale) - p[..., 1]
    path = "".join(f"M{x1} {y1}L{x2} {y2}" for (x1, y1), (x2, y2) in p.tolist())
    return (
        f'<div><svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {w * scale:.0f} {h * scale:.0f}" role="img">'
        f'<title>{escape(title)}</title><path class="strokes {kind}" d="{path}"/></svg><p>{escape(title)}</p></div>'
    )


def scatter(
    points: Sequence[tuple[float, float]], marks: Sequence[tuple[float, float, str, str]], x_name: str, y_name: str
) -> str:
    """Points with the front of those that none beats on both axes (both: less is better), and named marks
    ``(x, y, class, name)``.
    """
    w, h, left, top, right, bottom = 760.0, 380.0, 64.0, 22.0, 24.0, 48.0
    xs, ys = [p[0] for p in points] + [m[0] for m in marks], [p[1] for p in points] + [m[1] for m in marks]
    x_ticks, y_ticks = _ticks(min(xs), max(xs)), _ticks(min(ys), max(ys))

    def at(x: float, y: float) -> tuple[str, str]:
        u = (x - x_ticks[0]) / (x_ticks[-1] - x_ticks[0])
        v = (y - y_ticks[0]) / (y_ticks[-1] - y_ticks[0])
        return n(left + u * (w - left - right)), n(h - bottom - v * (h - top - bottom))

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {n(w)} {n(h)}" role="img">']
    out.append(f"<title>{escape(y_name)} against {escape(x_name)}</title>")
    for t in x_ticks:
        (x, y0), (_, y1) = at(t, y_ticks[0]), at(t, y_ticks[-1])
        out.append(f'<path class="axis" d="M{x} {y0}V{y1}"/>')
        out.append(f'<text x="{x}" y="{n(h - bottom + 18)}" text-anchor="middle">{t:g}</text>')
    for t in y_ticks:
        (x0, y), (x1, _) = at(x_ticks[0], t), at(x_ticks[-1], t)
        out.append(f'<path class="axis" d="M{x0} {y}H{x1}"/>')
        out.append(f'<text x="{n(left - 8)}" y="{n(float(y) + 4)}" text-anchor="end">{t:g}</text>')
    out += [f'<circle class="tried" cx="{x}" cy="{y}" r="3"/>' for x, y in (at(*p) for p in points)]
    front = [at(*p) for p in _front(points)]
    out.append(f'<path class="front" d="M{"L".join(f"{x} {y}" for x, y in front)}"/>')
    for mx, my, kind, name in marks:
        x, y = at(mx, my)
        below = kind == "best"  # nothing lies there: it would be better on both axes
        at_text = f'x="{n(float(x) + (-8 if below else 8))}" y="{n(float(y) + (18 if below else -10))}"'
        out.append(f'<circle class="{escape(kind)}" cx="{x}" cy="{y}" r="6"/>')
        out.append(
            f'<text class="name" {at_text} text-anchor="{"end" if below or float(x) > 0.8 * w else "start"}">'
            f"{escape(name)}</text>"
        )
    out.append(f'<text x="{n((left + w - right) / 2)}" y="{n(h - 10)}" text-anchor="middle">{escape(x_name)}</text>')
    turned = f"translate(16 {n((top + h - bottom) / 2)}) rotate(-90)"
    return "".join([*out, f'<text transform="{turned}" text-anchor="middle">{escape(y_name)}</text></svg>'])


def _front(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """The points that no other beats on both axes, from left to right."""
    out: list[tuple[float, float]] = []
    for x, y in sorted(points):
        if not out or y < out[-1][1]:
            out.append((x, y))
    return out


def _ticks(low: float, high: float) -> list[float]:
    """Round numbers around a range: 1, 2 or 5 times a power of ten apart."""
    span = max(high - low, 1e-9 * max(abs(low), abs(high)), 1e-9)
    power = 10.0 ** np.floor(np.log10(span / 4))
    step = float(power * next(f for f in (1, 2, 5, 10) if power * f >= span / 5))
    first, last = np.floor(low / step), np.ceil(high / step)
    return [float(k * step) for k in np.arange(first, max(last, first + 1) + 1)]
