"""Gateways of a building that is known."""

from __future__ import annotations

import numpy as np
import pytest
from building import DOORS, WALL, Building

from rgcore.geometry import se2
from rgcore.places.places import FoundGateway


def gateway(building: Building, door: tuple[float, float]) -> FoundGateway:
    """The gateway nearest to a door of the plan."""
    middle = se2.transform(building.map_from_plan, np.array([sum(door) / 2, 2 + WALL / 2]))
    return min(building.places.gateways, key=lambda g: float(np.hypot(*(np.mean(g.posts, 0) - middle))))


def test_two_doors_and_no_gap_between_cabinets(building: Building) -> None:
    assert len(building.places.gateways) == 2


@pytest.mark.parametrize("door", DOORS)
def test_posts_stand_at_the_jambs(building: Building, door: tuple[float, float]) -> None:
    posts = se2.transform(se2.invert(building.map_from_plan), np.array(gateway(building, door).posts))
    assert np.sort(posts[:, 0]) == pytest.approx(door, abs=0.1)
    assert posts[:, 1] == pytest.approx(2 + WALL / 2, abs=0.15)


def test_only_the_door_that_was_driven_through_counts_as_passed(building: Building) -> None:
    entered, looked = (gateway(building, d) for d in DOORS)
    assert entered.passed
    assert entered.first_scan >= 0
    assert not looked.passed
    assert looked.first_scan == -1


@pytest.mark.parametrize("door", DOORS)
def test_each_gateway_point_lies_in_its_region(building: Building, door: tuple[float, float]) -> None:
    g = gateway(building, door)
    labels = building.places.labels.at(np.array(g.gateway_points))
    assert tuple(labels) == g.regions
    assert len(set(g.regions)) == 2


@pytest.mark.parametrize("door", DOORS)
def test_it_is_crossed_in_the_middle_and_square_to_the_wall(building: Building, door: tuple[float, float]) -> None:
    g = gateway(building, door)
    assert g.crossing_points[0] == pytest.approx(np.mean(g.posts, 0), abs=1e-3)
    off = np.array(g.traversal_directions) - building.map_from_plan[2]
    assert np.abs(np.cos(off)) == pytest.approx([0, 0], abs=0.2)
    assert g.class_ == "narrow_passage"
    assert 0.6 < g.confidence <= 1
