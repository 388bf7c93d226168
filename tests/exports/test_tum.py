"""The trajectory: a line a scan, in the log's order, of the laser."""

from __future__ import annotations

import numpy as np
import pytest
from export_maps import ROOMS, TRAJECTORY

from rgcore.errors import RgError
from rgcore.exports.formats import render


def test_lines_stamps_and_laser_poses() -> None:
    text = render(".tum", ROOMS, TRAJECTORY).decode()
    table = np.array([line.split(" ") for line in text.splitlines()], float)
    assert table.shape == (4, 8)
    np.testing.assert_allclose(table[:, 0], TRAJECTORY.stamps, atol=1e-6)
    np.testing.assert_allclose(table[:2, 1:3], [[0.25, 0], [1, 2.25]], atol=1e-6)
    assert (table[:, 3:6] == 0).all()
    np.testing.assert_allclose(np.hypot(table[:, 6], table[:, 7]), 1, atol=1e-8)
    theta = 2 * np.arctan2(table[:, 6], table[:, 7])
    np.testing.assert_allclose(np.cos(theta - TRAJECTORY.map_from_base[:, 2]), 1, atol=1e-12)
    assert "-0.000000 " not in text


def test_without_a_trajectory() -> None:
    with pytest.raises(RgError, match="no trajectory"):
        render(".tum", ROOMS)
