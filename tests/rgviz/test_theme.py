"""Colours: they stay apart for all eyes, light and dark, and what is written can be read."""

from __future__ import annotations

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from rgcore.exports.palette import CLASS_COLORS
from rgviz import theme
from rgviz.again.kinds import KIND_COLORS
from rgviz.theme import RGB

EYES = {
    "usual": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
}
"""What each kind of eye makes of linear RGB: Machado, Oliveira and Fernandes 2009, severity 1."""
APART, FLOORS_APART = 11.0, 5.0
"""CIE 1976 distance in Lab: 2.3 is just noticeable side by side; floors are large and border on one another"""


def linear(color: RGB) -> np.ndarray:
    c = np.asarray(color, float) / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def lab(color: RGB, eye: np.ndarray) -> np.ndarray:
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    t = xyz @ np.clip(eye @ linear(color), 0, 1) / (0.9505, 1.0, 1.089)
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def contrast(a: RGB, b: RGB) -> float:
    """WCAG 2.2."""
    high, low = sorted((float(linear(c) @ (0.2126, 0.7152, 0.0722)) for c in (a, b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def least(colors: dict[str, RGB], eye: np.ndarray) -> tuple[float, tuple[str, str]]:
    return min(
        (float(np.linalg.norm(lab(colors[a], eye) - lab(colors[b], eye))), (a, b)) for a, b in combinations(colors, 2)
    )


@pytest.mark.parametrize("look", ["light", "dark"])
@pytest.mark.parametrize("eye", EYES)
def test_colours_stay_apart_for_colour_blind_eyes(eye: str, look: str) -> None:
    seen = theme.dark if look == "dark" else lambda c: c
    classes = {k: seen(c) for k, c in CLASS_COLORS.items()}
    floors = {k: seen(theme.over_white(c)) for k, c in CLASS_COLORS.items()}
    marks = {"gateway": theme.GATEWAY, "point": theme.GATEWAY_POINT, "post": theme.POST, "chosen": theme.SELECTION}
    assert least(classes, EYES[eye])[0] > APART, least(classes, EYES[eye])
    assert least(floors, EYES[eye])[0] > FLOORS_APART, least(floors, EYES[eye])
    changes = {k: seen(c) for k, c in (("new", theme.ADDED), ("gone", theme.REMOVED), ("changed", theme.CHANGED))}
    assert least(changes, EYES[eye])[0] > APART, least(changes, EYES[eye])
    kinds = {k: seen(c) for k, c in KIND_COLORS.items()}
    assert least(kinds, EYES[eye])[0] > APART, least(kinds, EYES[eye])
    marked = {k: seen(c) for k, c in marks.items()}
    assert least(marked, EYES[eye])[0] > APART, least(marked, EYES[eye])


def test_dark_turns_lightness_and_keeps_hues() -> None:
    assert max(theme.dark((255, 255, 255))) < 40
    assert min(theme.dark((0, 0, 0))) > 215
    for color in CLASS_COLORS.values():
        a, b = (np.arctan2(*lab(c, np.eye(3))[[2, 1]]) for c in (color, theme.dark(color)))
        assert abs(np.degrees(np.angle(np.exp(1j * (a - b))))) < 40, color


CSS = (Path(__file__).parents[2] / "static" / "rgviz.css").read_text()


def variables(selector: str) -> dict[str, RGB]:
    block = re.search(re.escape(selector) + r" \{(.*?)\n\}", CSS, re.S)
    assert block
    found = re.findall(r"--([\w-]+): #([0-9a-f]{3,6});", block[1])
    out: dict[str, RGB] = {}
    for name, value in found:
        long = "".join(c * 2 for c in value) if len(value) == 3 else value
        out[name] = (int(long[:2], 16), int(long[2:4], 16), int(long[4:], 16))
    return out


@pytest.mark.parametrize("kind", KIND_COLORS)
def test_numbers_on_pins_can_be_read(kind: str) -> None:
    assert contrast(KIND_COLORS[kind], (255, 255, 255)) >= 4.5


@pytest.mark.parametrize("selector", [":root", "html.rg-dark"])
def test_what_is_written_can_be_read(selector: str) -> None:
    """4.5 to 1 as WCAG AA asks of small text."""
    v = variables(selector)
    for ink in ("ink", "pale", "bad", "good", "brand", "brand-ink"):
        assert contrast(v[ink], v["paper"]) >= 4.5, ink
    for ground in ("hover", "chosen", "soft"):
        assert contrast(v["ink"], v[ground]) >= 7, ground
        assert contrast(v["pale"], v[ground]) >= 4.5, ground


def test_the_look_has_one_filter_and_theme_knows_it() -> None:
    assert re.findall(r"filter: (.*?);", CSS) == ["invert(0.9) hue-rotate(180deg)"]
