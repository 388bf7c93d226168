"""Length-weighted moments: the paper's sums on numbers done by hand, and what must hold for any segments."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rgcore.geometry import moments as mo

coordinate = st.floats(-20, 20)
segment = st.tuples(coordinate, coordinate, coordinate, coordinate).map(lambda t: np.array(t).reshape(2, 2))
segments = st.lists(segment, min_size=1, max_size=6).map(np.array)


def test_sums_of_one_segment_by_hand() -> None:
    # (0, 1) to (3, 5) has length 5: W = 10, X = 5 * 3, Y = 5 * 6, XX = 5 * 9, YY = 5 * 26, XY = 5 * 15
    assert mo.moments(np.array([[[0.0, 1.0], [3.0, 5.0]]]))[0] == pytest.approx([10, 15, 30, 45, 130, 75])


def test_flat_regression_by_hand() -> None:
    # two segments of length 2 on y = 0 and y = 0.2: the line between them
    m = mo.moments(np.array([[[0.0, 0.0], [2.0, 0.0]], [[0.0, 0.2], [2.0, 0.2]]])).sum(0)
    assert m == pytest.approx([8, 8, 0.8, 16, 0.16, 0.8])
    slope, offset, steep = mo.regression(m)
    assert (slope, offset, steep) == (pytest.approx(0), pytest.approx(0.1), False)


def test_the_longer_segment_weighs_more() -> None:
    # lengths 3 and 1, both over x = 0..3 and 1..2: heights weigh 3 to 1
    m = mo.moments(np.array([[[0.0, 0.0], [3.0, 0.0]], [[1.0, 0.4], [2.0, 0.4]]])).sum(0)
    assert mo.regression(m).offset == pytest.approx(0.1)


def test_steep_regression_by_hand() -> None:
    # x = 2 + y / 2
    slope, offset, steep = mo.regression(
        mo.moments(np.array([[[2.0, 0.0], [3.0, 2.0]], [[4.0, 4.0], [5.0, 6.0]]])).sum(0)
    )
    assert (slope, offset, steep) == (pytest.approx(0.5), pytest.approx(2.0), True)


def test_vertical_line() -> None:
    assert mo.regression(mo.moments(np.array([[[3.0, -1.0], [3.0, 4.0]]]))[0]) == (
        pytest.approx(0),
        pytest.approx(3),
        True,
    )


@given(segments, segments)
def test_moments_of_a_union_are_the_sum(a: np.ndarray, b: np.ndarray) -> None:
    together = mo.moments(np.concatenate([a, b])).sum(0)
    assert together == pytest.approx(mo.moments(a).sum(0) + mo.moments(b).sum(0), abs=1e-6)


@given(segments)
def test_order_and_direction_do_not_matter(s: np.ndarray) -> None:
    assert mo.moments(s).sum(0) == pytest.approx(mo.moments(s[::-1, ::-1]).sum(0), abs=1e-6)


@given(segments, coordinate, coordinate)
def test_moving_the_moments_is_moving_the_segments(s: np.ndarray, dx: float, dy: float) -> None:
    moved = mo.moved(mo.moments(s).sum(0), (dx, dy))
    assert moved == pytest.approx(mo.moments(s + np.array([dx, dy])).sum(0), abs=1e-5)
    assert mo.moments(s, about=(-dx, -dy)).sum(0) == pytest.approx(moved, abs=1e-5)


@settings(deadline=None)  # the first call compiles
@given(segment)
def test_line_of_one_segment_goes_through_its_ends(s: np.ndarray) -> None:
    length = np.hypot(*(s[1] - s[0]))
    assume(length > 0.1)
    cx, cy, ux, uy, rms = mo.line_through(mo.moments(s[None], about=tuple(s[0]))[0])
    off = np.abs((s[:, 1] - s[0, 1] - cy) * ux - (s[:, 0] - s[0, 0] - cx) * uy)
    assert off.max() < 1e-6
    assert rms < 1e-4


@pytest.mark.parametrize("far", [0.0, 1e3, 1e6])
def test_stable_far_from_the_origin_when_kept_about_a_near_point(far: float) -> None:
    s = np.array([[[0.0, 0.0], [2.0, 0.02]], [[1.0, 0.01], [3.0, 0.03]]]) + far
    cx, cy, ux, uy, rms = mo.line_through(mo.moments(s, about=(far, far)).sum(0))
    assert np.arctan2(uy, ux) == pytest.approx(np.arctan(0.01), abs=1e-6)
    assert cy == pytest.approx(0.01 * cx, abs=1e-6)
    assert rms < 1e-6
