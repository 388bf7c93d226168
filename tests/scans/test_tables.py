"""Logs of one's own: what was written comes back, and what is wrong is named with its line or array."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rgcore.errors import InputError
from rgcore.scans.read import read_log
from rgviz.demo import LOG

HEADING = "stamp,x,y,theta,range_0,range_1,range_2\n"


def csv(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "scans.csv"
    path.write_bytes(text.encode())
    return path


def test_a_csv_is_read(tmp_path: Path) -> None:
    rows = "0.0,0,0,0,1.0,2.0,3.0\n0.5,0.1,0,0.2,1.5,inf,\n"
    remarks = "# angle_min = -0.5\n# angle_increment = 0.5\n# laser_x = 0.25\n# by hand\n"
    log = read_log(csv(tmp_path, remarks + HEADING + rows))
    np.testing.assert_allclose(log.bearings, [-0.5, 0, 0.5])
    np.testing.assert_allclose(log.base_from_laser, [0.25, 0, 0])
    np.testing.assert_allclose(log.odom_from_base, [[0, 0, 0], [0.1, 0, 0.2]])
    np.testing.assert_allclose(log.stamps, [0, 0.5])
    assert log.ranges[1, 0] == 1.5
    assert np.isinf(log.ranges[1, 1])
    assert np.isnan(log.ranges[1, 2])


def test_a_csv_of_ranges_alone(tmp_path: Path) -> None:
    log = read_log(csv(tmp_path, "range_0,range_1,range_2\n1,2,3\n"))
    assert not log.has_odometry
    np.testing.assert_allclose(log.bearings, [-np.pi / 2, 0, np.pi / 2])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (HEADING + "0,0,0,0,1,2\n" + "0,0,0,0,1,2,3\n", r"scans\.csv:2: damaged line: it has 6 cells, the heading 7"),
        (HEADING + "0,0,0,0,1,2,much\n" + "0,0,0,0,1,2,3\n", r"scans\.csv:2: damaged line: could not convert"),
        (HEADING + "0,0,0\r0,0,1,2,3\n" + "0,0,0,0,1,2,3\n", r"scans\.csv:2: damaged line: new-line character"),
        (HEADING.replace("theta", "the\rta"), r"scans\.csv:1: damaged heading"),
        (HEADING, "a heading and no scans"),
        ("stamp,height,range_0\n1,2,3\n", r"scans\.csv:1: column 'height'"),
        ("# angle_min = east\n" + HEADING + "0,0,0,0,1,2,3\n", r"scans\.csv:1: angle_min must be a number, not 'east'"),
        (HEADING + "0,nan,0,0,1,2,3\n", "odometry: row 0 is not finite"),
    ],
)
def test_what_is_wrong_with_a_csv_is_told(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        read_log(csv(tmp_path, text))


def test_a_csv_that_was_cut_off_gives_what_is_whole(tmp_path: Path) -> None:
    assert len(read_log(csv(tmp_path, HEADING + "0,0,0,0,1,2,3\n0.1,0,0,0,1.0,2"))) == 1


def test_a_log_saved_as_npz_comes_back(tmp_path: Path) -> None:
    log = read_log(LOG)[:50]
    log.save(tmp_path / "scans.npz")
    back = read_log(tmp_path / "scans.npz")
    np.testing.assert_array_equal(back.ranges, log.ranges)
    np.testing.assert_allclose(back.odom_from_base, log.odom_from_base)
    np.testing.assert_array_equal(back.bearings, log.bearings)
    np.testing.assert_array_equal(back.base_from_laser, log.base_from_laser)


def test_a_clockwise_npz_is_turned_round(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", ranges=[[1.0, 2.0, 3.0]], bearings=[0.5, 0.0, -0.5])
    log = read_log(tmp_path / "a.npz")
    assert log.bearings.tolist() == [-0.5, 0.0, 0.5]
    assert log.ranges.tolist() == [[3.0, 2.0, 1.0]]


@pytest.mark.parametrize(
    ("arrays", "told"),
    [
        ({"ranges": np.ones((2, 3))}, "holds no array 'bearings', only: ranges"),
        ({"ranges": np.ones(3), "bearings": np.zeros(3)}, r"ranges must be \(scans, beams\)"),
        ({"ranges": np.ones((2, 3)), "bearings": np.zeros(2)}, r"bearings must have the shape \(3,\), not \(2,\)"),
        ({"ranges": np.ones((2, 3)), "bearings": np.array([0, 1, np.nan])}, "bearings must be finite"),
        ({"ranges": np.ones((0, 3)), "bearings": np.zeros(3)}, "no readings"),
    ],
)
def test_what_is_wrong_with_an_npz_is_told(tmp_path: Path, arrays: dict[str, np.ndarray], told: str) -> None:
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(InputError, match=told):
        read_log(tmp_path / "a.npz")


def test_a_damaged_npz_is_refused_in_a_line(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez_compressed(path, ranges=np.random.default_rng(0).random((20, 30)), bearings=np.linspace(-1, 1, 30))
    whole = path.read_bytes()
    rng = np.random.default_rng(1)
    for n in range(60):
        damaged = bytearray(whole[: int(len(whole) * rng.uniform(0.05, 1))] if n % 2 else whole)
        for at in rng.integers(4, len(damaged), 5):
            damaged[at] = rng.integers(0, 256)
        path.write_bytes(bytes(damaged))
        try:
            read_log(path)
        except InputError as e:
            assert "\n" not in str(e)  # noqa: PT017


def test_an_archive_may_hold_what_is_no_array(tmp_path: Path) -> None:
    """NumPy gives back the bytes of such a member."""
    import zipfile

    read_log(LOG)[:3].save(tmp_path / "a.npz")
    with zipfile.ZipFile(tmp_path / "a.npz", "a") as z:
        z.writestr("readme.npy", b"hello")
    assert len(read_log(tmp_path / "a.npz")) == 3
