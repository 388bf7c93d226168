"""What odometry is worth is learnt from the log: noisy odometry widens the prior, lies make the next lie likelier."""

from __future__ import annotations

import numpy as np
import pytest

from rgcore.slam.motion import SCALES, Motion, motion_deviation

TOLD, STEADY, SHARP = np.array([0.3, 0.0, 0.1]), np.array([0.28, 0.0, 0.12]), np.full(3, 1e-4**2)


def learnt(noise: float, errs: float, seen: np.ndarray = SHARP, steps: int = 400) -> Motion:
    """One that has seen odometry which errs by ``errs`` times what its settings say."""
    motion, chance = Motion(noise), np.random.default_rng(4)
    for _ in range(steps):
        moved = TOLD + errs * motion_deviation(TOLD, noise) * chance.normal(size=3)
        motion.learn(moved, TOLD, STEADY, seen)
    return motion


@pytest.mark.parametrize("errs", [1.0, 2.0, 3.0])
def test_the_scale_is_what_the_scans_show(errs: float) -> None:
    assert learnt(0.15, errs).scale == pytest.approx(errs, rel=0.3)


def test_doubled_noise_widens_the_prior() -> None:
    assert (learnt(0.15, 3.0).deviation(TOLD) > 1.5 * learnt(0.15, 1.5).deviation(TOLD)).all()


def test_good_odometry_is_not_trusted_beyond_its_settings() -> None:
    assert learnt(0.15, 0.1).scale == SCALES[0]


def test_what_scans_do_not_see_teaches_nothing() -> None:
    assert learnt(0.15, 3.0, seen=np.full(3, 10.0)).scale == 1.0


def test_one_lie_makes_the_next_likelier_and_truth_is_believed_again() -> None:
    motion = Motion(0.15)
    back = TOLD * [-1.0, 1.0, 1.0]
    before = motion.surprise(STEADY, back, STEADY)
    assert before > 3.0
    motion.learn(STEADY, back, STEADY, SHARP)
    assert motion.surprise(STEADY, back, STEADY) < before - 3.0
    for _ in range(10):
        motion.learn(STEADY, STEADY, STEADY, SHARP)
    assert motion.surprise(STEADY, back, STEADY) == pytest.approx(before, abs=1.0)
