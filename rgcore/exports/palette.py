"""Colours of the map, chosen once for every export and the view: they stay apart for colour-blind eyes.

Hues after Okabe & Ito (2008), as sRGB triples 0-255.
"""

from __future__ import annotations

import hashlib

RGB = tuple[int, int, int]

CLASS_COLORS: dict[str, RGB] = {
    "CDMA": (0, 114, 178),  # closed hallway: blue
    "ODMA": (86, 180, 233),  # open hallway: sky blue
    "TOMA": (0, 158, 115),  # office: green
    "CC": (230, 159, 0),  # clutter: orange
}
UNKNOWN_CLASS: RGB = (150, 150, 150)
GATEWAY: RGB = (213, 94, 0)
OBJECT: RGB = (204, 121, 167)

REGION_CYCLE: tuple[RGB, ...] = (
    (0, 114, 178),
    (230, 159, 0),
    (0, 158, 115),
    (204, 121, 167),
    (86, 180, 233),
    (213, 94, 0),
    (120, 94, 240),
    (140, 110, 60),
)
"""Neighbouring regions are told apart by cycling through these."""


def class_color(name: str) -> RGB:
    """Colour of a region class; a class that a user added gets a steady hue of its own from its name."""
    if name in CLASS_COLORS:
        return CLASS_COLORS[name]
    if not name:
        return UNKNOWN_CLASS
    h = hashlib.sha256(name.encode()).digest()
    return (80 + h[0] % 140, 60 + h[1] % 120, 90 + h[2] % 140)


def as_hex(color: RGB) -> str:
    """``#rrggbb``."""
    return "#{:02x}{:02x}{:02x}".format(*color)
