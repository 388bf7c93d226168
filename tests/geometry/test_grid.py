"""Cells and points of a raster."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rgcore.geometry.grid import Grid

GRID = Grid(np.arange(12.0).reshape(3, 4), np.array([-1.0, 2.0]), 0.5)  # x -1..1, y 2..3.5


def test_row_zero_is_the_smallest_y() -> None:
    assert GRID.at(np.array([-0.9, 2.1])) == 0
    assert GRID.at(np.array([0.9, 2.1])) == 3
    assert GRID.at(np.array([-0.9, 3.4])) == 8


def test_outside_gives_the_value_asked_for() -> None:
    points = np.array([[-1.01, 2.1], [1.01, 2.1], [0.0, 1.99], [0.0, 3.51]])
    assert (GRID.at(points, outside=-1) == -1).all()


@given(st.integers(0, 3), st.integers(0, 2))
def test_centre_of_a_cell_lies_in_it(ix: int, iy: int) -> None:
    cell = np.array([ix, iy])
    assert (GRID.cells(GRID.centers(cell)) == cell).all()
    assert GRID.at(GRID.centers(cell)) == GRID.values[iy, ix]


def test_like_keeps_the_frame() -> None:
    other = GRID.like(np.zeros((3, 4), bool))
    assert (other.origin == GRID.origin).all()
    assert other.resolution == GRID.resolution
