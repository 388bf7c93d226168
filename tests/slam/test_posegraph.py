"""The pose graph against solutions that are known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rgcore.geometry import se2
from rgcore.slam.posegraph import Links, chi_squared, optimise

SURE = np.diag([1e4, 1e4, 1e5])


def links(true: np.ndarray, pairs: list[tuple[int, int]], scale: float = np.inf) -> Links:
    """Exact links between true poses (N, 3)."""
    a, b = np.array(pairs).T
    n = len(pairs)
    return Links(a, b, se2.relative(true[a], true[b]), np.repeat(SURE[None], n, 0), np.full(n, scale))


def square(n: int = 40) -> np.ndarray:
    side = np.arange(n // 4) * 1.0
    m = len(side)
    rows = [np.column_stack([side, 0 * side, 0 * side]), np.column_stack([0 * side + m, side, 0 * side + np.pi / 2])]
    rows += [
        np.column_stack([m - side, 0 * side + m, 0 * side + np.pi]),
        np.column_stack([0 * side, m - side, 0 * side - np.pi / 2]),
    ]
    return np.concatenate(rows)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.0, 0.1))
def test_exact_links_give_the_true_poses_from_any_start(seed: int, noise: float) -> None:
    true = square()
    start = true + noise * np.random.default_rng(seed).normal(size=true.shape)
    start[0] = true[0]
    pairs = [(k, k + 1) for k in range(len(true) - 1)] + [(0, len(true) - 1), (3, 30)]
    assert np.allclose(optimise(start, links(true, pairs), enough=1e-9)[:, :2], true[:, :2], atol=1e-6)


def test_a_closure_spreads_the_drift_over_the_loop() -> None:
    true = square()
    drifting = links(true, [(k, k + 1) for k in range(len(true) - 1)])
    off = np.array(drifting.a_from_b)
    off[:, 2] += 0.003
    drifting = Links(drifting.a, drifting.b, off, drifting.information, drifting.scale)
    open_ = optimise(true, drifting)
    closed = optimise(open_, drifting.plus(links(true, [(0, len(true) - 1)])))
    end = np.hypot(*(open_ - true)[-1, :2])
    assert end > 0.5
    assert np.hypot(*(closed - true)[:, :2].T).max() < 0.3 * end


def test_a_wrong_closure_is_outvoted() -> None:
    true = square()
    good = links(true, [(k, k + 1) for k in range(len(true) - 1)] + [(k, 39 - k) for k in range(5)])
    wrong = links(true, [(5, 25), (10, 30)], scale=10.0)
    wrong = Links(wrong.a, wrong.b, wrong.a_from_b + np.array([3.0, -2.0, 0.5]), wrong.information, wrong.scale)
    poses = optimise(true, good.plus(wrong), rounds=30)
    assert np.hypot(*(poses - true)[:, :2].T).max() < 0.02
    assert (chi_squared(poses, wrong) > 1e3).all()


def test_a_direction_that_nobody_measured_stays() -> None:
    across = Links(
        np.array([0]), np.array([1]), np.array([[5.0, 1.0, 0.0]]), np.diag([0.0, 1e4, 1e4])[None], np.array([np.inf])
    )
    poses = optimise(np.array([[0.0, 0, 0], [2.0, 0.7, 0.1]]), across)
    assert poses[1] == pytest.approx([2.0, 1.0, 0.0], abs=1e-3)


def test_poses_without_links_and_graphs_without_poses() -> None:
    alone = np.array([[1.0, 2, 3], [4, 5, 6]])
    assert np.allclose(optimise(alone, Links.none()), alone)
    third = np.concatenate([alone * [1, 1, 0.1], [[7.0, 8, 0.9]]])
    out = optimise(third, links(third, [(0, 1)]))
    assert np.allclose(out, third, atol=1e-9)


def test_turning_past_half_a_turn() -> None:
    true = np.array([[0.0, 0, 3.1], [1.0, 0, -3.1], [2.0, 0.1, 3.0]])
    out = optimise(
        true + np.array([[0, 0, 0], [0.1, 0, 0.1], [0, 0.1, 0.2]]), links(true, [(0, 1), (1, 2)]), enough=1e-9
    )
    assert np.allclose(out[:, :2], true[:, :2], atol=1e-6)
    assert np.abs(se2.wrap(out[:, 2] - true[:, 2])).max() < 1e-6
