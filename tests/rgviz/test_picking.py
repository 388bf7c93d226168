"""A click finds the right thing; the projection is the browser's (``tests/browser`` checks it against a real one)."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from office_map import big_office, office_map

from rgcore.model.records import RGMap, replace
from rgviz.picking import Item, Kind, Picker, Projector, region_at

DOWN = (0.0, 1.0, 0.0, 0.0)
"""wxyz of a camera that looks straight down with the map's +y up on the screen"""


def above(x: float, y: float, metres: float = 20.0, fov: float = 0.1) -> SimpleNamespace:
    """A camera over (x, y) that sees ``metres`` from top to bottom."""
    height = metres / 2 / np.tan(fov / 2)
    position = np.array([x, y, height])
    return SimpleNamespace(wxyz=np.array(DOWN), position=position, fov=fov, image_width=1000, image_height=800)


def click(picker: Picker, x: float, y: float, want: Kind | None = None, metres: float = 20.0) -> Item | None:
    camera = above(8.0, 6.0, metres)
    pixel = Projector(camera)(np.array([x, y, 0.0]))
    ray = camera.position, np.array([x, y, 0.0]) - camera.position
    return picker.at(camera, tuple(pixel / (1000, 800)), ray, want)


@pytest.fixture(scope="module")
def picker() -> Picker:
    return Picker(office_map(4, 1, 2))


def test_each_kind_is_found(picker: Picker) -> None:
    assert click(picker, 5.5, 3.5) == Item("region", "r4")
    assert click(picker, 8.0, 6.0) == Item("region", "r2")
    assert click(picker, 5.95, 5.0) == Item("gateway", "g3")
    assert click(picker, 4.0, 3.0) in (Item("line", f"l{n}") for n in range(1, 99))
    assert click(picker, 4.7, 0.65) == Item("object", "o2")
    assert click(picker, 18.0, 14.0) is None


def test_what_is_small_wins_and_lines_win_when_asked(picker: Picker) -> None:
    edge = (4.7, 0.4)  # on the cabinet's front: object and line at once
    assert click(picker, *edge).kind == "object"  # type: ignore[union-attr]
    line = click(picker, *edge, want="line")
    assert line is not None
    assert line.kind == "line"
    assert click(picker, 5.5, 3.5, want="line") is None
    assert click(picker, *edge, want="region") == Item("region", "r4")


def test_reach_is_in_pixels(picker: Picker) -> None:
    near = (4.15, 3.0)  # 15 cm off the wall: 6 px in a view of 20 m, 30 px in one of 4 m
    assert click(picker, *near).kind == "line"  # type: ignore[union-attr]
    assert click(picker, *near, metres=4.0) == Item("region", "r4")


def test_hole_and_smallest_region_decide() -> None:
    m = office_map(4, 1, 0)
    room = m.regions["r4"]
    square = ((-5, -5), (20, -5), (20, 20), (-5, 20))
    big = replace(m.regions["r1"], boundary=square, box=replace(room.box, size=(25.0, 25.0)))
    assert region_at(replace(m, regions={"r1": big, "r4": room}), np.array([5.0, 3.0])) == "r4"
    holed = replace(big, holes=(((4, 2), (6, 2), (6, 4), (4, 4)),))
    assert region_at(replace(m, regions={"r1": holed}), np.array([5.0, 3.0])) is None
    assert region_at(replace(m, regions={"r1": holed}), np.array([7.0, 3.0])) == "r1"


def test_oblique_rays_hit_the_top_of_a_box(picker: Picker) -> None:
    ray = np.array([4.7, -20.0, 21.0]), np.array([0.0, 20.65, -20.2])
    eye = SimpleNamespace(wxyz=np.array(DOWN), position=ray[0], fov=0.8, image_width=1000, image_height=800)
    assert picker.at(eye, (-5.0, -5.0), ray) == Item("object", "o2")


def test_an_empty_map_has_nothing_to_pick() -> None:
    assert click(Picker(RGMap()), 0.0, 0.0) is None


@given(st.floats(-50, 50), st.floats(-50, 50), st.floats(2, 200), st.floats(0.05, 1.5))
def test_projection_is_undone_by_the_ray(x: float, y: float, metres: float, fov: float) -> None:
    camera = above(3.0, -2.0, metres, fov)
    px = Projector(camera)(np.array([x, y, 0.0]))
    scale = 800 / metres
    assert np.allclose(px, (500 + (x - 3.0) * scale, 400 - (y + 2.0) * scale), atol=1e-6 * max(1, abs(px).max()))


def test_a_large_map_is_picked_at_once() -> None:
    import time

    picker = Picker(big_office(5000))
    began = time.process_time()
    for _ in range(5):
        click(picker, 9.5, 3.5)
    assert (time.process_time() - began) / 5 < 0.1
