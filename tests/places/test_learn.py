"""A class learned from a few examples."""

from __future__ import annotations

import numpy as np
import pytest

from rgcore.places.learn import FEWEST, features, learn
from rgcore.places.places import FoundRegion

CHANCE = np.random.default_rng(4)


def regions(count: int, like: float) -> np.ndarray:
    return CHANCE.normal(like, 0.15, (count, 13))


def test_regions_like_the_examples_score_high_and_others_low() -> None:
    examples, same, others = regions(3, 2.0), regions(4, 2.0), regions(20, 0.0)
    found = learn(examples, np.concatenate([same, others]))
    assert found.scores(same).min() > 0.5
    assert found.scores(others).max() < 0.1


def test_no_region_is_proposed_where_all_are_alike() -> None:
    every = regions(30, 1.0)
    assert learn(every[:3], every[3:]).scores(every[3:]).max() < 0.5


def test_features_in_which_all_regions_are_alike_say_nothing() -> None:
    every = np.zeros((20, 13))
    every[:6, 1:3] = 3.0
    scores = learn(every[:3], every[3:]).scores(every[3:])
    assert scores[:3].min() > 0.5 > 0.2 > scores[3:].max()


@pytest.mark.parametrize("count", range(FEWEST))
def test_too_few_examples_are_refused(count: int) -> None:
    with pytest.raises(ValueError, match="at least 2 examples"):
        learn(regions(count, 0.0), regions(5, 0.0))


def test_features_tell_size_and_furniture() -> None:
    def room(size: float, tables: int) -> np.ndarray:
        corners = ((0.0, 0.0), (size, 0.0), (size, size), (0.0, size))
        found = FoundRegion(boundary=corners, box_center=(0, 0), box_size=(size, size), box_yaw=0.0, first_scan=-1)
        lines = np.array([corners, (*corners[1:], corners[0])], float).transpose(1, 0, 2)
        return features(found, [((0.0, 0.0), (0.9, 0.0))], lines, (tables, 0), (0.1, 0.1))

    small, large, tabled = room(3.0, 0), room(8.0, 0), room(3.0, 2)
    assert large[2] - small[2] == pytest.approx(2 * np.log(8 / 3))
    assert np.nonzero(tabled != small)[0].tolist() == [9]
    assert small[7] == pytest.approx(1.0)
