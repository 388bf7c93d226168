"""Tools without a browser: clicks, moves and keys in metres become the edits that are meant."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pytest
from office_map import office_map

from rgcore.errors import EditError
from rgcore.model.checks import broken
from rgcore.model.edits import (
    AddGateway,
    AddNote,
    AddRegion,
    AssignGateway,
    AssignLines,
    DeleteRegion,
    DrawLine,
    Edit,
    MoveGateway,
    MoveGatewayPoints,
    MoveLine,
    MoveNote,
    ReshapeRegion,
    SeedObject,
    SplitLine,
    SplitRegion,
)
from rgcore.model.ground import shape_of
from rgcore.model.records import RGMap
from rgviz.picking import Item
from rgviz.tools.adjusting import Adjust, Drag, handles
from rgviz.tools.drawing import GatewayTool, RegionTool, SplitTool, WallTool
from rgviz.tools.pointing import AssignTool, BoxTool, CutLineTool, NoteTool, SelectTool
from rgviz.tools.reshaping import ReshapeTool
from rgviz.tools.tool import Hand, Tool, Turn, straightened

MAP = office_map(4, 1, 2)
# r4 is the room x 4..7.8, y 0..5; its door g3 stands at x 5.5..6.4, y 5, to the hall r2 above


def hand(x: float, y: float, **how: object) -> Hand:
    return Hand((x, y), 0.02, **how)  # type: ignore[arg-type]


def drag(tool: Tool, way: Iterable[tuple[float, float]], map_: RGMap = MAP, **how: object) -> Turn:
    """Press at the first place, move over all, let go at the last."""
    places = list(way)
    turn = tool.press(map_, hand(*places[0], **how))
    for p in places[1:]:
        assert turn.tool is not None
        turn = turn.tool.move(map_, hand(*p, **how))
        assert turn.tool is not None
        turn.tool.sketch(map_)
    assert turn.tool is not None
    return turn.tool.release(map_, hand(*places[-1], **how))


def clicks(tool: Tool, places: Iterable[tuple[float, float]], map_: RGMap = MAP) -> Turn:
    """Press and let go at each place, until an edit comes of it."""
    turn = Turn(tool)
    for p in places:
        assert turn.tool is not None
        turn = turn.tool.move(map_, hand(*p)).tool.press(map_, hand(*p))  # type: ignore[union-attr]
        if turn.edit is not None or turn.tool is None:
            return turn
        turn = turn.tool.release(map_, hand(*p))
        if turn.edit is not None:
            return turn
    return turn


def made(edit: Edit | None, kind: type[Edit], map_: RGMap = MAP) -> RGMap:
    """The sound map that an edit of this kind makes."""
    assert isinstance(edit, kind)
    after = edit.apply(map_)
    assert broken(after) == []
    return after


def test_a_dragged_line_parts_a_room_and_shows_both_halves_before() -> None:
    tool: Tool | None = SplitTool().press(MAP, hand(5.9, 0.6)).tool
    tool = tool.move(MAP, hand(5.9, 4.4)).tool  # type: ignore[union-attr]
    sketch = tool.sketch(MAP)  # type: ignore[union-attr]
    areas = [s for s in sketch.strokes if s.fill]
    assert [s.ink for s in areas] == ["good", "other"]
    turn = tool.release(MAP, hand(5.9, 4.4))  # type: ignore[union-attr]
    after = made(turn.edit, SplitRegion)
    new = turn.edit.id  # type: ignore[union-attr]
    assert turn.select == (Item("region", new),)
    shown = [float(word) for word in sketch.note.replace("m²", "").split(" and ")]
    assert np.allclose(sorted(shown), sorted(shape_of(after.regions[r]).area for r in ("r4", new)), atol=0.06)
    assert turn.tool == SplitTool()


def test_a_cut_of_several_clicks_ends_with_a_double_click() -> None:
    turn = clicks(SplitTool(region="r4"), [(4.2, 2.0), (6.0, 2.0), (6.0, 3.2), (7.6, 3.2), (7.6, 3.2)])
    after = made(turn.edit, SplitRegion)
    assert len(turn.edit.cut) == 4  # type: ignore[union-attr]
    assert len(after.regions) == len(MAP.regions) + 1


def test_a_split_can_leave_a_gateway_and_tells_what_is_wrong() -> None:
    turn = drag(SplitTool(gateway=True), [(5.9, 0.6), (5.9, 3.0), (5.9, 4.4)])
    after = made(turn.edit, SplitRegion)
    assert len(after.gateways) == len(MAP.gateways) + 1
    assert isinstance(turn.tool, SplitTool)
    assert turn.tool.gateway
    outside = SplitTool(points=((20.0, 20.0),), tip=(22.0, 20.0))
    assert outside.sketch(MAP).refused
    assert outside.sketch(MAP).note == "there is no region under that line"
    with pytest.raises(EditError):
        outside.finish(MAP)


def test_esc_takes_the_drawing_then_the_tool_and_backspace_a_point() -> None:
    tool = RegionTool(points=((0.0, 0.0), (1.0, 0.0)))
    assert tool.back(MAP).tool.points == ((0.0, 0.0),)  # type: ignore[union-attr]
    assert tool.cancel() == RegionTool()
    assert RegionTool().cancel() is None
    with pytest.raises(EditError, match="3 points"):
        tool.finish(MAP)


def test_a_wall_snaps_to_ends_of_walls_and_shift_holds_it_straight() -> None:
    turn = drag(WallTool(), [(4.05, 3.0), (6.0, 3.1), (7.75, 4.95)])
    wall = turn.edit
    made(wall, DrawLine)
    assert {wall.start, wall.end} & {(7.8, 5.0)}, "it caught the corner"  # type: ignore[union-attr]
    straight = drag(WallTool(), [(5.0, 2.0), (5.5, 2.1), (6.9, 2.3)], straight=True).edit
    assert straight.start[1] == straight.end[1] == 2.0  # type: ignore[union-attr]
    free = drag(WallTool(), [(4.05, 2.98), (7.75, 4.95)], free=True).edit
    assert {free.start, free.end} == {(4.05, 2.98), (7.75, 4.95)}  # type: ignore[union-attr]
    assert clicks(WallTool(), [(5.0, 2.0), (6.0, 2.0)]).edit is not None, "two clicks do as well"


def test_a_gateway_stands_between_the_regions_beside_its_posts() -> None:
    turn = clicks(GatewayTool(), [(4.2, 5.0), (5.1, 5.0)])
    after = made(turn.edit, AddGateway)
    assert set(turn.edit.regions) == {"r2", "r4"}  # type: ignore[union-attr]
    assert turn.select[0].id in after.gateways  # type: ignore[index]
    nowhere = GatewayTool(points=((20.0, 20.0),), tip=(21.0, 20.0)).sketch(MAP)
    assert nowhere.refused
    assert "0 of 2 regions" in nowhere.note


def test_a_region_is_closed_on_its_first_corner() -> None:
    ring = [(17.0, 1.0), (20.0, 1.0), (20.0, 4.0), (17.0, 4.0)]
    turn = clicks(RegionTool(), [*ring, ring[0]])
    after = made(turn.edit, AddRegion)
    assert shape_of(after.regions[turn.edit.id]).area == pytest.approx(9.0)  # type: ignore[union-attr]
    crossed = RegionTool(points=((0.0, 20.0), (2.0, 20.0), (0.0, 22.0)), tip=(2.0, 22.0))
    assert crossed.sketch(MAP).refused


def test_posts_and_points_of_a_gateway_are_dragged() -> None:
    item = Item("gateway", "g3")
    names = {h.id: (h.x, h.y) for h in handles(MAP, item)}
    assert set(names) == {"p0", "p1", "c0", "e0", "e1"}
    x, y = names["p1"]
    turn = drag(Adjust((item,)), [(x, y), (x + 0.1, y), (x + 0.3, y)], handle="p1")
    after = made(turn.edit, MoveGateway)
    assert after.gateways["g3"].width == pytest.approx(MAP.gateways["g3"].width + 0.3)
    x, y = names["e0"]
    turn = drag(Adjust((item,)), [(x, y), (x, y - 0.2)], handle="e0")
    after = made(turn.edit, MoveGatewayPoints)
    assert after.gateways["g3"].gateway_points == ((x, y - 0.2), MAP.gateways["g3"].gateway_points[1])
    assert after.gateways["g3"].posts == MAP.gateways["g3"].posts
    assert drag(Adjust((item,)), [names["c0"], names["c0"]], handle="c0").edit is None, "a click moves nothing"
    assert drag(Adjust((item,)), [(0.0, 0.0), (1.0, 1.0)], handle="c7").edit is None, "nor does a handle made up"


def test_a_line_is_moved_by_its_ends_and_pushed_aside_by_its_middle() -> None:
    line = next(v for v in MAP.lines.values() if v.regions == ("r4",) and v.start == (4.0, 5.0) and v.end == (4.0, 0.0))
    item = Item("line", line.id)
    turn = drag(Adjust((item,)), [line.end, (4.0, 0.5), (4.0, 1.0)], handle="end")
    assert made(turn.edit, MoveLine).lines[line.id].end == (4.0, 1.0)
    turn = drag(Adjust((item,)), [(4.0, 2.5), (4.2, 2.9)], handle="whole")
    moved = made(turn.edit, MoveLine).lines[line.id]
    assert np.allclose((moved.start, moved.end), ((4.2, 5.0), (4.2, 0.0)))


def test_a_note_is_written_where_one_clicks_and_moved() -> None:
    question = NoteTool().press(MAP, hand(5.0, 2.0)).ask
    assert question is not None
    noted = made(question.then(MAP, "broken glass"), AddNote)
    note = next(iter(noted.notes))
    turn = drag(Adjust((Item("note", note),)), [(5.0, 2.0), (6.0, 3.0)], noted, handle="place")
    assert made(turn.edit, MoveNote, noted).notes[note].place == (6.0, 3.0)


def test_corners_and_sides_of_a_region() -> None:
    tool = ReshapeTool("r4")
    ids = {h.id for h in tool.sketch(MAP).handles}
    assert ids == {f"{k}0.{n}" for k in "cs" for n in range(4)}
    turn = drag(tool, [(7.8, 0.0), (7.5, 0.2), (7.3, 0.4)], handle="c0.1")
    assert (7.3, 0.4) in made(turn.edit, ReshapeRegion).regions["r4"].boundary
    turn = drag(tool, [(5.9, 0.0), (6.1, 0.5), (5.9, 1.0)], handle="s0.0")
    pushed = made(turn.edit, ReshapeRegion).regions["r4"]
    assert shape_of(pushed).area == pytest.approx(3.8 * 4.0, abs=0.05)
    assert isinstance(turn.tool, ReshapeTool), "it goes on"
    more = tool.press(MAP, hand(5.9, 0.0, free=True)).edit
    five = made(more, ReshapeRegion)
    assert len(more.boundary) == 5  # type: ignore[union-attr]
    fewer = tool.press(MAP, hand(7.8, 0.0, free=True)).edit
    assert len(made(fewer, ReshapeRegion).regions["r4"].boundary) == 3
    assert five.regions["r4"].id == "r4"
    with pytest.raises(EditError):
        tool.press(MAP, hand(6.0, 2.5, free=True))
    chosen = tool.press(MAP, hand(7.8, 0.0, handle="c0.1")).tool.release(MAP, hand(7.8, 0.0)).tool  # type: ignore[union-attr]
    assert len(chosen.back(MAP).edit.boundary) == 3  # type: ignore[union-attr]


def test_corners_of_an_outline_show_by_how_much_they_matter() -> None:
    jog = ((4.0, 0.0), (6.0, 0.0), (6.0, 0.1), (6.1, 0.1), (7.8, 0.1), (7.8, 5.0), (5.9, 5.0), (4.0, 5.0))
    wavy = ReshapeRegion(region="r4", boundary=jog).apply(MAP)
    rooms = {h.id: h.room for h in ReshapeTool("r4").sketch(wavy).handles if h.shape == "corner"}
    at = {p: rooms[f"c0.{n}"] for n, p in enumerate(wavy.regions["r4"].boundary)}
    always = {p for p, room in at.items() if room == 0}
    assert {(7.8, 5.0), (4.0, 5.0)} <= always
    assert len(always) == 4
    assert all(0 < at[p] < 1.0 for p in ((6.0, 0.0), (6.0, 0.1)) if p not in always)
    assert at[(5.9, 5.0)] < 0.01, "a corner on a straight wall shows last"


def test_an_outline_that_crosses_itself_is_shown_as_refused() -> None:
    tool = ReshapeTool("r4").press(MAP, hand(7.8, 0.0, handle="c0.1")).tool
    sketch = tool.move(MAP, hand(3.0, 4.0)).tool.sketch(MAP)  # type: ignore[union-attr]
    assert sketch.refused
    with pytest.raises(EditError):
        tool.move(MAP, hand(3.0, 4.0)).tool.release(MAP, hand(3.0, 4.0)).edit.apply(MAP)  # type: ignore[union-attr]


def test_a_rectangle_selects_adds_and_takes_away() -> None:
    around = [(5.3, 0.2), (6.0, 0.7), (6.7, 1.1)]  # the second cabinet of r4
    turn = drag(SelectTool(), around)
    assert turn.select is not None
    assert len(turn.select) == 4
    assert {i.kind for i in turn.select} == {"line"}
    assert turn.tool is not None
    more = drag(turn.tool, [(4.1, 0.2), (5.0, 0.7), (5.3, 1.1)], straight=True)
    assert len(more.select or ()) == 8
    less = drag(more.tool, around, free=True)  # type: ignore[arg-type]
    assert len(less.select or ()) == 4
    rooms = drag(SelectTool(items=(Item("region", "r4"),)), [(-0.5, -0.5), (3.0, 3.0), (8.1, 5.5)], straight=True)
    assert {i.id for i in rooms.select or ()} == {"r3", "r4"}
    assert drag(SelectTool(), [(1.0, 1.0), (1.01, 1.01)]).select is None, "a click is no rectangle"


def test_a_box_over_what_a_rectangle_holds() -> None:
    turn = drag(BoxTool(height=1.8), [(5.3, 0.2), (6.0, 0.7), (6.7, 1.1)])
    box = made(turn.edit, SeedObject).objects[turn.edit.id]  # type: ignore[union-attr]
    assert np.allclose(box.center, (5.95, 0.65, 0.9), atol=1e-3)
    assert sorted(np.round(box.size, 3)) == [0.5, 0.9, 1.8]


def test_a_line_is_cut_where_one_clicks() -> None:
    tool = CutLineTool().move(MAP, hand(4.05, 3.0)).tool
    assert "m" in tool.sketch(MAP).note  # type: ignore[union-attr]
    turn = tool.press(MAP, hand(4.05, 3.0))  # type: ignore[union-attr]
    after = made(turn.edit, SplitLine)
    lengths = [math.dist(after.lines[i.id].start, after.lines[i.id].end) for i in turn.select or ()]
    assert sorted(np.round(lengths, 2)) == [2.0, 3.0]
    with pytest.raises(EditError):
        CutLineTool().press(MAP, hand(6.0, 2.5))


def test_regions_are_assigned_by_clicks() -> None:
    turn = clicks(AssignTool.for_(MAP, (Item("gateway", "g3"),)), [(8.0, 6.0), (5.5, 2.5)])
    assert isinstance(turn.edit, AssignGateway)
    assert turn.edit.regions == ("r2", "r4")
    line = next(i for i, v in MAP.lines.items() if v.regions == ("r2",))
    turn = clicks(AssignTool.for_(MAP, (Item("line", line),)), [(5.5, 2.5)])
    assert made(turn.edit, AssignLines).lines[line].regions[0] == "r4"
    junction = AssignTool.for_(MAP, (Item("gateway", "g1"),))
    open_ = clicks(junction, [(8.0, 6.0), (-1.5, 3.0)]).tool
    assert open_ is not None
    assert isinstance(open_.finish(MAP).edit, AssignGateway), "a junction takes more; Enter ends"
    with pytest.raises(EditError):
        AssignTool.for_(MAP, (Item("region", "r4"),))


def test_tools_let_go_of_what_another_person_deletes() -> None:
    gone = DeleteRegion(region="r4").apply(MAP)
    assert SplitTool(region="r4").kept(gone) is None
    assert SplitTool(region="r5").kept(gone) is not None
    assert ReshapeTool("r4").kept(gone) is None
    assert AssignTool((Item("gateway", "g3"),)).kept(gone) is None
    assert Drag(Item("gateway", "g3"), "p0", (0.0, 0.0), (0.0, 0.0)).kept(gone) is None
    assert Adjust((Item("gateway", "g3"),)).sketch(gone).handles == ()


def test_straight_means_along_an_axis() -> None:
    assert straightened((0.0, 0.0), (1.0, 0.2), ()) == (1.0, 0.0)
    x, y = straightened((0.0, 0.0), (1.0, 0.9), (math.pi / 4,))
    assert x == pytest.approx(y)
