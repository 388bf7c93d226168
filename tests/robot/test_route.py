"""Ways from place to place: as short as they can be, within the regions, through the gateways that they name."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from asked_map import asked_map, door, region
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, unary_union
from shapely.geometry import Point, Polygon

from rgcore.errors import NoRoute
from rgcore.model.records import Line, RGMap, replace
from rgcore.pipeline import Run
from rgcore.robot.query import Query
from rgcore.robot.route import Route

ASKED = Query(asked_map())


def check(map: RGMap, route: Route, width: float = 0.0) -> None:
    """What is true of every route: its length, its regions and gateways in turn, free space under all of it."""
    steps = np.diff(route.waypoints, axis=0)
    assert route.length == pytest.approx(np.hypot(*steps.T).sum())
    assert route.length >= np.hypot(*(route.waypoints[-1] - route.waypoints[0])) - 1e-9
    assert len(route.regions) == len(route.gateways) + 1
    way = LineString(route.waypoints) if len(route.waypoints) > 1 else Point(route.waypoints[0])
    for g, sides in zip(route.gateways, pairwise(route.regions), strict=True):
        assert set(sides) <= set(map.gateways[g].regions)
        assert map.gateways[g].width >= width
        assert way.distance(LineString(map.gateways[g].posts)) < 1e-6, f"{g} is named, not crossed"
    rooms = [Polygon(map.regions[r].boundary, map.regions[r].holes) for r in route.regions]
    doors = [LineString(map.gateways[g].posts).buffer(0.2, cap_style="flat") for g in route.gateways]
    assert way.difference(unary_union(rooms + doors).buffer(1e-4)).length == 0.0, "leaves the regions"


def test_a_straight_way_within_a_region() -> None:
    route = ASKED.route((1.0, 1.0), (21.0, 1.0, 3.0))
    assert (route.regions, route.gateways) == (("r1",), ())
    assert route.waypoints.tolist() == [[1, 1], [21, 1]]
    assert route.length == 20.0


def test_a_way_over_gateways_names_them() -> None:
    route = ASKED.route("Office", (21.0, 11.0), width=0.5)
    assert route.regions == ("r2", "r1", "r4", "r5")
    assert route.gateways == ("g1", "g3", "g4")
    check(ASKED.map, route, 0.5)


def test_a_way_around_an_island_is_the_shortest_with_room_on_both_sides() -> None:
    """From the left of a square island of 2 m to its right, half a width off its corners."""
    start, goal = (17.0, 9.3), (21.0, 9.3)
    thin = ASKED.route(start, goal)
    assert thin.length == pytest.approx(2 * np.hypot(1.0, 0.7) + 2.0)
    wide = ASKED.route(start, goal, width=0.8)
    check(ASKED.map, wide, 0.8)
    assert LineString(wide.waypoints).distance(Polygon(ASKED.map.regions["r5"].holes[0])) >= 0.4 - 1e-6
    arcs = 2 * np.sqrt(1 + 0.7**2 - 0.4**2) + 2.0 + 0.8 * np.pi / 2
    assert thin.length < wide.length < arcs + 0.2


def test_a_start_at_a_wall_comes_straight_out() -> None:
    route = ASKED.route((5.0, 0.05), (9.0, 0.05), width=0.6)
    check(ASKED.map, route)
    assert route.waypoints.tolist() == pytest.approx(np.array([[5, 0.05], [5, 0.3], [9, 0.3], [9, 0.05]]))


def test_the_way_to_where_one_is() -> None:
    route = ASKED.route((1.0, 1.0), (1.0, 1.0))
    assert (route.regions, route.gateways, route.length) == (("r1",), (), 0.0)


def test_a_wide_opening_is_crossed_where_it_is_near() -> None:
    hall, lobby = region("r1", "", (0.0, 0.0), (10.0, 2.0)), region("r2", "", (0.0, 2.0), (10.0, 6.0))
    opening = door("g1", ("r1", "r2"), (5.0, 2.0), 9.0)
    asked = Query(RGMap(regions={"r1": hall, "r2": lobby}, gateways={"g1": opening}))
    route = asked.route((1.0, 1.0), (1.0, 5.0), width=0.6)
    check(asked.map, route, 0.6)
    assert route.length < 4.1


def test_a_junction_leads_from_each_arm_to_each_other() -> None:
    arms = {
        "r1": region("r1", "", (0.0, 0.0), (4.0, 2.0)),
        "r2": region("r2", "", (6.0, 0.0), (10.0, 2.0)),
        "r3": region("r3", "", (4.0, -4.0), (6.0, -0.1)),
    }
    junction = replace(
        door("g1", ("r1", "r2", "r3"), (5.0, 1.0), 2.0),
        class_="junction_T",
        crossing_points=((4.0, 1.0), (6.0, 1.0), (5.0, -0.1)),
        gateway_points=((3.5, 1.0), (6.5, 1.0), (5.0, -0.6)),
    )
    asked = Query(RGMap(regions=arms, gateways={"g1": junction}))
    for a in arms:
        for b in set(arms) - {a}:
            route = asked.route(a, b, 0.5)
            assert (route.regions, route.gateways) == ((a, b), ("g1",))


def test_why_there_is_no_way() -> None:
    assert ASKED.why_not("r1", "r3", 0.6) is None
    narrow = "r3 can only be reached from r1 through g2, which is 0.62 m wide; the robot is 0.80 m wide"
    assert ASKED.why_not("r1", "r3", 0.8) == narrow
    assert ASKED.why_not("r3", "r1", 0.8) == narrow.replace("r3", "r#").replace("r1", "r3").replace("r#", "r1")
    assert ASKED.why_not("r1", "r6") == "no gateway leads to r6"
    assert ASKED.why_not("r1", (19.0, 9.0)) == (
        "the goal (19.00, 9.00) lies in no region; the nearest, r5, is 1.0 m away"
    )
    with pytest.raises(NoRoute, match="r3 can only be reached"):
        ASKED.route("r1", "r3", 0.8)


def test_of_two_narrow_doors_both_are_named() -> None:
    second = door("g6", ("r1", "r3"), (8.0, 2.05), 0.7)
    asked = Query(replace(ASKED.map, gateways={**ASKED.map.gateways, "g6": second}))
    assert asked.route("r1", "r3", 0.65).gateways == ("g6",)
    said = asked.why_not("r2", "r3", 0.75)
    assert said == "r3 can only be reached from r2 through g2 (0.62 m) or g6 (0.70 m); the robot is 0.75 m wide"


def test_furniture_in_the_way_is_told_with_the_region() -> None:
    """A shelf across hallway 2 that leaves 0.5 m: wide enough a gateway, too little room behind it."""
    shelf = ((14.5, 5.0), (14.5, 5.5), (15.5, 5.5), (15.5, 5.0))
    hall = replace(ASKED.map.regions["r4"], holes=(shelf,))
    asked = Query(replace(ASKED.map, regions={**ASKED.map.regions, "r4": hall}))
    check(asked.map, asked.route("r2", "r5", 0.45), 0.45)
    assert asked.why_not("r2", "r5", 0.7) == "in r4 there is no way 0.70 m wide from g3 to g4"
    assert asked.why_not("r2", (15.0, 10.0), 0.7) == "in r4 there is no way 0.70 m wide from g3 to the goal"


def test_a_way_keeps_off_the_lines_in_a_region() -> None:
    """A screen of 2 m in the middle of the office, no hole in its outline; the walls around it are lines as well."""
    screen = Line(id="l3", start=(3.0, 4.0), end=(3.0, 6.0), regions=("r2",))
    wall = Line(id="l4", start=(0.0, 8.0), end=(0.0, 2.05), regions=("r2",))
    asked = Query(replace(ASKED.map, lines={**ASKED.map.lines, "l3": screen, "l4": wall}))
    for width in (0.0, 0.5):
        route = asked.route((2.0, 5.0), (4.0, 5.0), width)
        assert (
            LineString(route.waypoints).distance(LineString([screen.start, screen.end])) >= max(0.01, width / 2) - 1e-6
        )
        assert 2 * np.hypot(1.0, 1.0 + width / 2) <= route.length < 2 * np.hypot(1.0, 1.0 + width / 2) + 0.6


def test_a_robot_wider_than_the_room() -> None:
    assert ASKED.why_not("r1", (21.0, 1.0), 2.5) == "a robot 2.50 m wide does not fit into r1 at the start"


@given(
    st.tuples(st.floats(0.3, 21.7), st.floats(0.3, 1.7)),
    st.tuples(st.floats(16.4, 21.7), st.floats(2.4, 7.7)),
    st.floats(0.0, 0.6),
)
def test_a_way_there_is_as_long_as_back(a: tuple[float, float], b: tuple[float, float], width: float) -> None:
    width = round(width, 1)  # few widths: the roads of each are kept
    there, back = ASKED.route(a, b, width), ASKED.route(b, a, width)
    check(ASKED.map, there, width)
    assert there.length == pytest.approx(back.length)
    assert there.regions == back.regions[::-1]


@pytest.mark.parametrize("width", [0.0, 0.6])
def test_from_each_room_of_the_demo_to_the_farthest(office: Run, width: float) -> None:
    asked = Query(office.map)
    middles = {k: np.array(r.box.center) for k, r in office.map.regions.items()}
    for a in middles:
        b = max(middles, key=lambda k: float(np.hypot(*(middles[k] - middles[a]))))
        route = asked.route(a, b, width)
        assert (route.regions[0], route.regions[-1]) == (a, b)
        check(office.map, route, width)
