"""The tool that brings a floor plan to its place, fed with the hand's doings."""

from __future__ import annotations

import numpy as np
import pytest
from office_map import office_map

from rgcore.errors import EditError
from rgcore.model.backdrops import corners, placed
from rgcore.model.edits import DeleteBackdrop
from rgcore.model.records import Backdrop, RGMap, replace
from rgviz.tools.aligning import AlignTool
from rgviz.tools.tool import Hand

PLAN = Backdrop(id="bu1", name="a.png", sha256="0" * 64, form="png", size=(200, 100), center=(5, 5), length=10)
MAP: RGMap = replace(office_map(4, 1, 2), backdrops={PLAN.id: PLAN})


def fed(*points: tuple[float, float], free: bool = True) -> AlignTool:
    tool = AlignTool(PLAN.id)
    for at in points:
        turn = tool.press(MAP, Hand(at, free=free))
        assert isinstance(turn.tool, AlignTool)
        tool = turn.tool
    return tool


def test_two_pairs_make_one_edit_and_the_sheet_is_shown_before() -> None:
    tool = fed((0, 2.5), (1, 1), (10, 2.5))  # its lower corners
    shown = tool.move(MAP, Hand((1, 6), free=True)).tool.sketch(MAP)  # type: ignore[union-attr]
    assert [s.ink for s in shown.strokes] == ["good", "good", "other"]
    turn = tool.press(MAP, Hand((1, 6), free=True))
    assert turn.tool is None
    after = turn.edit.apply(MAP).backdrops[PLAN.id]  # type: ignore[union-attr]
    np.testing.assert_allclose(placed(after, np.array([[-100, -50], [100, -50]])), [[1, 1], [1, 6]], atol=1e-5)
    np.testing.assert_allclose(shown.strokes[2].points, corners(after), atol=1e-3)


def test_enter_after_one_pair_shifts_and_with_none_waits() -> None:
    after = fed((0, 2.5), (1, 1)).finish(MAP).edit.apply(MAP).backdrops[PLAN.id]  # type: ignore[union-attr]
    assert (after.center, after.length) == ((6.0, 3.5), 10.0)
    assert fed((0, 2.5)).finish(MAP).edit is None


def test_where_it_belongs_catches_the_end_of_a_wall_and_the_plan_does_not() -> None:
    end = next(iter(MAP.lines.values())).start
    beside = (end[0] + 0.03, end[1] + 0.02)
    tool = fed(beside, beside, free=False)
    assert tool.points == (beside, end)


def test_two_points_that_are_one_are_refused_before_and_when_clicked() -> None:
    tool = fed((0, 2.5), (1, 1), (0, 2.5))
    shown = tool.move(MAP, Hand((4, 4), free=True)).tool.sketch(MAP)  # type: ignore[union-attr]
    assert shown.refused
    assert "far apart" in shown.note
    with pytest.raises(EditError, match="far apart"):
        tool.press(MAP, Hand((4, 4), free=True))


def test_steps_back_and_a_plan_that_is_gone() -> None:
    tool = fed((0, 2.5), (1, 1))
    assert tool.back(MAP).tool.points == ((0, 2.5),)  # type: ignore[union-attr]
    assert tool.cancel() == AlignTool(PLAN.id)
    assert AlignTool(PLAN.id).cancel() is None
    assert tool.kept(MAP) is tool
    assert tool.kept(DeleteBackdrop(backdrop=PLAN.id).apply(MAP)) is None
