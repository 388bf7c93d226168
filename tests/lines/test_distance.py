"""The paper's distance measure on its own cases (section IV-B, figures 4 and 5)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rgcore.lines.distance import line_distance, line_distances


def seg(x1: float, y1: float, x2: float, y2: float) -> np.ndarray:
    return np.array([[x1, y1], [x2, y2]])


coordinate = st.floats(-10, 10)
segment = st.tuples(coordinate, coordinate, coordinate, coordinate).map(lambda t: seg(*t))


def test_no_overlap_takes_the_smaller_mean() -> None:
    # figure 5a. b's ends are 0.1 and 0.3 off the line of a: res_2 = 0.2. The line of b is y = (x - 2) / 10; a's ends
    # lie 0.2 and 0 off it along y, so across it res_1 = 0.1 / sqrt(1.01), the smaller
    d, overlap = line_distance(seg(0, 0, 2, 0), seg(3, 0.1, 5, 0.3))
    assert (d, overlap) == (pytest.approx(0.1 / np.sqrt(1.01)), 0)


def test_simple_overlap_takes_the_smaller_mean() -> None:
    # figure 5b. b's ends: 0.1 and 0.3 off the line of a; a's off the line of b: y = 0.1 + 0.1 (x - 1): 0 and 0.2
    d, overlap = line_distance(seg(0, 0, 2, 0), seg(1, 0.1, 3, 0.3))
    assert (d, overlap) == (pytest.approx(0.1 / np.sqrt(1.01)), 1)


@pytest.mark.parametrize("swap", [False, True])
def test_complete_overlap_takes_the_inner_segment(swap: bool) -> None:
    # figure 5c. The inner one's ends are 0.1 and 0.3 off the outer: 0.2, though the other mean is larger
    outer, inner = seg(0, 0, 10, 0), seg(4, 0.1, 6, 0.3)
    assert line_distance(*((inner, outer) if swap else (outer, inner))) == (pytest.approx(0.2), 2)


def test_vertical_lines_overlap_along_y() -> None:
    # with x alone, as printed, these would not overlap at all
    assert line_distance(seg(0, 0, 0, 10), seg(0.05, 4, 0.05, 6)) == (pytest.approx(0.05), 2)
    assert line_distance(seg(0, 0, 0, 2), seg(0.05, 3, 0.05, 5)) == (pytest.approx(0.05), 0)


def test_common_end_counts_as_complete() -> None:
    assert line_distance(seg(0, 0, 1, 0), seg(0, 0, 4, 0)) == (pytest.approx(0), 2)


def test_same_extent_overlaps_strictly_nowhere() -> None:
    assert line_distance(seg(0, 0, 1, 0), seg(0, 0.1, 1, 0.1)) == (pytest.approx(0.1), 0)


def test_crossing_at_right_angles_is_measured_by_its_length() -> None:
    # rho is what refuses these: the short one's d / length is 1 / 2
    d, _ = line_distance(seg(0, 0, 4, 0), seg(2, -0.1, 2.0, 0.1))
    assert d == pytest.approx(0.1)


@settings(deadline=None)  # the first call compiles
@given(segment, segment)
def test_neither_order_nor_direction_matters(a: np.ndarray, b: np.ndarray) -> None:
    d, overlap = line_distance(a, b)
    for other in (line_distance(b, a), line_distance(a[::-1], b), line_distance(a, b[::-1])):
        assert other == (pytest.approx(d, abs=1e-9), overlap)


@settings(deadline=None)  # the first call compiles
@given(segment, segment)
def test_a_quarter_turn_does_not_matter(a: np.ndarray, b: np.ndarray) -> None:
    both = np.concatenate([a, b])
    extent = np.ptp(both, axis=0)
    assume(abs(extent[0] - extent[1]) > 1e-6)
    turned = np.stack([-both[:, 1], both[:, 0]], 1)
    d, overlap = line_distance(a, b)
    assert line_distance(turned[:2], turned[2:]) == (pytest.approx(d, abs=1e-9), overlap)


@settings(deadline=None)  # the first call compiles
@given(st.lists(st.tuples(segment, segment), min_size=1, max_size=5))
def test_many_pairs_are_measured_as_one(pairs: list[tuple[np.ndarray, np.ndarray]]) -> None:
    d, overlap = line_distances(np.array([a for a, _ in pairs]), np.array([b for _, b in pairs]))
    assert [(float(x), int(o)) for x, o in zip(d, overlap, strict=True)] == [line_distance(a, b) for a, b in pairs]
