"""From evidence to records: ids, names, which regions list a line, accuracy, counts; exact numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rgcore.config import Config, Slam
from rgcore.geometry.grid import Grid
from rgcore.lines.accuracy import Accuracy
from rgcore.lines.merge import Lines
from rgcore.model.assemble import assemble
from rgcore.model.base import decode_map, encode_map
from rgcore.model.records import RGMap
from rgcore.places.classify import Classes
from rgcore.places.objects import FoundObject
from rgcore.places.places import FoundGateway, FoundRegion, Places
from rgcore.scans.extract import Segments
from rgcore.scans.log import ScanLog

SCANS = 10


def found_region(x: float) -> FoundRegion:
    return FoundRegion(
        boundary=((x, 0.0), (x + 1 / 3, 0.0), (x + 1.0, 1.0), (x, 1.0)),
        box_center=(x + 0.5, 0.5),
        box_size=(1.0, 1.0),
        box_yaw=-1e-9,
        first_scan=0,
    )


@pytest.fixture
def map() -> RGMap:
    """Scans 0-5 are taken in region 0, 6-8 in region 1, scan 9 nowhere; nobody was in region 2 and 3."""
    ranges = np.full((SCANS, 4), 2.0)
    ranges[0] = [np.inf, np.nan, 30.0, 5.0]
    zeros = np.zeros
    log = ScanLog(np.arange(10.0), ranges, zeros((10, 3)), zeros(4), zeros(3), 80.0, True, "a.log", "12", "carmen")
    scan_regions = np.array([0] * 6 + [1] * 3 + [-1])
    # line 0 is of region 0 and was seen 3 times from region 1; line 1 is of region 1 and was seen twice from region 0
    scan = np.array([0, 1, 6, 7, 8, 0, 1, 6, 9, 3, 4, 5])
    line_of = np.array([0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2])
    n = len(scan)
    segments = Segments(np.zeros((n, 2, 2)), scan, np.zeros((n, 2)), np.full(n, 9), np.zeros(n), np.zeros((n, 3)))
    lines = Lines(
        ends=np.array([[[0, 0], [1, 0]], [[1, 0], [2, 1 / 3]], [[5, 5], [6, 5]]], float),
        moments=np.zeros((3, 6)),
        support=np.array([5, 4, 3]),
        rms=np.array([0.01234567, np.nan, 0.0]),
        region=np.array([0, 1, -1]),
        first_scan=np.array([0, 0, 3]),
        covariance=np.array([[1e-4, 0, 4e-6], [0, 0, 0], [4e-6, 0, 1e-6]]),
    )
    gateway = FoundGateway(
        class_="narrow_passage",
        confidence=0.87654321,
        regions=(0, 1),
        posts=((1.0, 0.0), (1.0, 1.0)),
        crossing_points=((1.0, 0.5),),
        gateway_points=((0.5, 0.5), (1.5, 0.5)),
        traversal_directions=(0.0, math.pi),
        passed=True,
        first_scan=5,
    )
    places = Places(Grid(np.zeros((1, 1), np.int32), np.zeros(2), 0.05), tuple(map_regions()), (gateway,))
    scores = np.eye(4)[[0, 2, 3, 1]] * 0.97 + 0.0075
    axes = np.array([[0.1, np.nan], [math.pi - 1e-9, math.pi / 2], [np.nan, np.nan], [1.0, 2.0]])
    classes = Classes(scores, axes, np.zeros((4, 36)), np.zeros((4, 6)))
    accuracy = Accuracy(np.array([3.0, 4.0, *[np.nan] * 4, 1.0, 1.0, 1.0, 2.0]), *np.zeros((2, 10), int), np.zeros(10))
    thing = FoundObject(
        label="cabinet", center=(0.5, 0.9, 0.5), size=(0.8, 0.4, 1.0), yaw=0.0, lines=(0, 2), region=1, confidence=0.6
    )
    config = Config(slam=Slam(max_range=20.0))
    return assemble(log, config, segments, places, lines, line_of, accuracy, classes, (thing,), scan_regions)


def map_regions() -> list[FoundRegion]:
    return [found_region(float(x)) for x in range(4)]


def test_ids_number_by_first_seen(map: RGMap) -> None:
    assert [list(m) for m in (map.lines, map.regions, map.gateways, map.objects)] == [
        ["l1", "l2", "l3"],
        ["r1", "r2", "r3", "r4"],
        ["g1"],
        ["o1"],
    ]
    assert all(v.id == k for m in (map.lines, map.regions, map.gateways, map.objects) for k, v in m.items())


def test_regions_are_named_by_class(map: RGMap) -> None:
    named = [(r.class_, r.name) for r in map.regions.values()]
    assert named == [("CDMA", "Hallway 1"), ("TOMA", "Room 1"), ("CC", "Cluttered room 1"), ("ODMA", "Hallway 2")]
    assert map.regions["r2"].class_scores == {"CDMA": 0.0075, "ODMA": 0.0075, "TOMA": 0.9775, "CC": 0.0075}


def test_a_line_lists_its_home_first_and_then_those_that_see_it(map: RGMap) -> None:
    assert [line.regions for line in map.lines.values()] == [("r1", "r2"), ("r2",), ("r1",)]
    assert map.lines_of("r1") == ["l1", "l3"]


def test_accuracy_is_that_of_the_regions_own_scans(map: RGMap) -> None:
    assert [r.accuracy for r in map.regions.values()] == [pytest.approx(math.sqrt(12.5), abs=1e-6), 1.0, None, None]
    assert [r.scans for r in map.regions.values()] == [6, 3, 0, 0]
    assert map.stats.accuracy == pytest.approx(math.sqrt((9 + 16 + 3 + 4) / 6), abs=1e-6)
    assert map.stats.accuracy_penalty == Config().accuracy.penalty


def test_counts_and_source(map: RGMap) -> None:
    assert (map.stats.scans, map.stats.points, map.stats.segments) == (SCANS, 37, 12)
    assert (map.source.log, map.source.settings) == ("a.log", {"slam.max_range": 20.0})
    assert map.source.software.startswith("rgviz ")


def test_axes_lie_in_half_a_turn_and_absent_ones_are_left_out(map: RGMap) -> None:
    assert [r.axes for r in map.regions.values()] == [(0.1,), (0.0, 1.570796), (), (1.0, 2.0)]


def test_gateways_and_objects_name_their_regions_and_lines(map: RGMap) -> None:
    g, o = map.gateways["g1"], map.objects["o1"]
    assert (g.regions, g.posts, g.confidence, g.passed) == (("r1", "r2"), ((1.0, 0.0), (1.0, 1.0)), 0.876543, True)
    assert (o.label, o.lines, o.region, o.size) == ("cabinet", ("l1", "l3"), "r2", (0.8, 0.4, 1.0))


def test_numbers_are_micrometres_and_survive_json(map: RGMap) -> None:
    assert map.lines["l2"].end == (2.0, 0.333333)
    assert (map.lines["l1"].residual, map.lines["l2"].residual) == (0.012346, None)
    assert [v.deviation for v in map.lines.values()] == [(0.01, 0.002), None, (0.002, 0.001)]
    assert str(map.regions["r1"].box.yaw) == "0.0"  # never -0.0
    assert decode_map(encode_map(map)) == map
