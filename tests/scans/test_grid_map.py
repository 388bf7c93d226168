"""Grid maps of ROS: cells are read as the map server publishes them, and become a map as a log would."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from PIL import Image

from rgcore import pipeline
from rgcore.errors import InputError
from rgcore.exports.formats import export
from rgcore.scans.grid_map import FREE, OCCUPIED, UNKNOWN, read_grid
from rgcore.scans.read import read_log

RES = 0.05


def office() -> np.ndarray:
    """Two rooms of 4 x 4 m and a door of 0.9 m between them, grey as map savers write it; first row = largest y."""
    grey = np.full((104, 188), 205, np.uint8)
    grey[10:94, 10:178] = 0
    grey[12:92, 12:92] = grey[12:92, 96:176] = 254
    grey[43:61, 92:96] = 254
    return grey


def saved(tmp_path: Path, pixels: np.ndarray, ending: str = "pgm", **about: Any) -> Path:
    Image.fromarray(pixels).save(tmp_path / f"map.{ending}")
    usual = {"image": f"map.{ending}", "resolution": RES, "origin": [-1.0, -2.0, 0.0], "negate": 0}
    path = tmp_path / "map.yaml"
    path.write_text(yaml.safe_dump({**usual, "occupied_thresh": 0.65, "free_thresh": 0.196, **about}))
    return path


def test_two_rooms_and_their_door_are_found(tmp_path: Path) -> None:
    log = read_log(saved(tmp_path, office()))
    made = pipeline.run(log).map
    assert len(made.regions) == 2
    (door,) = made.gateways.values()
    assert door.width == pytest.approx(0.9, abs=0.1)
    np.testing.assert_allclose(np.mean(door.posts, axis=0), [-1 + 94 * RES, -2 + 52 * RES], atol=0.1)
    for r in made.regions.values():
        x, y = np.array(r.boundary).T
        assert 0.5 * abs(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1))) == pytest.approx(16, abs=0.8)
        assert r.accuracy is None
        assert r.scans == 0
    assert made.stats.accuracy is None
    walls = sorted((np.hypot(*np.subtract(v.end, v.start)) for v in made.lines.values()), reverse=True)
    np.testing.assert_allclose(walls[:6], 4.0, atol=0.15)
    assert "there is no accuracy" in log.notes


def test_our_own_grid_comes_back_as_the_same_rooms(tmp_path: Path) -> None:
    made = pipeline.run(read_log(saved(tmp_path, office()))).map
    (tmp_path / "out").mkdir()
    export(tmp_path / "out" / "office.yaml", made)
    again = pipeline.run(read_log(tmp_path / "out" / "office.yaml")).map
    assert len(again.regions) == len(made.regions)
    (a,), (b,) = made.gateways.values(), again.gateways.values()
    across, along = np.abs(np.mean(a.posts, axis=0) - np.mean(b.posts, axis=0))
    assert along < 0.1
    assert across < 0.3  # anywhere in the thickness of the wall


def test_the_origin_turns_the_map(tmp_path: Path) -> None:
    log = read_log(saved(tmp_path, office(), origin=[10.0, 20.0, np.pi / 2]))
    x, y = log.odom_from_base[:, 0], log.odom_from_base[:, 1]
    assert 10 - 94 * RES < x.min() < x.max() < 10 - 10 * RES
    assert 20 + 10 * RES < y.min() < y.max() < 20 + 178 * RES


@pytest.mark.parametrize(
    ("mode", "negate", "grey", "cell"),
    [
        ("trinary", 0, 254, FREE),
        ("trinary", 0, 0, OCCUPIED),
        ("trinary", 0, 205, UNKNOWN),
        ("trinary", 1, 254, OCCUPIED),
        ("trinary", 1, 0, FREE),
        ("scale", 0, 128, UNKNOWN),
        ("raw", 0, 0, FREE),
        ("raw", 0, 100, OCCUPIED),
        ("raw", 0, 255, UNKNOWN),
    ],
)
def test_a_grey_value_means_what_the_map_server_says(
    tmp_path: Path, mode: str, negate: int, grey: int, cell: int
) -> None:
    grid = read_grid(saved(tmp_path, np.full((4, 4), grey, np.uint8), mode=mode, negate=negate))
    assert (grid.cells.values == cell).all()


def test_transparent_pixels_are_unknown_in_mode_scale(tmp_path: Path) -> None:
    pixels = np.full((4, 4, 4), 255, np.uint8)
    pixels[0, 0, 3] = 0
    grid = read_grid(saved(tmp_path, pixels, "png", mode="scale"))
    assert grid.cells.values[3, 0] == UNKNOWN
    assert (grid.cells.values == FREE).sum() == 15


def test_a_loose_threshold_does_not_make_the_unknown_free(tmp_path: Path) -> None:
    grid = read_grid(saved(tmp_path, office(), free_thresh=0.25))
    assert grid.cells.values[0, 0] == UNKNOWN
    assert "0.196 is used" in grid.notes[0]


@pytest.mark.parametrize(
    ("about", "told"),
    [
        ({"resolution": "fine"}, "resolution must be a number, not 'fine'"),
        ({"resolution": 0.0}, "resolution 0 must lie between"),
        ({"origin": [1, 2]}, r"origin must be \[x, y, yaw\]"),
        ({"origin": [1, 2, float("nan")]}, "is not finite"),
        ({"mode": "colour"}, "mode 'colour' is not known; known are: trinary, scale, raw"),
        ({"free_thresh": 0.7}, "free_thresh 0.7 must be below occupied_thresh 0.65"),
        ({"image": "elsewhere.pgm"}, r"its image elsewhere\.pgm is not there"),
    ],
)
def test_what_is_wrong_with_a_grid_is_told(tmp_path: Path, about: dict[str, Any], told: str) -> None:
    with pytest.raises(InputError, match=told):
        read_log(saved(tmp_path, office(), **about))


def test_files_that_are_no_grid_are_told(tmp_path: Path) -> None:
    path = saved(tmp_path, office())
    whole = (tmp_path / "map.pgm").read_bytes()
    (tmp_path / "map.pgm").write_bytes(b"P5 nonsense")
    with pytest.raises(InputError, match="not an image"):
        read_log(path)
    (tmp_path / "map.pgm").write_bytes(b"P5\n200000 200000\n255\n" + b"\0" * 99)
    with pytest.raises(InputError, match=r"not an image|too large"):
        read_log(path)
    (tmp_path / "map.pgm").write_bytes(whole)
    path.write_text("image: [map.pgm\nresolution: 1")
    with pytest.raises(InputError, match="not YAML"):
        read_log(path)
    Image.fromarray(np.full((9, 9), 0, np.uint8)).save(tmp_path / "map.pgm")
    with pytest.raises(InputError, match="no free floor"):
        read_log(saved(tmp_path, np.full((9, 9), 0, np.uint8)))
    open_ground = np.full((60, 60), 205, np.uint8)
    open_ground[5:55, 5:55] = 254
    with pytest.raises(InputError, match="no free floor with walls"):
        read_log(saved(tmp_path, open_ground))
