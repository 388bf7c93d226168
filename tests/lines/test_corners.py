"""Corners of lines that nearly meet."""

from __future__ import annotations

import numpy as np
import pytest

from rgcore.lines.corners import close_corners

# two walls of a room, free space to their left: the first ends where the second starts, 3 to 5 cm off the corner (4, 0)
CORNER = np.array([[[0, 0], [3.96, 0]], [[4, 0.05], [4, 3]]], float)


def test_an_end_and_a_start_meet_in_the_corner() -> None:
    closed = close_corners(CORNER, 0.1)
    assert closed[0] == pytest.approx(np.array([[0, 0], [4, 0]]))
    assert closed[1] == pytest.approx(np.array([[4, 0], [4, 3]]))


def test_overlong_lines_are_cut_back_to_it() -> None:
    closed = close_corners(np.array([[[0, 0], [4.06, 0]], [[4, -0.04], [4, 3]]], float), 0.1)
    assert closed[0, 1] == pytest.approx([4, 0])
    assert closed[1, 0] == pytest.approx([4, 0])


def test_two_ends_are_no_corner() -> None:
    faces = CORNER.copy()
    faces[1] = faces[1, ::-1]  # seen from the other side: no boundary runs on from one to the other
    assert (close_corners(faces, 0.1) == faces).all()


def test_a_doorway_stays_open() -> None:
    door = np.array([[[0, 0], [3, 0]], [[3.9, 0.1], [3.9, 3]]], float)
    assert (close_corners(door, 0.1) == door).all()


def test_nearly_parallel_lines_have_no_corner() -> None:
    flat = np.array([[[0, 0], [2, 0]], [[2.02, 0.03], [4, 0.1]]], float)
    assert (close_corners(flat, 0.1) == flat).all()


def test_few_lines() -> None:
    assert close_corners(np.zeros((0, 2, 2)), 0.1).shape == (0, 2, 2)
    assert (close_corners(CORNER[:1], 0.1) == CORNER[:1]).all()
