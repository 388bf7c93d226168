"""Information that noisy normals pretend to have is taken off, and what is left can always be solved."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rgcore.geometry.compiled import kernel
from rgcore.slam.keyframes import write_links
from rgcore.slam.local import discount


@kernel
def taken_off(information: np.ndarray, gradient: np.ndarray) -> None:
    discount(information, gradient)


def corridor(along: float, yaw: float) -> tuple[np.ndarray, np.ndarray]:
    """Normal equations of a scan that sees walls on two sides and next to nothing along the way between them."""
    c, s = np.cos(yaw), np.sin(yaw)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    a = turn @ np.array([[along, 0, 0], [0, 7e3, 1e4], [0, 1e4, 1.8e4]]) @ turn.T
    return a, a @ turn @ np.array([0.05, 0.002, -0.001])


@given(st.floats(0, 1e3), st.floats(-np.pi, np.pi))
def test_what_is_left_has_a_positive_determinant_and_the_same_solution(along: float, yaw: float) -> None:
    a, b = corridor(along, yaw)
    left, pull = a.copy(), b.copy()
    taken_off(left, pull)
    regular = 1e-3 * np.eye(3)
    assert np.linalg.eigvalsh(left + regular)[0] > 0
    assert np.allclose(np.linalg.solve(a + regular, b), np.linalg.solve(left + regular, pull), rtol=1e-2, atol=1e-3)


@pytest.mark.parametrize("along", [0.0, 1e-6, 3.882, 50.0])
def test_a_corridor_gives_finite_links(along: float) -> None:
    for yaw in np.linspace(-3, 3, 60):
        a, b = corridor(along, yaw)
        measured, out = np.zeros((1, 3)), np.zeros((1, 3, 3))
        pose = np.array([6.8, 4.0, -1.8])
        write_links(a[None], b[None], np.array([[6.1, 6.0, -0.2]]), np.array([0]), pose, measured, out)
        assert np.abs(measured).max() < 10, "the direction that the scan does not see ran away"
        assert np.isfinite(out).all()
