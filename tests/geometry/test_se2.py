"""Poses of the plane chain, invert and wrap."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rgcore.geometry import se2

number = st.floats(-100, 100)
pose = st.tuples(number, number, st.floats(-10, 10)).map(np.array)


def test_quarter_turn_by_hand() -> None:
    map_from_base = np.array([1.0, 2.0, np.pi / 2])
    assert np.allclose(se2.transform(map_from_base, np.array([3.0, 0.0])), [1.0, 5.0])
    assert np.allclose(se2.compose(map_from_base, np.array([3.0, 4.0, np.pi])), [-3.0, 5.0, -np.pi / 2])


@given(pose, pose, pose)
def test_chaining_is_associative(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> None:
    left, right = se2.compose(se2.compose(a, b), c), se2.compose(a, se2.compose(b, c))
    assert np.allclose(left[:2], right[:2], atol=1e-6)
    assert abs(se2.wrap(left[2] - right[2])) < 1e-9


@given(pose, pose)
def test_relative_pose_leads_from_one_to_the_other(a: np.ndarray, b: np.ndarray) -> None:
    again = se2.compose(a, se2.relative(a, b))
    assert np.allclose(again[:2], b[:2], atol=1e-9)
    assert abs(se2.wrap(again[2] - b[2])) < 1e-9


@given(pose, st.lists(st.tuples(number, number), min_size=1, max_size=5))
def test_inverse_takes_points_back(a: np.ndarray, points: list[tuple[float, float]]) -> None:
    p = np.array(points)
    assert np.allclose(se2.transform(se2.invert(a), se2.transform(a, p)), p, atol=1e-9)


@given(st.floats(-1e3, 1e3))
def test_wrapped_angle_is_the_same_direction_in_the_half_open_turn(angle: float) -> None:
    w = float(se2.wrap(angle))
    assert -np.pi < w <= np.pi
    assert np.isclose(np.cos(w), np.cos(angle), atol=1e-9)
    assert np.isclose(np.sin(w), np.sin(angle), atol=1e-9)


def test_half_turn_wraps_to_plus_pi() -> None:
    assert se2.wrap(-np.pi) == np.pi
