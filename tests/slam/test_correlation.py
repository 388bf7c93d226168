"""Global correlation: the maximum over a window, how sure it is, and when it is none."""

from __future__ import annotations

import numpy as np
import pytest
from drives import BEARINGS, chain, ring

from rgcore.geometry import se2
from rgcore.geometry.raycast import cast
from rgcore.slam.correlation import correlate, likelihood_field
from rgcore.slam.surface import surface

WINDOW = np.array([2.0, 2.0, 0.6])


def points(walls: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Surface points (n, 2) in the frame of the laser."""
    return surface(cast(walls, pose[None], BEARINGS, 30.0)[0][0], BEARINGS, 25.0, 0.08).points


@pytest.mark.parametrize("off", [(0.0, 0.0, 0.0), (1.7, -1.2, 0.5), (-1.9, 1.9, -0.55)])
def test_finds_a_known_offset(off: tuple[float, float, float]) -> None:
    first, second = np.array([4.5, 1.0, 0.1]), np.array([5.0, 1.2, 0.3])
    field = likelihood_field(se2.transform(first, points(ring(), first)))
    peak = correlate(points(ring(), second), field, second + off, WINDOW, 0.4, 0.9)
    assert peak is not None
    assert np.hypot(*(peak.pose - second)[:2]) < 0.1
    assert abs(peak.pose[2] - second[2]) < 0.02
    assert 0.4 < peak.response <= 1.0


def test_is_the_global_maximum_of_the_window() -> None:
    """Branch and bound misses nothing: no pose of a coarse scan over the window does better."""
    pose = np.array([5.0, 1.0, 0.0])
    seen = points(ring(), pose)
    field = likelihood_field(se2.transform(pose, seen))
    peak = correlate(seen, field, pose + np.array([0.4, -0.3, 0.0]), WINDOW, 0.1, 1.0)
    assert peak is not None
    for x in np.arange(-1.5, 1.6, 0.25):
        for y in np.arange(-1.5, 1.6, 0.25):
            cells = np.floor(
                (se2.transform(pose + np.array([x, y, 0.0]), seen) - field.corner) / field.resolution
            ).astype(int)
            height, width = field.levels[0].shape
            inside = (cells >= 0).all(1) & (cells < [width, height]).all(1)
            score = field.levels[0][cells[inside, 1], cells[inside, 0]].sum() / 255.0 / len(seen)
            assert score <= peak.response + 1e-9


def test_the_covariance_is_large_along_a_corridor() -> None:
    walls = chain((-12, 0), (12, 0))
    walls = np.concatenate([walls, walls[:, ::-1] + np.array([0, 2])])
    pose = np.array([0.0, 1.0, 0.0])
    seen = points(walls, pose)
    seen = seen[np.abs(seen[:, 0]) < 6]
    peak = correlate(
        seen, likelihood_field(se2.transform(pose, points(walls, pose))), pose, np.array([0.4, 0.4, 0.2]), 0.3, 1.0
    )
    assert peak is not None
    assert peak.covariance[0, 0] > 10 * peak.covariance[1, 1]
    assert (np.linalg.eigvalsh(peak.covariance) > 0).all()


def test_what_fits_in_two_places_is_no_answer() -> None:
    comb = np.concatenate(
        [chain((x, 0), (x, 0.5), (x + 0.8, 0.5), (x + 0.8, 0), (x + 1.6, 0)) for x in np.arange(0, 16, 1.6)]
    )
    pose = np.array([8.0, -1.0, np.pi / 2])
    seen = points(comb, pose)
    seen = seen[np.hypot(seen[:, 0], seen[:, 1]) < 3]
    along = np.linspace(0.0, 1.0, 30)[None, :, None]
    field = likelihood_field((comb[:, None, 0] * (1 - along) + comb[:, None, 1] * along).reshape(-1, 2))
    assert correlate(seen, field, pose, WINDOW, 0.4, 0.9) is None
    assert correlate(seen, field, pose, WINDOW, 0.4, 1.0) is not None


def test_what_fits_nowhere_is_no_answer() -> None:
    pose = np.array([5.0, 1.0, 0.0])
    field = likelihood_field(points(chain((0, 3), (4, 3)), np.zeros(3)) + np.array([0, 40.0]))
    assert correlate(points(ring(), pose), field, pose, WINDOW, 0.3, 0.9) is None
