"""The automaton: what it tells of a robot that goes from room to room."""

from __future__ import annotations

import msgspec
import numpy as np

from rgcore.places.automaton import (
    LEAST,
    PAST,
    AnyEvent,
    Automaton,
    GatewayEntered,
    GatewayLeft,
    Passage,
    RegionClassed,
    RegionFound,
    RegionLeft,
    RegionRecognised,
    RegionsJoined,
    Sight,
)
from rgcore.places.classify import CLASSES

DOOR = Passage("g1", (5.0, 0.0), True)
UNKNOWN = Passage("g2", (5.0, 0.0), False)


def sight(scan: int, x: float, here: str | None, passage: Passage | None = None, scans: int = 0, **kw: object) -> Sight:
    return Sight(scan, 0.1 * scan, (x, 0.0, 0.0), here, scans, passage, **kw)  # type: ignore[arg-type]


def looks(name: str) -> np.ndarray:
    return np.where([c == name for c in CLASSES], 0.85, 0.05)


def in_first_room() -> Automaton:
    automaton = Automaton("r1")
    assert automaton.step(sight(0, 0.0, None)) == [RegionFound(scan=0, stamp=0.0, pose=(0.0, 0.0, 0.0), region="r1")]
    assert automaton.state == "in-unclassified"
    return automaton


def kinds(events: list) -> list[type]:
    return [type(e) for e in events]


def test_a_known_gateway_leads_to_a_new_region_and_back_to_one_that_is_recognised() -> None:
    automaton = in_first_room()
    assert kinds(automaton.step(sight(1, 5.1, "r1", DOOR))) == [GatewayEntered]
    assert automaton.step(sight(2, 5.0 + 0.9 * PAST, "r2")) == []
    assert kinds(automaton.step(sight(3, 5.6, "r2"))) == [GatewayLeft, RegionLeft, RegionFound]
    assert automaton.region == "r2"
    automaton.step(sight(4 + LEAST, 4.9, "r2", DOOR))
    back = automaton.step(sight(5 + LEAST, 4.4, "r1"))
    assert kinds(back) == [GatewayLeft, RegionLeft, RegionRecognised]
    assert back[-1].region == "r1"
    assert back[-1].gateway == "g1"


def test_behind_an_unknown_gateway_nothing_is_told_until_a_map_knows_what_lies_there() -> None:
    automaton = in_first_room()
    entered = automaton.step(sight(1, 5.1, "r1", UNKNOWN))
    assert kinds(entered) == [GatewayEntered]
    assert not entered[0].known
    assert automaton.state == "entering-unknown"
    assert automaton.step(sight(2, 6.0, "r1", scans=1)) == []
    assert automaton.region is None
    assert kinds(automaton.step(sight(3, 6.2, "r2", scans=3))) == [GatewayLeft, RegionLeft, RegionFound]
    assert automaton.state == "in-unclassified"


def test_what_was_no_gateway_leaves_the_robot_where_it_was() -> None:
    automaton = in_first_room()
    automaton.step(sight(1, 5.1, "r1", UNKNOWN))
    assert kinds(automaton.step(sight(2, 6.0, "r1", scans=3))) == [GatewayLeft]
    assert automaton.region == "r1"


def test_a_robot_that_turns_back_in_an_unknown_gateway_is_where_it_came_from() -> None:
    automaton = in_first_room()
    automaton.step(sight(1, 5.1, "r1", UNKNOWN))
    automaton.step(sight(2 + LEAST, 4.9, None, UNKNOWN))
    assert automaton.region == "r1"
    assert kinds(automaton.step(sight(3 + LEAST, 4.2, None))) == [GatewayLeft]


def test_a_few_scans_on_the_other_side_of_a_border_are_no_change() -> None:
    automaton = in_first_room()
    for k in range(1, LEAST):
        assert automaton.step(sight(k, 0.0, "r2")) == []
    automaton.step(sight(LEAST, 0.0, "r1"))
    told = [automaton.step(sight(LEAST + 1 + k, 0.0, "r2")) for k in range(LEAST)]
    assert [kinds(t) for t in told] == [[]] * (LEAST - 1) + [[RegionLeft, RegionFound]]


def test_a_class_is_told_when_it_is_sure_and_does_not_flicker() -> None:
    automaton = in_first_room()
    told = [e for k in range(1, 40) for e in automaton.step(sight(k, 0.0, "r1", chance=looks("CDMA")))]
    assert [e.class_ for e in told if isinstance(e, RegionClassed)] == ["CDMA"]
    assert automaton.state == "in-CDMA"
    mixed = [looks("TOMA" if k % 2 else "CDMA") for k in range(200)]
    later = [e for k, c in enumerate(mixed) for e in automaton.step(sight(40 + k, 0.0, "r1", chance=c))]
    assert later == []
    turned = [e for k in range(60) for e in automaton.step(sight(300 + k, 0.0, "r1", chance=looks("TOMA")))]
    assert [e.class_ for e in turned] == ["TOMA"]


def test_regions_that_are_one_are_joined_and_told_once() -> None:
    automaton = in_first_room()
    assert automaton.join(1, 0.1, (0.0, 0.0, 0.0), "r9", "r2") == []
    joined = automaton.join(1, 0.1, (0.0, 0.0, 0.0), "r1", "r2")
    assert kinds(joined) == [RegionsJoined]
    assert automaton.region == "r2"


def test_a_region_that_is_no_longer_part_of_another_is_recognised() -> None:
    automaton = in_first_room()
    automaton.step(sight(1, 5.1, "r1", DOOR))
    automaton.step(sight(2, 5.6, "r2"))
    automaton.join(3, 0.3, (5.6, 0.0, 0.0), "r1", "r2")
    assert "r1" not in automaton.known
    automaton.part("r1")
    automaton.step(sight(4 + LEAST, 4.9, "r2", DOOR))
    assert kinds(automaton.step(sight(5 + LEAST, 4.4, "r1"))) == [GatewayLeft, RegionLeft, RegionRecognised]


def test_events_go_to_json_and_back() -> None:
    automaton = in_first_room()
    events = automaton.step(sight(1, 5.1, "r1", DOOR))
    assert msgspec.json.decode(msgspec.json.encode(events), type=list[AnyEvent]) == events
