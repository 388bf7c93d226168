"""What a hand does becomes the right edit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from office_map import office_map

from rgcore.errors import EditError
from rgcore.model.edits import ClassifyGateway, ClassifyRegion, DeleteObject, LabelObject, MoveObject, RenameRegion
from rgviz import tools
from rgviz.commands import BY_NAME, COMMANDS, split_key, spoken
from rgviz.picking import Item

MAP = office_map(4, 1, 2)
BOX = MAP.objects["o2"]


def test_edits_of_each_kind() -> None:
    assert tools.classify(Item("region", "r4"), "  my   kitchen ") == ClassifyRegion(region="r4", class_="my kitchen")
    assert tools.classify(Item("gateway", "g1"), "opening") == ClassifyGateway(gateway="g1", class_="opening")
    assert tools.rename(Item("region", "r4"), " Lab 2 ") == RenameRegion(region="r4", name="Lab 2")
    assert tools.rename(Item("object", "o1"), "printer") == LabelObject(object="o1", label="printer")
    assert tools.delete(Item("object", "o1")) == DeleteObject(object="o1")
    for refused in (
        lambda: tools.classify(Item("line", "l1"), "x"),
        lambda: tools.rename(Item("line", "l1"), "x"),
        lambda: tools.delete(Item("region", "r1")),
    ):
        with pytest.raises(EditError):
            refused()


@given(st.floats(-20, 20), st.floats(-20, 20), st.floats(-3.1, 3.1))
def test_a_drag_moves_on_the_floor_and_turns_about_the_vertical(x: float, y: float, yaw: float) -> None:
    moved = tools.dragged(BOX, (x, y, 7.0), tools.quaternion(yaw))
    assert np.allclose(moved.center, (x, y, BOX.center[2]), atol=1e-4)
    assert abs(math.remainder(moved.yaw - yaw, 2 * math.pi)) < 1e-4
    assert moved.size == BOX.size
    edit = tools.move(moved)
    assert isinstance(edit, MoveObject)
    assert edit.apply(MAP).objects["o2"].center == moved.center


def test_sizes_change_about_the_floor() -> None:
    high = tools.resized(BOX, "height", 2.0)
    assert high.size == (*BOX.size[:2], 2.0)
    assert high.center[2] == 1.0
    assert tools.resized(BOX, "length", 1.2).center == BOX.center
    assert tools.resized(BOX, "turn", 90.0).yaw == pytest.approx(math.pi / 2, abs=1e-4)
    assert -math.pi <= tools.resized(BOX, "turn", 725.0).yaw <= math.pi
    for field, value in (("height", 0.0), ("width", -1.0), ("length", math.nan), ("turn", math.inf)):
        with pytest.raises(EditError):
            tools.resized(BOX, field, value)


def test_adding_to_a_selection() -> None:
    a, b, r = Item("line", "l1"), Item("line", "l2"), Item("region", "r1")
    assert tools.added((), a) == (a,)
    assert tools.added((a,), b) == (a, b)
    assert tools.added((a, b), a) == (b,)
    assert tools.added((r,), a) == (a,)


def test_extent_of_a_selection() -> None:
    box = tools.extent_of(MAP, (Item("region", "r4"),))
    assert box is not None
    assert (box[0] < (4.0, 0.0)).all()
    assert (box[1] > (7.8, 5.0)).all()
    for item in (Item("line", "l1"), Item("gateway", "g1"), Item("object", "o1")):
        assert tools.extent_of(MAP, (item,)) is not None
    assert tools.extent_of(MAP, (Item("region", "gone"),)) is None


def test_no_two_commands_share_a_key_and_none_flies_the_camera() -> None:
    keys = [k for c in COMMANDS for k in c.keys]
    assert len(keys) == len(set(keys))
    assert len(BY_NAME) == len(COMMANDS)
    flying = {"W", "A", "S", "D", "Q", "E", "arrowup", "arrowdown", "arrowleft", "arrowright"}
    assert not [k for k in keys if split_key(k)[0] in flying]
    assert split_key("cmd/ctrl+shift+Z") == ("Z", "cmd/ctrl+shift")
    assert spoken("cmd/ctrl+shift+Z") == "Ctrl+Shift+Z"
