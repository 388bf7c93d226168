"""Files are written whole or not at all, and what cannot be written is said in one line."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from export_maps import ROOMS, TRAJECTORY

from rgcore.errors import RgError
from rgcore.exports.formats import FORMATS, export, exported, render


@pytest.mark.parametrize("ending", FORMATS)
def test_every_format_is_written_as_rendered_and_the_same_again(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"office{ending.upper()}"
    path.write_text("old")
    export(path, ROOMS, TRAJECTORY)
    made = exported(ending, ROOMS, TRAJECTORY, stem="office")
    assert path.read_bytes() == made.data
    assert {p.name for p in tmp_path.iterdir()} == {path.name, *(f"office{name}" for name in made.beside)}
    mask = os.umask(0)
    os.umask(mask)
    assert path.stat().st_mode & 0o777 == 0o666 & ~mask


def test_an_unknown_ending_lists_the_known_ones(tmp_path: Path) -> None:
    for name in ("office.xyz", "office"):
        with pytest.raises(RgError, match=r"no export format .*; known endings: \.json \.glb \.svg"):
            export(tmp_path / name, ROOMS)


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(RgError, match="cannot be written: No such file or directory"):
        export(tmp_path / "no" / "office.json", ROOMS)


def test_a_target_that_is_a_folder(tmp_path: Path) -> None:
    (tmp_path / "office.json").mkdir()
    with pytest.raises(RgError, match="cannot be written"):
        export(tmp_path / "office.json", ROOMS)
    assert [p.name for p in tmp_path.iterdir()] == ["office.json"]


def test_a_full_disk_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "office.json"
    path.write_text("old")

    def full(fd: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(RgError, match=r"office\.json: cannot be written: No space left on device"):
        export(path, ROOMS)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["office.json"]


@pytest.mark.parametrize("height", [0.0, -1.0, float("nan"), 1e9])
def test_a_wall_height_out_of_bounds(height: float) -> None:
    with pytest.raises(RgError, match="wall height"):
        render(".glb", ROOMS, wall_height=height)
