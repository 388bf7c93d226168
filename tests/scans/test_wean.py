"""Wean Hall logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rgcore.errors import InputError
from rgcore.scans.read import read_log


def laser_line(x: float, y: float, theta: float, readings: list[int], ts: float) -> str:
    ahead = [x + 25 * np.cos(theta), y + 25 * np.sin(theta), theta]
    return " ".join(map(str, ["L", x, y, theta, *ahead, *readings, ts])) + "\n"


def log(folder: Path, *lines: str) -> Path:
    path = folder / "wean.txt"
    path.write_text("".join(lines))
    return path


def test_centimetres_become_metres_and_the_laser_sits_ahead(tmp_path: Path) -> None:
    readings = [100 + i for i in range(180)]
    readings[5] = 8183
    path = log(
        tmp_path,
        "O 1 2 0.5 0.01\n",
        laser_line(100, 200, 0.5, readings, 0.25),
        "O 1 2 0.5 0.4\n",
        laser_line(150, 210, 4.0, readings, 0.5),
    )
    got = read_log(path)
    assert got.format == "wean"
    np.testing.assert_allclose(got.base_from_laser, [0.25, 0, 0], atol=1e-4)
    np.testing.assert_allclose(got.odom_from_base, [[1, 2, 0.5], [1.5, 2.1, 4.0 - 2 * np.pi]], atol=1e-9)
    np.testing.assert_allclose(np.degrees(got.bearings), np.arange(-90, 90))
    assert got.ranges[0, 0] == pytest.approx(1.0)
    assert np.isinf(got.ranges[:, 5]).all()
    assert got.max_range == pytest.approx(2.79)
    assert got.stamps.tolist() == [0.25, 0.5]
    assert "2 O and 0 other lines not used" in got.notes


def test_damaged_line_is_named_and_a_cut_last_one_is_left_out(tmp_path: Path) -> None:
    good = laser_line(0, 0, 0, [100] * 180, 1.0)
    with pytest.raises(InputError, match=r"wean.txt:2: damaged laser line: it has 157 fields, the lines before 188"):
        read_log(log(tmp_path, good, laser_line(0, 0, 0, [100] * 149, 1.0), good))
    with pytest.raises(InputError, match=r"wean.txt:2: damaged"):
        read_log(log(tmp_path, good, good.replace("100", "1x0"), good))
    cut = read_log(log(tmp_path, good, good, good[:300]))
    assert len(cut) == 2
    assert "last line (3) is cut off" in cut.notes
