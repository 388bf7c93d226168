"""A floor plan says what is wrong with it, and its walls stand where it says."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rgcore.errors import InputError
from rgcore.geometry.raycast import cast
from rgcore.geometry.segments import lengths
from rgcore.scans.floor import FACE, FURNITURE, POST, Floor, build_floor
from rgcore.scans.plan import Plan, read_plan
from rgcore.scans.rings import area, inset, inside, tangled
from rgcore.scans.simulate import read_floor


def square(x0: float, y0: float, x1: float, y1: float) -> list[list[float]]:
    return [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]


def two_rooms(**changes: Any) -> dict[str, Any]:
    """A room of 4 x 3 m left of one of 5 x 3 m, a door of 0.9 m between them."""
    plan: dict[str, Any] = {
        "name": "two",
        "wall": 0.1,
        "start": [1, 1, 0],
        "rooms": [{"name": "A", "outline": square(0, 0, 4, 3)}, {"name": "B", "outline": square(4, 0, 9, 3)}],
        "doors": [{"at": [4, 1.5]}],
        "furniture": [{"label": "cabinet", "at": [8, 2.5], "size": [1, 0.5]}],
    }
    return plan | changes


def floor_of(plan: dict[str, Any]) -> Floor:
    return build_floor(msgspec.convert(plan, Plan), "two.json")


def test_wall_faces_stand_half_a_wall_from_the_middle_line() -> None:
    floor = floor_of(two_rooms())
    outline = floor.rooms[0].outline
    assert outline.min(0) == pytest.approx([0.05, 0.05])
    assert outline.max(0) == pytest.approx([3.95, 2.95])
    assert floor.rooms[0].area == pytest.approx(3.9 * 2.9)
    faces = floor.segments[(floor.kind == FACE) & (floor.room == 1)]
    assert lengths(faces).sum() == pytest.approx(2 * (3.9 + 2.9) - 0.9)
    assert lengths(floor.segments[floor.kind == POST]) == pytest.approx([0.1, 0.1])


def test_free_space_lies_to_the_left_of_every_segment() -> None:
    floor = floor_of(two_rooms())
    along = floor.segments[:, 1] - floor.segments[:, 0]
    left = np.stack([-along[:, 1], along[:, 0]], 1) / lengths(floor.segments)[:, None]
    middle = floor.segments.mean(1)
    assert (floor.labels.at(middle + 0.06 * left) > 0).all()
    behind = floor.labels.at(middle - 0.03 * left)
    assert (behind[floor.kind == FURNITURE] == 0).all()


def test_a_door_joins_its_rooms_and_a_closed_one_does_not() -> None:
    floor = floor_of(two_rooms())
    (door,) = floor.doors
    assert {door.a, door.b} == {1, 2}
    assert sorted(door.posts.tolist()) == [[4.0, pytest.approx(1.05)], [4.0, pytest.approx(1.95)]]
    assert floor.labels.at(np.array([[3.98, 1.5], [4.02, 1.5]])).tolist() == [1, 2]
    closed = floor_of(two_rooms(doors=[{"at": [4, 1.5], "open": False}]))
    assert closed.labels.at(np.array([4.0, 1.5])) == 0
    assert (closed.kind != POST).all()


def test_a_table_is_four_legs() -> None:
    table = {"label": "table", "at": [6, 1.5], "size": [1.6, 0.8], "shape": "legs"}
    floor = floor_of(two_rooms(furniture=[table]))
    legs = floor.segments[floor.kind == FURNITURE].reshape(4, 4, 2, 2).mean((1, 2))
    assert np.abs(legs - [6, 1.5]) == pytest.approx(np.tile([0.775, 0.375], (4, 1)))


def test_a_wall_may_stand_free() -> None:
    floor = floor_of(two_rooms(walls=[{"start": [6, 0.5], "end": [6, 2], "thickness": 0.2}]))
    assert floor.labels.at(np.array([[6.0, 1.0], [6.15, 1.0], [6.0, 2.1]])).tolist() == [0, 2, 2]
    ranges, _ = cast(floor.segments, np.array([[5.0, 1.0, 0.0]]), np.zeros(1), 30.0)
    assert ranges[0, 0] == pytest.approx(0.9)


def test_a_ring_corridor_has_a_hole() -> None:
    plan = {
        "name": "ring",
        "start": [1, 1, 0],
        "rooms": [
            {"name": "Hallway", "cls": "hallway", "outline": square(0, 0, 10, 8), "holes": [square(2, 2, 8, 6)]},
            {"name": "Core", "outline": square(2, 2, 8, 6)},
        ],
        "doors": [{"at": [5, 2]}],
    }
    floor = floor_of(plan)
    hallway, core = floor.rooms
    assert hallway.area == pytest.approx((10 - 0.14) * (8 - 0.14) - (6 + 0.14) * (4 + 0.14))
    assert core.area == pytest.approx((6 - 0.14) * (4 - 0.14))
    assert (hallway.room.region_class, core.room.region_class) == ("CDMA", "TOMA")
    assert floor.labels.at(np.array([[1.0, 4.0], [5.0, 4.0], [2.0, 4.0]])).tolist() == [1, 2, 0]


WRONG: list[tuple[dict[str, Any], str]] = [
    (two_rooms(walls_=[]), "unknown field `walls_`"),
    (two_rooms(wall="thick"), "wall: .*float"),
    (two_rooms(doors=[{"at": [4, 1.5], "width": -1}]), r"doors\[0\]\.width"),
    (two_rooms(doors=[{"at": [2, 1.5]}]), r"doors\[0\] at \(2, 1.5\): not on the common wall .* none"),
    (two_rooms(doors=[{"at": [4, 1.5]}, {"at": [2, 0]}]), r"doors\[1\].* walls of: A"),
    (two_rooms(doors=[{"at": [4, 0.3]}]), "reaches into a corner"),
    (two_rooms(doors=[{"at": [4, 1.2]}, {"at": [4, 1.9]}]), "two of its doors overlap"),
    (two_rooms(doors=[]), 'room "A": has no door'),
    (two_rooms(start=[4, 0.5, 0]), r"start: \(4, 0.5\)"),
    (two_rooms(furniture=[{"label": "sofa", "at": [4, 1], "size": [1, 1]}]), r"furniture\[0\] sofa"),
    (two_rooms(junctions=[{"room": "C", "at": [1, 1], "width": 2, "arms": [0, 1]}]), 'no room "C"'),
    (two_rooms(rooms=[{"name": "A", "outline": [[0, 0], [4, 3], [4, 0], [0, 3]]}]), "crosses itself"),
    (two_rooms(rooms=[{"name": "A", "outline": square(0, 0, 0.05, 3)}]), "no floor is left"),
    (two_rooms(rooms=[{"name": n, "outline": square(0, 0, x, 3)} for n, x in (("A", 4), ("B", 5))]), "walls of: A"),
    (two_rooms(rooms=[{"name": "A", "outline": square(0, 0, 4000, 3000)}], doors=[]), "coordinates in metres"),
]


@pytest.mark.parametrize(("plan", "message"), WRONG, ids=[m for _, m in WRONG])
def test_a_wrong_plan_is_one_line_that_names_file_and_item(tmp_path: Path, plan: dict[str, Any], message: str) -> None:
    path = tmp_path / "two.json"
    path.write_bytes(msgspec.json.encode(plan))
    with pytest.raises(InputError) as error:
        build_floor(read_plan(path), path)
    text = str(error.value)
    assert text.startswith(f"{path}: ")
    assert "\n" not in text
    assert re.search(message, text), text


def test_overlapping_rooms_are_refused() -> None:
    rooms = [{"name": "A", "outline": square(0, 0, 4, 3)}, {"name": "B", "outline": square(4, 0, 9, 3)}]
    rooms += [{"name": "C", "outline": square(5, 1, 7, 5)}, {"name": "D", "outline": square(4, 5, 9, 8)}]
    with pytest.raises(InputError, match='"B" and "C" overlap'):
        floor_of(two_rooms(rooms=rooms, doors=[{"at": [4, 1.5]}, {"at": [6, 5]}], furniture=[]))


@pytest.mark.parametrize("content", [b"", b"{", b"\xff\xfe", b"[1]", b"null"])
def test_a_file_that_is_no_plan(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "plan.json"
    path.write_bytes(content)
    with pytest.raises(InputError, match=re.escape(f"{path}: ")):
        read_floor(path)
    with pytest.raises(InputError, match="cannot read"):
        read_floor(tmp_path / "absent.json")


@given(
    st.lists(st.floats(0.5, 5), min_size=3, max_size=9),
    st.floats(0.01, 0.1),
)
def test_an_inset_ring_is_its_distance_away(radii: list[float], distance: float) -> None:
    angle = 2 * np.pi * np.arange(len(radii)) / len(radii)
    ring = np.array(radii)[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1)
    inner = inset(ring, distance)
    d = np.roll(ring, -1, 0) - ring
    n = np.stack([-d[:, 1], d[:, 0]], 1) / np.linalg.norm(d, axis=1, keepdims=True)
    assert ((inner - ring) * n).sum(1) == pytest.approx(np.full(len(ring), distance))
    assert not tangled(ring)
    assert area(ring) > 0
    assert inside((ring,), np.zeros((1, 2))).all() == (len(radii) > 2)


def image_plan(path: Path, pixel: float = 0.05) -> Path:
    """A room of 6 x 4 m with a pillar; unknown outside, and unknown behind an open side."""
    image = np.full((100, 140), 205, np.uint8)
    image[8:92, 8:132] = 0
    image[10:90, 10:130] = 254
    image[40:50, 60:70] = 0
    image[60:80, 130:132] = 205
    cv2.imwrite(str(path), image)
    return path


@pytest.mark.parametrize("ending", ["png", "pgm"])
def test_an_image_is_a_floor(tmp_path: Path, ending: str) -> None:
    floor = read_floor(image_plan(tmp_path / f"plan.{ending}"), resolution=0.05)
    ends = floor.segments.reshape(-1, 2)
    assert ends.min(0) == pytest.approx([0.5, 0.5], abs=0.05)
    assert ends.max(0) == pytest.approx([6.5, 4.5], abs=0.05)
    assert lengths(floor.segments).sum() == pytest.approx(2 * (6 + 4) + 4 * 0.5 - 1.0, abs=0.3)
    assert (floor.labels.values > 0).sum() * 0.05**2 == pytest.approx(6 * 4 - 0.25, abs=0.01)
    along = floor.segments[:, 1] - floor.segments[:, 0]
    left = np.stack([-along[:, 1], along[:, 0]], 1) / lengths(floor.segments)[:, None]
    assert (floor.labels.at(floor.segments.mean(1) + 0.05 * left) > 0).all()


def test_an_image_needs_the_size_of_its_pixels(tmp_path: Path) -> None:
    path = image_plan(tmp_path / "plan.png")
    with pytest.raises(InputError, match="--resolution"):
        read_floor(path)
    with pytest.raises(InputError, match=r"between 0\.001 and 1"):
        read_floor(path, resolution=50)
    dark = tmp_path / "dark.png"
    cv2.imwrite(str(dark), np.zeros((20, 20), np.uint8))
    with pytest.raises(InputError, match="no free floor"):
        read_floor(dark, resolution=0.05)
