"""Asking a map: where a point is, what is there, what a laser would see, and how fast the answers come."""

from __future__ import annotations

import time

import numpy as np
import pytest
from asked_map import ISLAND, asked_map
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import Point, Polygon

from rgcore.errors import QueryError
from rgcore.model.records import RGMap
from rgcore.pipeline import Run
from rgcore.robot.query import Query

ASKED = Query(asked_map())


def test_a_point_is_in_its_region() -> None:
    points = np.array([[1, 1], [1, 5], [15, 11], [21, 11], [24, 1], [30, 1], [3, 2.05]])
    assert ASKED.region_of(points).tolist() == [0, 1, 3, 4, 5, -1, -1]
    assert ASKED.region_of(np.zeros((0, 2))).tolist() == []
    assert ASKED.region_of(np.array([[np.nan, 1.0]])).tolist() == [-1]


def test_an_edge_belongs_to_the_region_and_an_island_does_not() -> None:
    corner, edge, beyond = [0.0, 0.0], [22.0, 1.0], [np.nextafter(22.0, 23.0), 1.0]
    on_island, in_island = [18.0, 9.0], [19.0, 9.0]
    assert ASKED.region_of(np.array([corner, edge, beyond, on_island, in_island])).tolist() == [0, 0, -1, 4, -1]


def test_region_at_gives_the_record() -> None:
    found = ASKED.region_at(1.0, 5.0)
    assert found is not None
    assert (found.id, found.name) == ("r2", "Office")
    assert ASKED.region_at(*np.mean(ISLAND, 0)) is None


@given(st.lists(st.tuples(st.floats(-2, 28), st.floats(-2, 14)), min_size=1, max_size=30))
def test_many_points_are_asked_as_one_by_one(points: list[tuple[float, float]]) -> None:
    shapes = [Polygon(r.boundary, r.holes) for r in ASKED.map.regions.values()]
    singly = [next((i for i, s in enumerate(shapes) if s.intersects(Point(p))), -1) for p in points]
    assert ASKED.region_of(np.array(points)).tolist() == singly


def test_the_rooms_of_the_demo_know_their_gateway_points(office: Run) -> None:
    asked, ids = Query(office.map), list(office.map.regions)
    for g in office.map.gateways.values():
        assert [ids[i] for i in asked.region_of(np.array(g.gateway_points))] == list(g.regions), g.id


def test_a_million_points_a_second(office: Run) -> None:
    asked = Query(office.map)
    corners = np.array([p for r in office.map.regions.values() for p in r.boundary])
    points = np.random.default_rng(0).uniform(corners.min(0), corners.max(0), (300_000, 2))
    began = time.process_time()
    found = asked.region_of(points)
    assert time.process_time() - began < 0.3
    assert (found >= 0).mean() > 0.5


def test_gateways_from_a_region_or_a_pose() -> None:
    def names(place: object, width: float = 0.0) -> list[str]:
        return [g.id for g in ASKED.gateways_from(place, width)]  # type: ignore[arg-type]

    assert names("r1") == ["g1", "g2", "g3", "g5"]
    assert names("r1", 0.8) == ["g1", "g3", "g5"]
    assert names((15.0, 5.0, 1.57)) == ["g3", "g4"]
    assert names("office") == ["g1"]
    assert names("r6") == []
    assert names((3.0, 2.05)) == ["g1", "g2", "g3", "g5"], "a robot on a doorstep is in the nearest region"


def test_a_place_that_is_not_there_is_told() -> None:
    with pytest.raises(QueryError, match="no region is Attic"):
        ASKED.gateways_from("Attic")
    with pytest.raises(QueryError, match=r"\(30\.00, 1\.00\) lies in no region; the nearest, r6, is 4\.0 m away"):
        ASKED.objects_in((30.0, 1.0))
    assert ASKED.why_not((np.nan, 1.0), "r1") == (
        "the start must be a region, or x, y [m] and maybe an angle; it is (nan, 1.0)"
    )
    assert ASKED.why_not("r1", "r2", -1.0) == "the width of a robot must be 0 m or more; it is -1.0"
    assert Query(RGMap()).why_not((0, 0), (1, 1)) == "the start (0.00, 0.00) lies in no region"


def test_objects_in_a_region() -> None:
    assert [o.label for o in ASKED.objects_in("Lab")] == ["bench"]
    assert ASKED.objects_in((1.0, 1.0)) == []


def test_a_predicted_scan_ends_at_the_lines() -> None:
    ranges = ASKED.predicted_scan((20.0, 1.0, 0.0), np.array([-np.pi / 2, -np.pi / 4, 0.0, np.pi / 2]), 10.0)
    assert ranges == pytest.approx([1.0, np.sqrt(2), 2.0, np.inf])


def test_unexplored_gateways_were_not_passed_or_lead_nowhere() -> None:
    assert [g.id for g in ASKED.unexplored()] == ["g2", "g5"]
