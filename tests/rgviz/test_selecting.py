"""Selections grow and shrink as a person expects, and a box follows the hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from office_map import office_map

from rgcore.errors import EditError
from rgcore.model.edits import AddNote, MoveObject
from rgcore.model.find import find
from rgviz import gizmo, selecting
from rgviz.picking import Item

MAP = office_map(4, 1, 2)
BOX = MAP.objects["o2"]
A, B, R = Item("line", "l1"), Item("line", "l2"), Item("region", "r1")


def test_toggling_adding_and_taking_away() -> None:
    assert selecting.toggled((), A) == (A,)
    assert selecting.toggled((A,), B) == (A, B)
    assert selecting.toggled((A, B), A) == (B,)
    assert selecting.toggled((R,), A) == (A,)
    assert selecting.added((), (A, B, R)) == (A, B)
    assert selecting.added((R,), (A, B)) == (R,)
    assert selecting.added((B,), (A, B, R)) == (B, A)
    assert selecting.without((A, B), (A, R)) == (B,)


def test_by_search_by_region_and_inverted() -> None:
    offices = selecting.of_ids(MAP, find(MAP, "class:TOMA"))
    assert {i.kind for i in offices} == {"region"}
    assert {MAP.regions[i.id].class_ for i in offices} == {"TOMA"}
    assert selecting.of_ids(MAP, ["gone", "r1"]) == (R,)
    lines = selecting.lines_of(MAP, (Item("region", "r4"),))
    assert {MAP.lines[i.id].regions[0] for i in lines} == {"r4"}
    assert selecting.lines_of(MAP, lines[:1]) == lines
    assert len(selecting.others(MAP, offices)) == len(MAP.regions) - len(offices)
    assert len(selecting.others(MAP, ())) == len(MAP.lines)


def test_extent_of_a_selection() -> None:
    box = selecting.extent_of(MAP, (Item("region", "r4"),))
    assert box is not None
    assert (box[0] < (4.0, 0.0)).all()
    assert (box[1] > (7.8, 5.0)).all()
    noted = AddNote(id="nu00000001", text="?", place=(1.0, 2.0)).apply(MAP)
    for item in (A, Item("gateway", "g1"), Item("object", "o1"), Item("note", "nu00000001")):
        assert selecting.extent_of(noted, (item,)) is not None
    assert selecting.extent_of(MAP, (Item("region", "gone"),)) is None


@given(st.floats(-20, 20), st.floats(-20, 20), st.floats(-3.1, 3.1))
def test_a_drag_moves_on_the_floor_and_turns_about_the_vertical(x: float, y: float, yaw: float) -> None:
    moved = gizmo.dragged(BOX, (x, y, 7.0), gizmo.quaternion(yaw))
    assert np.allclose(moved.center, (x, y, BOX.center[2]), atol=1e-4)
    assert abs(math.remainder(moved.yaw - yaw, 2 * math.pi)) < 1e-4
    assert moved.size == BOX.size
    edit = gizmo.move(moved)
    assert isinstance(edit, MoveObject)
    assert edit.apply(MAP).objects["o2"].center == moved.center


def test_a_browser_cannot_drag_a_box_to_nowhere() -> None:
    for position, wxyz in (
        ((math.nan, 0, 0), (1, 0, 0, 0)),
        ((0, math.inf, 0), (1, 0, 0, 0)),
        ((0, 0, 0), (0, 0, 0, 0)),
    ):
        with pytest.raises(EditError):
            gizmo.dragged(BOX, position, wxyz)


def test_sizes_change_about_the_floor() -> None:
    high = gizmo.resized(BOX, "height", 2.0)
    assert high.size == (*BOX.size[:2], 2.0)
    assert high.center[2] == 1.0
    assert gizmo.resized(BOX, "length", 1.2).center == BOX.center
    assert gizmo.resized(BOX, "turn", 90.0).yaw == pytest.approx(math.pi / 2, abs=1e-4)
    assert -math.pi <= gizmo.resized(BOX, "turn", 725.0).yaw <= math.pi
    for field, value in (("height", 0.0), ("width", -1.0), ("length", math.nan), ("turn", math.inf)):
        with pytest.raises(EditError):
            gizmo.resized(BOX, field, value)
