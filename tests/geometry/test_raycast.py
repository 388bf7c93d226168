"""Beams against segments."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rgcore.geometry.raycast import cast

coordinate = st.floats(-10, 10)
ends = st.tuples(coordinate, coordinate, coordinate, coordinate).map(lambda t: np.array(t).reshape(2, 2))

SQUARE = np.array([[[0, 0], [4, 0]], [[4, 0], [4, 3]], [[4, 3], [0, 3]], [[0, 3], [0, 0]]], float)


def test_beams_from_inside_a_square() -> None:
    poses = np.array([[1.0, 1.0, 0.0]])
    ranges, hit = cast(SQUARE, poses, np.array([-np.pi / 2, 0.0, np.pi / 2, np.pi]), 10.0)
    assert ranges[0] == pytest.approx([1.0, 3.0, 2.0, 1.0])
    assert hit[0].tolist() == [0, 1, 2, 3]


def test_nothing_in_reach_is_infinite() -> None:
    ranges, hit = cast(SQUARE, np.array([[-20.0, 1.0, 0.0]]), np.array([0.0, np.pi]), 10.0)
    assert np.isinf(ranges).all()
    assert (hit == -1).all()
    assert np.isinf(cast(np.zeros((0, 2, 2)), np.zeros((1, 3)), np.zeros(1), 10.0)[0]).all()


@settings(max_examples=60, deadline=None)
@given(
    st.lists(ends, min_size=1, max_size=12).map(np.array), coordinate, coordinate, st.floats(-3, 3), st.floats(1, 40)
)
def test_bisection_finds_what_trying_every_segment_finds(
    lines: np.ndarray, x: float, y: float, angle: float, reach: float
) -> None:
    ranges, _ = cast(lines, np.array([[x, y, angle]]), np.array([0.0]), reach)
    u, a, d = np.array([np.cos(angle), np.sin(angle)]), lines[:, 0] - [x, y], lines[:, 1] - lines[:, 0]
    across = u[0] * d[:, 1] - u[1] * d[:, 0]
    ok = across != 0
    with np.errstate(all="ignore"):
        t = (a[:, 0] * d[:, 1] - a[:, 1] * d[:, 0]) / across
        s = (a[:, 0] * u[1] - a[:, 1] * u[0]) / across
    margin = ok & (((np.abs(s) < 1e-6) | (np.abs(s - 1) < 1e-6)) | (np.abs(t) < 1e-9) | (np.abs(t - reach) < 1e-9))
    assume(not margin.any())  # a beam through the very end of a segment may go either way
    hits = t[ok & (s > 0) & (s < 1) & (t > 0) & (t < reach)]
    assert ranges[0, 0] == pytest.approx(hits.min() if len(hits) else np.inf)
