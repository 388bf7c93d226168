"""Lint: what each rule finds, that a sound map is silent, and that the remedy mends what was found."""

from __future__ import annotations

import pytest

from rgcore.model.edits import AddRegion, DeleteGateway, DeleteRegion, IgnoreFinding
from rgcore.model.lint import RULES, Finding, lint
from rgcore.model.records import Gateway, RGMap, replace


def changed(map: RGMap, kind: str, id: str, **changes: object) -> RGMap:
    items = getattr(map, kind)
    return replace(map, **{kind: {**items, id: replace(items[id], **changes)}})


def only(map: RGMap, code: str, **how: float) -> list[Finding]:
    return [f for f in lint(map, **how) if f.code == code]


def test_a_sound_map_is_silent(office: RGMap) -> None:
    assert lint(office) == []
    assert lint(RGMap()) == []


def test_a_gateway_joins_two_regions_and_the_remedy_finds_them(office: RGMap) -> None:
    map = changed(office, "gateways", "g1", regions=("r2",), gateway_points=((2.0, 2.55),))
    (f,) = only(map, "gateway-regions")
    assert (f.items, f.text) == (("g1",), "g1 (narrow_passage) joins 1 region instead of 2")
    assert f.place == (2.0, 2.05)
    assert f.remedy is not None
    mended = f.remedy.apply(map)
    assert set(mended.gateways["g1"].regions) == {"r1", "r2"}
    assert lint(mended) == []


def test_a_gateway_that_leads_nowhere_may_go(office: RGMap) -> None:
    stub = Gateway(
        id="g9",
        class_="opening",
        regions=("r1",),
        posts=((0.0, 0.5), (0.0, 1.5)),
        crossing_points=((0.0, 1.0),),
        gateway_points=((0.5, 1.0),),
    )
    (f,) = lint(replace(office, gateways={**office.gateways, "g9": stub}))
    assert f.remedy == DeleteGateway(gateway="g9")


def test_a_junction_may_join_more_or_one(office: RGMap) -> None:
    for regions in (("r1",), ("r1", "r2", "r3")):
        junction = replace(office.gateways["g1"], id="g3", class_="junction_T", regions=regions)
        assert lint(replace(office, gateways={**office.gateways, "g3": junction})) == []
    nowhere = replace(office.gateways["g1"], id="g3", class_="junction_T", regions=())
    assert [f.items for f in lint(replace(office, gateways={**office.gateways, "g3": nowhere}))] == [("g3",)]


def test_a_wide_robot_does_not_fit_and_does_not_get_there(office: RGMap) -> None:
    map = changed(office, "gateways", "g2", posts=((5.8, 2.05), (6.5, 2.05)))
    assert lint(map) == []
    narrow, lost = lint(map, robot_width=0.9)
    assert narrow.text == "g2 is 0.70 m wide; a robot of 0.90 m does not fit through though it drove through"
    assert (lost.items, lost.text) == (("r3",), "r3 (Room 2) cannot be reached from the rest: g2 is too narrow")


def test_a_region_without_a_way_to_it(office: RGMap) -> None:
    (f,) = lint(DeleteGateway(gateway="g2").apply(office))
    assert (f.code, f.text) == ("unreachable", "r3 (Room 2) cannot be reached from the rest")


def test_regions_that_overlap(office: RGMap) -> None:
    over = ((3.0, 2.1), (8.0, 2.1), (8.0, 6.0), (3.0, 6.0))
    (f,) = lint(changed(office, "regions", "r3", boundary=over))
    assert (f.code, f.items, f.text) == ("overlap", ("r2", "r3"), "r2 (Room 1) overlaps r3 (Room 2) by 3.9 m²")
    assert 3.0 < f.place[0] < 4.0
    within = ((1.0, 3.0), (3.0, 3.0), (3.0, 5.0), (1.0, 5.0))
    map = changed(office, "regions", "r3", boundary=within)
    (f,) = only(map, "overlap")
    assert f.remedy is not None
    assert "r3" not in f.remedy.apply(map).regions


def test_a_region_without_room_goes_to_its_neighbour(office: RGMap) -> None:
    sliver = ((5.0, 2.1), (7.0, 2.1), (7.0, 2.4), (5.0, 2.4))
    map = changed(office, "regions", "r3", boundary=sliver)
    (f,) = only(map, "narrow-region")
    assert f.text == "r3 (Room 2) has no room for a robot of 0.50 m"
    assert f.remedy is not None
    assert list(f.remedy.apply(map).regions) == ["r1", "r2"]


def test_walls_and_objects_belong_somewhere(office: RGMap) -> None:
    stray = changed(changed(office, "lines", "l3", regions=()), "objects", "o1", region=None)
    line, thing = lint(stray)
    assert (line.text, thing.text) == ("l3 bounds no region", "object o1 stands in no region")
    assert line.remedy is not None
    assert line.remedy.apply(stray).lines["l3"].regions == ("r2",)
    assert only(changed(stray, "lines", "l3", clutter=True), "stray-line") == []
    (f,) = lint(changed(office, "objects", "o1", center=(20.0, 5.0, 0.5)))
    assert f.text == "object o1 stands 12.0 m outside of r3, its region"


def test_two_regions_of_one_name(office: RGMap) -> None:
    map = changed(office, "regions", "r3", name="room 1")
    (f,) = lint(map)
    assert (f.items, f.text) == (("r3", "r2"), "r3 has the name of r2, Room 1")
    assert f.remedy is not None
    assert f.remedy.apply(map).regions["r3"].name == "room 2"


def test_what_is_ignored_is_not_told_again(office: RGMap) -> None:
    map = changed(office, "regions", "r3", name="room 1")
    (f,) = lint(map)
    after = IgnoreFinding(code=f.code, items=f.items).apply(map)
    assert lint(after) == []
    assert [g.id for g in lint(after, ignored=True)] == [f.id]


def test_every_rule_is_told_of_here(office: RGMap) -> None:
    wild = AddRegion(id="ru00000001", boundary=((30.0, 0.0), (30.3, 0.0), (30.3, 3.0), (30.0, 3.0))).apply(office)
    wild = changed(DeleteRegion(region="r3").apply(wild), "regions", "r2", name="Hallway 1")
    wild = changed(wild, "gateways", "g1", regions=("r2",), posts=((1.9, 2.05), (2.2, 2.05)))
    wild = changed(wild, "regions", "r2", boundary=((0.0, 1.0), (4.0, 1.0), (4.0, 6.0), (0.0, 6.0)))
    assert {f.code for f in lint(wild)} == set(RULES)
    for f in lint(wild):
        assert f.text
        assert "\n" not in f.text
        if f.remedy is not None:
            assert f.id not in {g.id for g in lint(f.remedy.apply(wild))}


@pytest.mark.parametrize("width", [0.0, 0.3, 2.0])
def test_any_width_is_answered(office: RGMap, width: float) -> None:
    assert all(f.code in RULES for f in lint(office, robot_width=width))
