"""Lengths, directions and distances of segments."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rgcore.geometry import segments as geometry

coordinate = st.floats(-10, 10)
ends = st.tuples(coordinate, coordinate, coordinate, coordinate).map(lambda t: np.array(t).reshape(2, 2))


def test_length_and_angle_by_hand() -> None:
    s = np.array([[[1.0, 1.0], [4.0, 5.0]], [[0.0, 0.0], [-2.0, 0.0]]])
    assert geometry.lengths(s) == pytest.approx([5, 2])
    assert geometry.angles(s) == pytest.approx([np.arctan2(4, 3), np.pi])


def test_distance_to_the_middle_and_past_the_ends() -> None:
    s = np.array([[0.0, 0.0], [2.0, 0.0]])
    assert geometry.distances(np.array([[1.0, 0.5], [5.0, 4.0], [-1.0, 0.0]]), s) == pytest.approx([0.5, 5.0, 1.0])


def test_distance_to_a_point_like_segment() -> None:
    assert geometry.distances(np.array([3.0, 4.0]), np.zeros((2, 2))) == pytest.approx(5.0)


@given(ends, st.tuples(coordinate, coordinate, st.floats(-3, 3)).map(np.array))
def test_moving_keeps_length_and_turns_the_angle(s: np.ndarray, pose: np.ndarray) -> None:
    moved = geometry.transformed(pose, s[None])[0]
    assert geometry.lengths(moved) == pytest.approx(geometry.lengths(s), abs=1e-9)
