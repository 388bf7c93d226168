"""Lint: what each rule finds, and that a sound map is silent."""

from __future__ import annotations

from rgcore.model.checks import Finding, check
from rgcore.model.records import RGMap, replace


def test_a_sound_map_is_silent(office: RGMap) -> None:
    assert check(office) == []
    assert check(RGMap()) == []


def test_a_gateway_joins_two_regions(office: RGMap) -> None:
    g1 = replace(office.gateways["g1"], regions=("r2",))
    found = check(replace(office, gateways={**office.gateways, "g1": g1}))
    assert Finding(rule="gateway-regions", item="g1", text="g1 (narrow_passage) joins 1 region instead of 2") in found


def test_a_junction_may_join_more_or_one(office: RGMap) -> None:
    for regions in (("r1",), ("r1", "r2", "r3")):
        junction = replace(office.gateways["g1"], id="g3", class_="junction_T", regions=regions)
        assert check(replace(office, gateways={**office.gateways, "g3": junction})) == []
    nowhere = replace(office.gateways["g1"], id="g3", class_="junction_T", regions=())
    found = check(replace(office, gateways={**office.gateways, "g3": nowhere}))
    assert [(f.item, f.text) for f in found] == [("g3", "g3 (junction_T) belongs to no region")]


def test_a_gateway_names_regions_of_the_map(office: RGMap) -> None:
    g1 = replace(office.gateways["g1"], regions=("r1", "r8"))
    found = check(replace(office, gateways={**office.gateways, "g1": g1}))
    assert [f.text for f in found if f.rule == "gateway-regions"] == ["g1 names r8, which is not in the map"]


def test_a_region_without_a_way_to_it(office: RGMap) -> None:
    found = check(replace(office, gateways={"g1": office.gateways["g1"]}))
    assert found == [Finding(rule="unreachable", item="r3", text="r3 (Room 2) cannot be reached from the rest")]


def test_two_regions_of_one_name(office: RGMap) -> None:
    named = replace(office.regions["r3"], name="room 1")
    found = check(replace(office, regions={**office.regions, "r3": named}))
    assert [(f.rule, f.item) for f in found] == [("duplicate-name", "r2"), ("duplicate-name", "r3")]
