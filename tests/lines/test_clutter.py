"""Short lines through scattered echoes."""

from __future__ import annotations

import numpy as np

from rgcore.geometry import segments as geometry
from rgcore.lines.clutter import strips


def test_echoes_all_in_one_place_are_a_short_line() -> None:
    """As a robot that stands still sees a leg, with a laser that counts in centimetres."""
    lines = strips(np.tile([1.0, 2.0], (5, 1)), np.tile([1.0, 0.0], (5, 1)))
    assert len(lines) >= 1
    assert np.isfinite(lines).all()
    assert (geometry.lengths(lines) > 0.01).all()
    assert (np.abs(lines.mean(1) - [1.0, 2.0]) < 1e-3).all()
