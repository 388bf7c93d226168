"""The sheet of a drawing: its size and pens, and how numbers and texts are written in it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

import numpy as np

INK, PALE, PAPER = "#20262e", "#6b7480", "#ffffff"
_FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass(frozen=True)
class Sheet:
    """``low`` and ``high`` [m]: corners of the map; ``px``: pixels a metre; ``text`` [m]: height of usual text."""

    low: np.ndarray
    high: np.ndarray
    px: float
    text: float

    @property
    def margin(self) -> float:
        """Empty border around the map [m]."""
        return 1.6 * self.text

    def stroke(self, metres: float, pixels: float) -> float:
        """A line width in metres, but never finer than so many pixels."""
        return max(metres, pixels / self.px)


def layer(name: str, items: Iterable[str], attributes: str = "") -> list[str]:
    """A group of elements with an id."""
    return [f'<g id="{name}" {attributes}>', *items, "</g>"]


def text(value: str) -> str:
    """What a person typed, as text of an element."""
    return escape(_clean(value))


def quoted(value: str) -> str:
    """What a person typed, as a quoted attribute."""
    return quoteattr(_clean(value))


def _clean(value: str) -> str:
    """Without the characters that XML 1.0 does not allow."""
    return _FORBIDDEN.sub("", value)


def xy(point: tuple[float, float]) -> str:
    """A point of the map in the coordinates of the drawing."""
    return f"{n(point[0])},{n(-point[1])}"


def n(value: float) -> str:
    """A number to the millimetre."""
    return f"{value:.3f}".rstrip("0").rstrip(".") if abs(value) >= 0.0005 else "0"
