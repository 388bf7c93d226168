"""Regions of a building that is known."""

from __future__ import annotations

import numpy as np
import pytest
from building import CABINET, HALL, LEFT, Building
from shapely.geometry import Point, Polygon

from rgcore.geometry import se2
from rgcore.places.regions import region_of_segments


def area(box: tuple[float, float, float, float]) -> float:
    return (box[2] - box[0]) * (box[3] - box[1])


def outline(building: Building, x: float, y: float) -> Polygon:
    region = building.places.regions[building.at(x, y)]
    return Polygon(region.boundary, region.holes)


def test_each_room_is_a_region(building: Building) -> None:
    found = {building.at(1, 1), building.at(2.5, 3), building.at(7.5, 3)}
    assert -1 not in found
    assert len(found) == len(building.places.regions) == 3


def test_a_region_covers_its_room(building: Building) -> None:
    assert outline(building, 1, 1).area == pytest.approx(area(HALL), rel=0.05)
    assert outline(building, 2.5, 3).area == pytest.approx(area(LEFT) - 2 * area(CABINET), rel=0.06)


def test_outlines_are_simple_rings_that_run_counter_clockwise(building: Building) -> None:
    for region in building.places.regions:
        ring = Polygon(region.boundary)
        assert ring.is_valid
        assert ring.exterior.is_ccw
        assert region.boundary[0] != region.boundary[-1]


def test_a_hallway_has_straight_edges(building: Building) -> None:
    corners = np.array(building.places.regions[building.at(1, 1)].boundary)
    edges = np.roll(corners, -1, axis=0) - corners
    length = np.hypot(*edges.T)
    slope = np.arctan2(edges[:, 1], edges[:, 0]) - building.map_from_plan[2]
    off = np.abs((slope + np.pi / 4) % (np.pi / 2) - np.pi / 4)
    assert length[off < np.radians(2)].sum() > 0.85 * length.sum()
    assert len(corners) <= 24


def test_regions_do_not_overlap(building: Building) -> None:
    shapes = [Polygon(r.boundary, r.holes) for r in building.places.regions]
    for i, a in enumerate(shapes):
        for b in shapes[i + 1 :]:
            assert a.intersection(b).area < 0.1


def test_the_box_holds_where_the_robot_can_be(building: Building) -> None:
    region = building.places.regions[building.at(1, 1)]
    assert region.box_size == pytest.approx((HALL[2] - 0.5, HALL[3] - 0.5), abs=0.25)
    turn = (region.box_yaw - building.map_from_plan[2] + np.pi / 2) % np.pi - np.pi / 2
    assert turn == pytest.approx(0, abs=0.02)


def test_regions_are_numbered_by_the_first_scan_inside(building: Building) -> None:
    first = [r.first_scan for r in building.places.regions]
    assert first[0] == 0
    assert first[-1] == -1, "the room that was only looked into comes last"
    assert building.at(7.5, 3) == len(first) - 1


def test_both_sides_of_a_thin_wall_belong_to_their_own_regions(building: Building) -> None:
    owner = region_of_segments(building.segments, building.trajectory, building.found)
    ends = se2.transform(building.trajectory.map_from_laser[building.segments.scan][:, None], building.segments.ends)
    middle = se2.transform(se2.invert(building.map_from_plan), ends.mean(1))
    free_side = np.diff(se2.transform(se2.invert(building.map_from_plan), ends), axis=1)[:, 0]
    wall = (middle[:, 0] > 0.3) & (middle[:, 0] < 3.2) & (np.abs(middle[:, 1] - 2.06) < 0.2)
    below, above = wall & (free_side[:, 0] < 0), wall & (free_side[:, 0] > 0)
    assert below.sum() > 10
    assert above.sum() > 10
    assert (owner[below] == building.at(1, 1)).mean() > 0.98
    assert (owner[above] == building.at(2.5, 3)).mean() > 0.98


def test_every_pose_lies_in_the_region_around_it(building: Building) -> None:
    labels = building.places.labels.at(building.trajectory.map_from_base[:, :2], outside=-1)
    shapes = [Polygon(r.boundary).buffer(0.1) for r in building.places.regions]
    inside = [
        i < 0 or shapes[i].contains(Point(p)) for i, p in zip(labels, building.trajectory.map_from_base, strict=True)
    ]
    assert np.mean(labels >= 0) > 0.97
    assert all(inside)
