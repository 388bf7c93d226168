"""Outlines with straight edges."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rgcore.geometry import polygons
from rgcore.geometry.grid import Grid, fill_polygons


def drawn(corners: np.ndarray, resolution: float = 0.05) -> Grid:
    """A polygon (n, 2) [m] as a mask."""
    low = corners.min(0) - 1
    size = np.ceil((corners.max(0) + 1 - low) / resolution).astype(int)
    mask = fill_polygons(np.zeros((size[1], size[0]), bool), [(corners - low) / resolution], True)
    return Grid(mask, low, resolution)


def test_turned_rectangles_get_their_four_straight_sides_back() -> None:
    """At two angles in a hundred a step of the raster survives as a corner; the area is right to a tenth."""
    corners = []
    for turn in np.linspace(0, np.pi, 49):
        for width, height in ((4, 1), (1, 1), (8, 2), (5, 5), (2.3, 1.7), (8, 1)):
            c, s = np.cos(turn), np.sin(turn)
            true = np.array([[0, 0], [width, 0], [width, height], [0, height]]) @ np.array([[c, s], [-s, c]])
            shape = polygons.straighten(polygons.from_mask(drawn(true))[0], 0.08)
            assert shape.is_valid
            assert shape.area == pytest.approx(width * height, rel=0.11)
            boundary, holes = polygons.rings(shape)
            assert holes == ()
            corners.append(len(boundary))
    assert np.mean(np.array(corners) == 4) > 0.97
    assert max(corners) <= 6


def test_a_hole_stays_unless_it_is_small() -> None:
    mask = np.ones((100, 100), bool)
    mask[20:60, 20:60] = mask[80:84, 80:84] = False
    shape = polygons.from_mask(Grid(mask, np.zeros(2), 0.05))[0]
    kept = polygons.straighten(polygons.without_small_holes(shape, 0.3), 0.08)
    assert kept.area == pytest.approx(25 - 4, rel=0.01)
    assert len(polygons.rings(kept)[1]) == 1


@given(st.floats(0, np.pi), st.floats(2.0, 9.0), st.floats(0.5, 1.9))
def test_the_smallest_rectangle_names_its_long_side_first(turn: float, long: float, short: float) -> None:
    u = np.array([np.cos(turn), np.sin(turn)])
    n = np.array([-u[1], u[0]])
    points = np.array([3.0, -2.0]) + np.array([i * long / 2 * u + j * short / 2 * n for i in (-1, 1) for j in (-1, 1)])
    center, size, yaw = polygons.min_rectangle(points)
    assert center == pytest.approx((3, -2), abs=0.01)
    assert size == pytest.approx((long, short), abs=0.01)
    assert np.cos(2 * (yaw - turn)) == pytest.approx(1, abs=1e-3)
