"""The ruler, and going back in the history in one step."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from make_project import make_project
from office_map import office_map

from rgcore.errors import EditError
from rgcore.model.edits import RenameRegion
from rgcore.model.project import Project
from rgviz.session import Session
from rgviz.tools.measuring import Ruler, corner, readout
from rgviz.tools.tool import Hand

MAP = office_map(4, 1, 2)


def ruler(*places: tuple[float, float]) -> Ruler:
    tool = Ruler()
    for x, y in places:
        tool = tool.press(MAP, Hand((x, y), 0.001)).tool  # type: ignore[assignment]
    return tool


def test_distance_angle_and_area() -> None:
    assert readout(((0.0, 0.0), (3.0, 4.0))) == "5.00 m at 53°"
    told = readout(((0.0, 0.0), (3.0, 0.0), (3.0, 4.0)))
    assert told == "7.00 m in all, 4.00 m at 90°, corner 90.0°, area 6.00 m²"
    assert readout(((0.0, 0.0),)) == ""
    assert corner((1.0, 0.0), (0.0, 0.0), (-1.0, 0.0)) == pytest.approx(math.pi)


def test_it_catches_the_ends_of_walls_and_begins_anew() -> None:
    tool = ruler((4.003, 0.002), (7.8, 0.004))
    assert tool.points == ((4.0, 0.0), (7.8, 0.0))
    assert "3.80 m" in [s.text for s in tool.sketch(MAP).strokes]
    ended = tool.press(MAP, Hand((7.8, 0.0), 0.001)).tool
    assert isinstance(ended, Ruler)
    assert ended.done
    assert readout(ended.path) == "3.80 m at 0°"
    again = ended.press(MAP, Hand((1.0, 1.0), 0.001)).tool
    assert isinstance(again, Ruler)
    assert len(again.points) == 1
    assert ended.cancel() == Ruler()
    assert Ruler().cancel() is None
    assert not Ruler.edits, "who only looks may measure"


def test_over_a_gateway_or_a_wall_it_tells_their_size() -> None:
    g = MAP.gateways["g3"]
    (ax, ay), (bx, by) = g.posts
    over = Ruler().move(MAP, Hand(((ax + bx) / 2, (ay + by) / 2), 0.01)).tool
    assert over is not None
    assert over.sketch(MAP).note == "g3: 0.90 m wide"
    on_wall = Ruler().move(MAP, Hand((4.0, 2.5), 0.01)).tool
    assert on_wall is not None
    assert on_wall.sketch(MAP).note.endswith("5.00 m long")


def test_back_to_an_edit_is_one_step_for_who_looks_on(tmp_path: Path) -> None:
    with Project.open(make_project(tmp_path / "p.rg", MAP)) as project:
        session = Session(project)
        heard: list[str] = []
        session.listen(lambda before, after: heard.append(after.regions["r4"].name))
        for name in ("one", "two", "three"):
            session.do(RenameRegion(region="r4", name=name))
        heard.clear()
        session.back_to(1)
        assert heard == ["one"]
        session.back_to(3)
        session.back_to(0)
        assert heard == ["one", "three", MAP.regions["r4"].name]
        for number in (-1, 4):
            with pytest.raises(EditError, match="no such edit"):
                session.back_to(number)
