"""Small pictures in the inspector, as inline SVG: the directions of a region's lines, compactness against accuracy.

Colours and sizes of text come from ``static/rgviz.css``, so that they follow the light and the dark look.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rgcore.lines.adaptation import Curve

BINS = 36
"""of 5 degrees: finer than walls are crooked, coarse enough for a room of ten lines"""
WIDTH, HEIGHT = 280, 96
"""of a plot, in pixels; the page scales it to the panel"""
_LEFT, _RIGHT, _TOP, _BOTTOM = 34, 8, 8, 22


def directions(ends: np.ndarray) -> np.ndarray:
    """(BINS,) metres of line by direction, for lines (L, 2, 2); bins from 0 to pi [rad], a line has no forwards."""
    d = ends[:, 1] - ends[:, 0]
    angle = np.mod(np.arctan2(d[:, 1], d[:, 0]) + math.pi / BINS / 2, math.pi)  # 0 and 90 degrees amid their bins
    found = np.minimum((angle * BINS / math.pi).astype(int), BINS - 1)
    return np.bincount(found, np.hypot(d[:, 0], d[:, 1]), BINS)


def angle_histogram(ends: np.ndarray, axes: Sequence[float]) -> str:
    """Metres of line (L, 2, 2) by direction, with marks at the main axes [rad]; empty without lines."""
    if not len(ends):
        return ""
    metres = directions(ends)
    most = float(metres.max()) or 1.0
    wide = (WIDTH - _LEFT - _RIGHT) / BINS
    high = HEIGHT - _TOP - _BOTTOM
    bars = "".join(
        f'<rect class="column" x="{_LEFT + i * wide:.1f}" y="{_TOP + high * (1 - m / most):.1f}" '
        f'width="{wide - 1:.1f}" height="{high * m / most:.1f}"><title>{180 * i / BINS:.0f}°: {m:.1f} m</title></rect>'
        for i, m in enumerate(metres)
        if m > 0
    )
    marks = "".join(_axis(a, wide) for a in axes)
    ticks = "".join(
        _text(_LEFT + (d / 180 * BINS + 0.5) * wide, HEIGHT - 7, f"{d}°", "middle") for d in (0, 45, 90, 135)
    )
    return _plot("Directions of the lines, metres by angle", marks + bars + ticks + _height(most, "m"))


def _axis(angle: float, wide: float) -> str:
    x = _LEFT + (math.degrees(angle) % 180 / 180 * BINS + 0.5) * wide
    return f'<line class="mark" x1="{x:.1f}" x2="{x:.1f}" y1="2" y2="{HEIGHT - _BOTTOM}"/>'


def trade_off(curve: Curve) -> str:
    """Lines against accuracy of the settings that were tried, those that none beats joined, the chosen one marked."""
    x, y = np.asarray(curve.lines, float), 100 * np.asarray(curve.accuracy, float)
    if len(x) < 2 or not (np.isfinite(x).all() and np.isfinite(y).all()):
        return ""
    span_x, span_y = float(np.ptp(x)) or 1.0, float(np.ptp(y)) or 1.0
    px = _LEFT + 6 + (x - x.min()) / span_x * (WIDTH - _LEFT - _RIGHT - 12)
    py = _TOP + 4 + (y.max() - y) / span_y * (HEIGHT - _TOP - _BOTTOM - 10)
    front = _front(x, y)
    path = " ".join(f"{px[i]:.1f},{py[i]:.1f}" for i in front)
    dots = "".join(
        f'<circle class="{"chosen" if i == curve.chosen else "tried"}" cx="{px[i]:.1f}" cy="{py[i]:.1f}" '
        f'r="{4.5 if i == curve.chosen else 2.2}"><title>{x[i]:.0f} lines, {y[i]:.1f} cm</title></circle>'
        for i in sorted(range(len(x)), key=lambda i: i == curve.chosen)
    )
    words = (
        (_LEFT + 6, HEIGHT - 7, f"{x.min():.0f}", "start"),
        ((WIDTH + _LEFT) / 2, HEIGHT - 7, "lines", "middle"),
        (WIDTH - _RIGHT, HEIGHT - 7, f"{x.max():.0f}", "end"),
        (_LEFT - 2, _TOP + 8, f"{y.max():.1f}", "end"),
        (_LEFT - 2, (_TOP + HEIGHT - _BOTTOM) / 2 + 4, "cm", "end"),
        (_LEFT - 2, HEIGHT - _BOTTOM - 2, f"{y.min():.1f}", "end"),
    )
    text = "".join(_text(*w) for w in words)
    content = f'<polyline class="front" points="{path}"/>{dots}{text}'
    return _plot("Compactness against accuracy of the settings that were tried", content)


def _front(x: np.ndarray, y: np.ndarray) -> list[int]:
    """Indices, by rising ``x``, of the points that no other one beats in both."""
    out: list[int] = []
    for i in np.lexsort((y, x)):
        if not out or y[i] < y[out[-1]]:
            out.append(int(i))
    return out


def _height(most: float, unit: str) -> str:
    return _text(_LEFT - 4, _TOP + 8, f"{most:.3g}", "end") + _text(_LEFT - 4, HEIGHT - _BOTTOM, unit, "end")


def _text(x: float, y: float, text: str, anchor: str = "start") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{text}</text>'


def _plot(title: str, content: str) -> str:
    frame = f'<path class="frame" d="M{_LEFT} {_TOP}V{HEIGHT - _BOTTOM}H{WIDTH - _RIGHT}"/>'
    return f'<svg class="plot" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{title}">{frame}{content}</svg>'
