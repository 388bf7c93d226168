"""How the view looks: every colour, size and height of a layer in one place."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rgcore.exports.palette import GATEWAY, OBJECT, REGION_CYCLE, RGB, class_color
from rgcore.model.records import RGMap

NAME = "rgviz"
BRAND: RGB = (0, 114, 178)
PAGE_BRAND: RGB = (0, 54, 84)
"""what viser must be told so that its buttons come out in ``BRAND``: it lightens the colour it is given"""

POINT: RGB = (176, 182, 190)
TRAJECTORY: RGB = (105, 110, 120)
FREE_LINE: RGB = (70, 74, 82)
"""a wall that no region claims"""
BOX: RGB = (110, 110, 125)
AXIS: RGB = (60, 60, 70)
POST: RGB = (60, 20, 0)
CROSSING: RGB = GATEWAY
GATEWAY_POINT: RGB = (0, 50, 130)
NOTE: RGB = (190, 140, 0)
WALL: RGB = (206, 209, 214)
SELECTION: RGB = (240, 10, 130)
ADDED: RGB = (0, 60, 200)
REMOVED: RGB = (205, 45, 20)
CHANGED: RGB = (235, 175, 0)
"""what came, went and changed between two maps; what went is dashed as well"""
STALE: RGB = (110, 80, 130)
"""of an edit whose thing is not there any more"""
SHIFTED: RGB = (140, 100, 100)
"""of an edit that was made elsewhere than the poses say"""
WAS: RGB = (205, 45, 20)
"""walls of another map that is laid over this one"""

FLOOR_OPACITY, CHOSEN_OPACITY = 0.30, 0.55
"""strength of the class colours on floors, and on those of selected regions"""
WALL_HEIGHT = 1.2
"""m, of walls in the 3D view: cut low, as in an architect's model, so that one sees into the rooms"""

# Heights of the layers over the floor [m]: they tell the renderer what lies on top when seen from above.
Z_FLOOR, Z_POINTS, Z_OUTLINE, Z_BOX, Z_TRAJECTORY, Z_LINE, Z_GATEWAY, Z_MARK, Z_CHANGE, Z_SELECTION = (
    0.0,
    0.01,
    0.02,
    0.03,
    0.035,
    0.05,
    0.06,
    0.07,
    0.075,
    0.08,
)

LINE_WIDTH, OUTLINE_WIDTH, THIN_WIDTH, GATEWAY_WIDTH, SELECTION_WIDTH, CHANGE_WIDTH = 2.0, 1.5, 1.0, 3.5, 4.0, 5.0
"""pixels"""

CLASS_TITLES: dict[str, str] = {
    "CDMA": "closed hallway",
    "ODMA": "open hallway",
    "TOMA": "room with two main axes",
    "CC": "cluttered",
    "narrow_passage": "narrow passage",
    "junction_T": "T-junction",
    "junction_L": "L-junction",
    "junction_X": "X-junction",
    "opening": "opening",
}
"""What the classes mean, in words for a person."""


def srgb_to_linear(color: np.ndarray | RGB) -> np.ndarray:
    """uint8 sRGB (..., 3) as uint8 linear: the GPU takes vertex colours as that; others look washed out."""
    c = np.asarray(color, float) / 255
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return np.round(linear * 255).astype(np.uint8)


def css(color: RGB) -> str:
    return "#{:02x}{:02x}{:02x}".format(*color)


def over_white(color: RGB, opacity: float = FLOOR_OPACITY) -> RGB:
    """What a transparent floor of that colour looks like on the page: for swatches."""
    r, g, b = (round(255 - opacity * (255 - c)) for c in color)
    return r, g, b


def dark(color: RGB) -> RGB:
    """What a colour of the picture becomes in the dark look: the filter of ``static/rgviz.css``, ``invert(0.9)
    hue-rotate(180deg)`` as the W3C's Filter Effects define them. Lightness turns over, hue stays."""
    turned = 0.9 - 0.8 * np.asarray(color, float) / 255
    r, g, b = np.clip(_HALF_TURN @ turned * 255, 0, 255).round().astype(int).tolist()
    return r, g, b


_HALF_TURN = np.array([[-0.574, 1.430, 0.144], [0.426, 0.430, 0.144], [0.426, 1.430, -0.856]])


def region_colors(map_: RGMap, known: Mapping[str, RGB] | None = None) -> dict[str, RGB]:
    """A colour for each region that differs from those of its neighbours where it can; ``known`` ones stay."""
    neighbours: dict[str, set[str]] = {r: set() for r in map_.regions}
    for gateway in map_.gateways.values():
        for r in gateway.regions:
            if r in neighbours:
                neighbours[r] |= set(gateway.regions) - {r}
    out: dict[str, RGB] = {r: c for r, c in (known or {}).items() if r in map_.regions}
    for n, r in enumerate(map_.regions):
        if r not in out:
            taken = {out[o] for o in neighbours[r] if o in out}
            start = n % len(REGION_CYCLE)
            turn = REGION_CYCLE[start:] + REGION_CYCLE[:start]
            out[r] = next((c for c in turn if c not in taken), turn[0])
    return out


__all__ = ["GATEWAY", "OBJECT", "RGB", "class_color"]
