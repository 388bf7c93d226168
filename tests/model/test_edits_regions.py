"""Edits of outlines: what is split, merged, drawn and taken away, and that everything goes with the ground."""

from __future__ import annotations

import pytest
from shapely.geometry import Polygon

from rgcore.errors import EditError
from rgcore.model.checks import broken
from rgcore.model.draft import split_region
from rgcore.model.edits import (
    AddRegion,
    DeleteRegion,
    MergeRegions,
    ReshapeRegion,
    SplitRegion,
)
from rgcore.model.records import MapObject, Region, RGMap, replace

NEW, DOOR = "ru00000001", "gu00000001"
ACROSS = ((4.5, 0.4), (4.5, 1.6))


def area(region: Region) -> float:
    return Polygon(region.boundary, region.holes).area


def split(map: RGMap, region: str = "r1", cut: tuple = ACROSS, **more: object) -> RGMap:
    return SplitRegion(region=region, cut=cut, id=NEW, **more).apply(map)  # type: ignore[arg-type]


def test_a_cut_runs_on_to_the_outline_and_the_larger_part_stays(office: RGMap) -> None:
    after = split(office)
    kept, new = after.regions["r1"], after.regions[NEW]
    assert (area(kept), area(new)) == pytest.approx((9.0, 7.0))
    assert set(kept.boundary) == {(0.0, 0.0), (4.5, 0.0), (4.5, 2.0), (0.0, 2.0)}
    assert (new.name, new.class_, new.accuracy) == ("Hallway 2", "CDMA", None)
    assert kept.box.size == pytest.approx((4.0, 1.5), abs=0.01)
    assert kept.box.center == pytest.approx((2.25, 1.0), abs=0.01)


def test_doors_lines_and_objects_go_with_the_ground(office: RGMap) -> None:
    thing = MapObject(id="o2", center=(7.0, 1.0, 0.5), size=(0.4, 0.4, 1.0), region="r1")
    short = replace(office.lines["l1"], id="l13", start=(6.0, 0.0), end=(8.0, 0.0))
    map = replace(office, objects={**office.objects, "o2": thing}, lines={**office.lines, "l13": short})
    after = split(map)
    assert after.gateways["g1"].regions == ("r1", "r2")
    assert after.gateways["g2"].regions == (NEW, "r3")
    assert after.objects["o2"].region == NEW
    assert (after.lines["l13"].regions, after.lines["l1"].regions) == ((NEW,), ("r1",))
    assert after.objects["o1"] is map.objects["o1"]
    assert after.regions["r2"] is map.regions["r2"]


def test_the_two_halves_may_be_joined_by_a_gateway(office: RGMap) -> None:
    g = split(office, gateway=DOOR).gateways[DOOR]
    assert (g.class_, g.regions, g.posts) == ("opening", ("r1", NEW), ((4.5, 0.0), (4.5, 2.0)))
    assert g.crossing_points == ((4.5, 1.0),)
    assert g.gateway_points == ((4.0, 1.0), (5.0, 1.0))
    assert broken(split(office, gateway=DOOR)) == []


def test_a_cut_goes_on_behind_a_pillar_but_not_across_a_courtyard(office: RGMap) -> None:
    def with_hole(low: float, high: float) -> RGMap:
        hole = ((1.0, low), (1.0, high), (3.0, high), (3.0, low))
        return replace(office, regions={**office.regions, "r2": replace(office.regions["r2"], holes=(hole,))})

    down = ((2.0, 2.3), (2.0, 2.6))
    assert area(split(with_hole(3.0, 4.0), "r2", down).regions[NEW]) == pytest.approx(6.8)
    with pytest.raises(EditError, match="does not part r2 in two"):
        split(with_hole(3.0, 5.5), "r2", down)


def test_slivers_along_a_ragged_edge_are_no_parts(office: RGMap) -> None:
    """The cut runs along the side of a cabinet that the raster left ragged: a pocket of 0.03 m2 lies behind it."""
    hole = ((4.4, 0.8), (4.6, 0.9), (4.6, 1.1), (4.4, 1.2), (4.9, 1.2), (4.9, 0.8))
    ragged = replace(office, regions={**office.regions, "r1": replace(office.regions["r1"], holes=(hole,))})
    after = split(ragged)
    whole = area(ragged.regions["r1"])
    assert area(after.regions["r1"]) + area(after.regions[NEW]) == pytest.approx(whole)
    assert area(after.regions["r1"]) == pytest.approx(9.0, abs=0.1)
    assert broken(after) == []


@pytest.mark.parametrize(
    ("cut", "words"),
    [
        (((20.0, 0.0), (20.0, 1.0)), "the cut does not lie in r1"),
        (((1.0, 1.0), (1.0, 1.0)), "two points of the cut are the same"),
        (((0.02, 0.5), (0.02, 1.5)), "a part of r1 would be smaller than 0.1 m²"),
        (((1.0, 1.0), (2.0, 1.0), (2.0, 0.5), (1.5, 1.5)), "does not"),
    ],
)
def test_a_cut_that_makes_no_two_parts_is_refused(office: RGMap, cut: tuple, words: str) -> None:
    with pytest.raises(EditError, match=words):
        split(office, "r1", cut)


def test_a_drawn_cut_snaps_to_ends_of_walls(office: RGMap) -> None:
    edit = split_region(office, "r1", [(4.2, 1.95), (5.5, 0.5)], gateway=True)
    assert edit.cut[0] == (4.1, 2.1), "the end of l4"
    assert edit.cut[1] == (5.5, 0.5), "nothing near"
    assert edit.apply(office).gateways[edit.gateway or ""].regions == ("r1", edit.id)


def test_a_drawn_cut_along_a_wall_is_laid_onto_it_and_on_to_the_next(office: RGMap) -> None:
    """A stub of a wall at y = 4: a cut drawn 0.1 m off and short of the other side follows it."""
    stub = replace(office.lines["l5"], id="l20", start=(0.0, 4.0), end=(1.5, 4.0))
    map = replace(office, lines={**office.lines, "l20": stub})
    after = split_region(map, "r2", [(0.4, 4.1), (3.0, 4.05)]).apply(map)
    new = next(r for id, r in after.regions.items() if id not in map.regions)
    assert min(y for _, y in new.boundary) == pytest.approx(2.1)
    assert {p for p in new.boundary if p[1] > 3} == {(0.0, 4.0), (4.0, 4.0)}


def test_merging_takes_the_doors_between_and_keeps_the_others(office: RGMap) -> None:
    after = MergeRegions(regions=("r2", "r1")).apply(office)
    assert list(after.regions) == ["r2", "r3"]
    assert list(after.gateways) == ["g2"]
    assert after.gateways["g2"].regions == ("r2", "r3")
    assert area(after.regions["r2"]) == pytest.approx(16 + 15.6 + 0.1, abs=0.01), "both, and the doorway"
    assert after.lines["l2"].regions == ("r2",)
    assert (after.regions["r2"].name, after.regions["r2"].class_) == ("Room 1", "TOMA")


def test_what_was_split_can_be_merged(office: RGMap) -> None:
    after = MergeRegions(regions=("r1", NEW)).apply(split(office, gateway=DOOR))
    assert Polygon(after.regions["r1"].boundary).equals(Polygon(office.regions["r1"].boundary))
    assert after.gateways == office.gateways
    assert after.lines == office.lines


def test_merging_combines_the_accuracy_by_scans(office: RGMap) -> None:
    r1 = replace(office.regions["r1"], accuracy=0.1, scans=30)
    r2 = replace(office.regions["r2"], accuracy=0.3, scans=10)
    map = replace(office, regions={**office.regions, "r1": r1, "r2": r2})
    one = MergeRegions(regions=("r1", "r2")).apply(map).regions["r1"]
    assert (one.accuracy, one.scans) == (pytest.approx((0.03) ** 0.5, abs=1e-6), 40)


def test_regions_apart_are_not_merged(office: RGMap) -> None:
    far = AddRegion(id=NEW, boundary=((20.0, 0.0), (22.0, 0.0), (22.0, 2.0), (20.0, 2.0))).apply(office)
    with pytest.raises(EditError, match=f"r1 and {NEW} do not all lie side by side"):
        MergeRegions(regions=("r1", NEW)).apply(far)
    with pytest.raises(EditError, match="named twice"):
        MergeRegions(regions=("r1", "r1")).apply(office)


def test_what_a_region_gains_its_neighbour_loses(office: RGMap) -> None:
    """The hallway grows 1 m into r2, over g1: r2 shrinks, and so does its box."""
    boundary = ((0.0, 0.0), (8.0, 0.0), (8.0, 2.0), (4.0, 2.0), (4.0, 3.1), (0.0, 3.1), (0.0, 2.0))
    after = ReshapeRegion(region="r1", boundary=boundary).apply(office)
    assert area(after.regions["r2"]) == pytest.approx(4 * 2.9)
    assert after.regions["r2"].box.size == pytest.approx((3.5, 2.4), abs=0.01)
    assert after.lines["l3"].regions == ("r1",), "it stands in the hallway now"
    assert broken(after) == []


def test_a_region_is_not_covered_or_cut_to_pieces_by_another(office: RGMap) -> None:
    with pytest.raises(EditError, match="r1 would cover all of r2; merge them instead"):
        ReshapeRegion(region="r1", boundary=((0.0, 0.0), (8.0, 0.0), (8.0, 2.0), (4.05, 6.5), (0.0, 6.5))).apply(office)
    bar = ((-1.0, 3.0), (5.0, 3.0), (5.0, 4.0), (-1.0, 4.0))
    with pytest.raises(EditError, match=f"{NEW} would cut r2 into 2 pieces"):
        AddRegion(id=NEW, boundary=bar).apply(office)


@pytest.mark.parametrize(
    ("boundary", "holes", "words"),
    [
        (((0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)), (), r"the outline of r1 crosses itself at \(1.00, 1.00\)"),
        (
            ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0)),
            (((5.0, 5.0), (6.0, 5.0), (6.0, 6.0)),),
            "a hole outside of its outline",
        ),
        (((0.0, 0.0), (0.2, 0.0), (0.2, 0.2)), (), "r1 would be smaller than 0.1 m²"),
        (((0.0, 0.0), (1.0, 0.0)), (), "boundary must be 3 to 5000 corners"),
    ],
)
def test_an_outline_must_be_one(office: RGMap, boundary: tuple, holes: tuple, words: str) -> None:
    with pytest.raises(EditError, match=words):
        ReshapeRegion(region="r1", boundary=boundary, holes=holes).apply(office)


def test_rings_are_turned_as_the_document_has_them(office: RGMap) -> None:
    new = AddRegion(id=NEW, boundary=((10.0, 0.0), (10.0, 2.0), (12.0, 2.0), (12.0, 0.0))).apply(office).regions[NEW]
    assert Polygon(new.boundary).exterior.is_ccw
    assert new.name == "Region 1"


def test_a_new_region_gets_the_walls_that_had_none(office: RGMap) -> None:
    wall = replace(office.lines["l1"], id="l30", start=(10.0, 0.0), end=(12.0, 0.0), regions=())
    map = replace(office, lines={**office.lines, "l30": wall})
    ring = ((10.0, 0.0), (12.0, 0.0), (12.0, 2.0), (10.0, 2.0))
    assert AddRegion(id=NEW, boundary=ring).apply(map).lines["l30"].regions == (NEW,)


def test_a_region_goes_with_its_gateways(office: RGMap) -> None:
    after = DeleteRegion(region="r3").apply(office)
    assert list(after.gateways) == ["g1"]
    assert after.lines["l12"].regions == ()
    assert after.objects["o1"].region is None
    crossing = replace(
        office.gateways["g2"],
        id="g3",
        class_="junction_T",
        regions=("r1", "r2", "r3"),
        gateway_points=((6.0, 1.5), (3.0, 2.5), (6.0, 2.6)),
    )
    after = DeleteRegion(region="r3").apply(replace(office, gateways={**office.gateways, "g3": crossing}))
    assert (after.gateways["g3"].regions, len(after.gateways["g3"].gateway_points)) == (("r1", "r2"), 2)


def test_a_cut_whose_ends_are_caught_by_one_corner_is_kept_as_drawn(office: RGMap) -> None:
    path = [(3.8, 2.3), (3.9, 2.2)]
    assert split_region(office, "r2", path).cut == tuple(path)
