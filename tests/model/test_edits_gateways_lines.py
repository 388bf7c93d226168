"""Edits of gateways and lines: what follows from where they are drawn, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rgcore.errors import EditError
from rgcore.model import draft
from rgcore.model.edits import (
    AddGateway,
    AlignLines,
    AssignGateway,
    DeleteLines,
    DrawLine,
    JoinLines,
    MoveGatewayPoints,
    SplitLine,
)
from rgcore.model.records import Line, RGMap, replace

NEW = "gu00000001"


def test_the_points_of_a_new_gateway_follow_from_its_posts(office: RGMap) -> None:
    for posts in (((4.05, 4.0), (4.05, 5.0)), ((4.05, 5.0), (4.05, 4.0))):
        g = AddGateway(id=NEW, posts=posts, regions=("r3", "r2")).apply(office).gateways[NEW]
        assert g.crossing_points == ((4.05, 4.5),)
        assert g.gateway_points == ((4.55, 4.5), (3.55, 4.5)), "one in each region, in their order"
        assert sorted(math.cos(a) for a in g.traversal_directions) == pytest.approx([-1.0, 1.0])
        assert (g.confidence, g.passed) == (1.0, False)


def test_a_drawn_gateway_finds_its_regions_and_snaps_to_jambs(office: RGMap) -> None:
    edit = draft.add_gateway(office, ((4.1, 3.0), (4.0, 2.2)))
    assert edit.posts == ((4.1, 3.0), (4.0, 2.1)), "the end of l3 and l5"
    assert (edit.regions, edit.class_) == (("r3", "r2"), "narrow_passage")
    assert draft.add_gateway(office, ((4.05, 3.0), (4.05, 5.0))).class_ == "opening"
    with pytest.raises(EditError, match="1 of 2 regions beside these posts"):
        draft.add_gateway(office, ((1.0, 0.0), (2.0, 0.0)))


def test_a_junction_joins_three(office: RGMap) -> None:
    edit = AddGateway(id=NEW, posts=((3.6, 2.0), (4.6, 2.0)), regions=("r1", "r2", "r3"), class_="junction_T")
    g = edit.apply(office).gateways[NEW]
    assert len(g.gateway_points) == 3
    assert np.allclose(g.gateway_points[1], (3.75, 2.35), atol=0.01), "where a robot has room, nearest to the posts"


@pytest.mark.parametrize(
    ("regions", "class_", "words"),
    [
        (("r1",), "opening", r"the new gateway \(opening\) must join 2 regions, not 1"),
        (("r1", "r1"), "opening", "join a region with itself"),
        (("r1", "r3"), "opening", "r3 is 2.1 m away from there"),
        (("r1", "r9"), "opening", "there is no region r9"),
        ((), "junction_T", "must join 2 regions, not 0"),
    ],
)
def test_a_gateway_that_joins_nothing_is_refused(office: RGMap, regions: tuple, class_: str, words: str) -> None:
    with pytest.raises(EditError, match=words):
        AddGateway(id=NEW, posts=((1.5, 2.05), (2.5, 2.05)), regions=regions, class_=class_).apply(office)


def test_a_gateway_may_join_other_regions(office: RGMap) -> None:
    old = office.gateways["g1"]
    g = AssignGateway(gateway="g1", regions=("r2", "r1")).apply(office).gateways["g1"]
    assert g.gateway_points == old.gateway_points[::-1]
    wide = replace(office.regions["r3"], boundary=((1.0, 2.1), (8.0, 2.1), (8.0, 6.0), (1.0, 6.0)))
    map = replace(office, regions={**office.regions, "r3": wide})
    g = AssignGateway(gateway="g1", regions=("r1", "r3")).apply(map).gateways["g1"]
    assert g.gateway_points == (old.gateway_points[0], (2.0, 2.55))


def test_points_move_and_posts_stay(office: RGMap) -> None:
    edit = MoveGatewayPoints(gateway="g1", gateway_points=((2.2, 1.4), (2.2, 2.7)))
    g = edit.apply(office).gateways["g1"]
    assert (g.posts, g.gateway_points) == (office.gateways["g1"].posts, ((2.2, 1.4), (2.2, 2.7)))
    with pytest.raises(EditError, match="g1 needs 2 gateway-points, one a region, not 1"):
        MoveGatewayPoints(gateway="g1", gateway_points=((2.2, 1.4),)).apply(office)


def test_a_drawn_wall_bounds_the_region_on_its_free_side(office: RGMap) -> None:
    left = DrawLine(id="lu00000001", start=(4.1, 6.0), end=(4.1, 2.1)).apply(office)
    assert left.lines["lu00000001"].regions == ("r3",)
    outside = DrawLine(id="lu00000001", start=(4.0, 6.3), end=(0.0, 6.3)).apply(office)
    assert outside.lines["lu00000001"].regions == ("r2",), "0.15 m from its outline"
    nowhere = DrawLine(id="lu00000001", start=(0.0, 9.0), end=(4.0, 9.0)).apply(office)
    assert nowhere.lines["lu00000001"].regions == ()


def test_a_hand_may_draw_a_wall_either_way(office: RGMap) -> None:
    for a, b in (((8.0, 6.0), (8.0, 2.1)), ((8.0, 2.1), (8.0, 6.0))):
        edit = draft.draw_wall(office, a, b)
        assert (edit.start, edit.end) == ((8.0, 2.1), (8.0, 6.0)), "free space left"
    edit = draft.draw_wall(office, (4.05, 3.0), (4.05, 5.0), free=(3.0, 4.0))
    assert edit.apply(office).lines[edit.id].regions == ("r2",)


def pieces(*ends: tuple, **more: object) -> RGMap:
    lines = [Line(id=f"l{i}", start=a, end=b, support=10, residual=0.01, **more) for i, (a, b) in enumerate(ends, 1)]  # type: ignore[arg-type]
    return RGMap(lines={v.id: v for v in lines})


def test_pieces_of_a_wall_are_joined() -> None:
    map = pieces(((0.0, 0.0), (1.0, 0.02)), ((1.2, -0.02), (3.0, 0.0)), ((3.5, 0.01), (5.0, 0.0)))
    after = JoinLines(lines=("l1", "l3", "l2")).apply(map)
    (one,) = after.lines.values()
    assert np.allclose([one.start, one.end], [(0.0, 0.0), (5.0, 0.0)], atol=0.02)
    assert (one.id, one.support, one.residual) == ("l1", 30, 0.01)


def test_lines_of_different_walls_are_not_joined() -> None:
    with pytest.raises(EditError, match="l2 looks the other way"):
        JoinLines(lines=("l1", "l2")).apply(pieces(((0.0, 0.0), (1.0, 0.0)), ((3.0, 0.0), (2.0, 0.0))))
    with pytest.raises(EditError, match=r"l\d lies 0\.\d+ m beside the others"):
        JoinLines(lines=("l1", "l2")).apply(pieces(((0.0, 0.0), (1.0, 0.0)), ((0.0, 0.5), (1.0, 0.5))))
    with pytest.raises(EditError, match="two lines or more"):
        JoinLines(lines=("l1",)).apply(pieces(((0.0, 0.0), (1.0, 0.0))))


def test_objects_keep_their_walls_when_these_are_joined_split_and_deleted(office: RGMap) -> None:
    seed = draft.object_from_lines(office, ["l6", "l7", "l8"])
    map = seed.apply(office)
    halved = SplitLine(line="l6", at=(1.5, 5.5), id="lu00000001").apply(map)
    assert halved.objects[seed.id].lines == ("l6", "lu00000001", "l7", "l8")
    assert (halved.lines["l6"].start, halved.lines["lu00000001"].end) == ((1.5, 5.6), (1.5, 5.6)), "the longer keeps it"
    joined = JoinLines(lines=("l6", "lu00000001")).apply(halved)
    assert joined.objects[seed.id].lines == ("l6", "l7", "l8")
    assert joined.lines["l6"] == replace(map.lines["l6"], support=joined.lines["l6"].support)
    assert DeleteLines(lines=("l6", "l8")).apply(map).objects[seed.id].lines == ("l7",)
    with pytest.raises(EditError, match="l6 cannot be split there"):
        SplitLine(line="l6", at=(0.0, 5.6), id="lu00000001").apply(map)


def test_lines_are_laid_along_the_main_axes(office: RGMap) -> None:
    skew = replace(office.lines["l1"], start=(0.0, -0.1), end=(8.0, 0.1))
    upright = replace(office.lines["l5"], start=(4.05, 2.1), end=(3.95, 6.1), regions=("r1",))
    map = replace(office, lines={**office.lines, "l1": skew, "l5": upright})
    after = draft.align_lines(map, ["l1", "l5"]).apply(map)
    assert np.allclose([after.lines["l1"].start, after.lines["l1"].end], [(0.0, 0.0), (8.0, 0.0)], atol=0.01)
    assert np.allclose([after.lines["l5"].start, after.lines["l5"].end], [(4.0, 2.1), (4.0, 6.1)], atol=0.01)
    with pytest.raises(EditError, match="l1 stands 45° off that direction"):
        AlignLines(lines=("l1",), direction=math.pi / 4).apply(office)


def test_a_rectangle_makes_an_object_of_what_stands_in_it(office: RGMap) -> None:
    seed = draft.object_in_rectangle(office, (2.5, 6.2), (0.5, 5.4), height=0.8, label="cabinet")
    assert type(seed).__name__ == "SeedObject"
    assert (seed.size, seed.label, seed.region) == ((1.2, 0.4, 0.8), "cabinet", "r2")
    empty = draft.object_in_rectangle(office, (5.0, 3.0), (5.6, 4.2))
    assert type(empty).__name__ == "AddObject"
    assert (empty.center, sorted(empty.size), empty.region) == ((5.3, 3.6, 0.5), [0.6, 1.0, 1.2], "r3")
