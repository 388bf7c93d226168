"""The places so far: numbers that stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from building import Building

from rgcore.config import Places as Settings
from rgcore.places.divide import free_mask
from rgcore.places.sofar import PlacesSoFar, Seen, survey


@pytest.fixture(scope="module")
def seen(building: Building) -> Seen:
    poses = building.trajectory.map_from_base
    iy, ix = np.nonzero(free_mask(building.free))
    points = building.free.origin + (np.stack([ix, iy], 1)[::61] + 0.5) * building.free.resolution
    return Seen(building.free, poses, np.full(len(poses), -1), points)


def told(seen: Seen, places: PlacesSoFar) -> Seen:
    """The same scans, each told to be where a survey places it."""
    return replace(seen, told=places.labels.at(seen.poses[:, :2], outside=-1))


def test_a_second_survey_of_the_same_scans_says_the_same(seen: Seen) -> None:
    first = survey(seen, PlacesSoFar(), Settings())
    second = survey(told(seen, first), first, Settings())
    assert np.array_equal(first.labels.values, second.labels.values)
    assert second.next_region == first.next_region
    assert len(second.gateways) == len(first.gateways) == 2


def test_a_region_that_was_part_of_another_for_a_while_is_itself_again(seen: Seen) -> None:
    first = survey(seen, PlacesSoFar(), Settings())
    one, other = (n for n in first.regions if (told(seen, first).told == n).any())
    mistaken = replace(first, joined={other: one}, witness=np.where(first.witness == other, one, first.witness))
    again = survey(told(seen, first), mistaken, Settings())
    assert again.regions == first.regions
    assert again.now(other) == other
