"""Opening a log: content decides, and bad files get one clear line."""

from __future__ import annotations

import gzip
import hashlib
from pathlib import Path

import numpy as np
import pytest

from rgcore.errors import InputError
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log

FLASER = "FLASER 5 1.00 1.50 2.00 1.50 81.91 0.1 0.2 0.3 0.1 0.2 0.3 12.5 robot 12.5\n"
WEAN = "L 100.0 200.0 0.5 121.94 211.99 0.5 66 67 8183 70 71 0.25\nO 100 200 0.5 0.3\n"
SMALL = (
    "# a small log\nPARAM robot_frontlaser_offset 0.1 robot 0\n"
    + FLASER
    + FLASER.replace("12.5", "13.25").replace("0.1", "0.4")
    + "ODOM 1 2 0.5 0 0 0 13.5 robot 13.5\n"
    + "FLASER 3 1.00 2.00 1.00 0.5 0.6 3.2 0.5 0.6 3.2 14.125 robot 14.125\n"
)


def write(folder: Path, content: str | bytes, name: str = "office.log") -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def test_plain_and_gzipped_are_told_apart_by_content(tmp_path: Path) -> None:
    plain = read_log(write(tmp_path, SMALL, "office.gz"))
    packed = read_log(write(tmp_path, gzip.compress(SMALL.encode()), "office.txt"))
    np.testing.assert_array_equal(plain.ranges, packed.ranges)
    assert len(plain) == 3
    assert plain.sha256 == hashlib.sha256(SMALL.encode()).hexdigest()
    assert packed.sha256 == hashlib.sha256((tmp_path / "office.txt").read_bytes()).hexdigest()


def test_gzip_of_several_members_and_padding(tmp_path: Path) -> None:
    halves = gzip.compress(FLASER.encode()) + gzip.compress(FLASER.encode()) + b"\0" * 100
    assert len(read_log(write(tmp_path, halves))) == 2


def test_content_decides_the_format_not_the_name(tmp_path: Path) -> None:
    assert read_log(write(tmp_path, WEAN, "robot.carmen.log")).format == "wean"
    assert read_log(write(tmp_path, SMALL, "wean.txt")).format == "carmen"


def test_windows_line_ends_and_byte_order_mark(tmp_path: Path) -> None:
    log = read_log(write(tmp_path, b"\xef\xbb\xbf" + SMALL.replace("\n", "\r\n").encode()))
    assert len(log) == 3
    assert log.stamps.tolist() == [12.5, 13.25, 14.125]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty"),
        (b"\n \n", "white space"),
        (gzip.compress(SMALL.encode())[:-20], "ends early"),
        (gzip.compress(SMALL.encode())[:5], "ends early"),
        (b"\x1f\x8bnot really gzip", "damaged"),
        (
            bytes(range(256)) * 40,
            "a binary file of no known log format; known are: ROS bag, grid map (.yaml), NPZ, CARMEN, Wean",
        ),
        (b"hello\nworld\n", "a text file of no known log format"),
        (b"ODOM 1 2 0.5 0 0 0 13.5 robot 13.5\n", "holds no laser lines"),
        (b"VERTEX2 0 1 2 3\nEDGE2 0 1 1 0 0 1 0 0 1 0 1\n", "holds no laser lines"),
        (b"O 100 200 0.5 0.3\n", "holds no whole laser line"),
        (FLASER[:40].encode(), "cut off"),
        (b"FLASER 0 0.1 0.2 0.3 0.1 0.2 0.3 12.5 robot 12.5\n", "no readings"),
    ],
)
def test_useless_files_get_one_line_that_names_them(tmp_path: Path, content: bytes, message: str) -> None:
    path = write(tmp_path, content)
    with pytest.raises(InputError) as e:
        read_log(path)
    assert str(e.value).startswith(str(path))
    assert message in str(e.value)
    assert "\n" not in str(e.value)


def test_missing_file_and_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_log(tmp_path / "nowhere.log")
    with pytest.raises(InputError, match="is a folder"):
        read_log(tmp_path)
    with pytest.raises(InputError, match="cannot be read"):
        read_log("a\0b")


@pytest.mark.parametrize("content", [SMALL, WEAN * 2])
def test_cut_at_every_byte_it_is_a_log_or_an_input_error(tmp_path: Path, content: str) -> None:
    whole = read_log(write(tmp_path, content))
    read = 0
    for end in range(len(content)):
        try:
            log = read_log(write(tmp_path, content[:end]))
        except InputError:
            continue
        read += 1
        assert isinstance(log, ScanLog)
        assert len(log) <= len(whole)
        assert len(log.stamps) == len(log.odom_from_base) == len(log)
        if len(log) > 1:  # a line that is cut inside never gives a scan that was not in the log
            np.testing.assert_array_equal(log.stamps[:-1], whole.stamps[: len(log) - 1])
    assert read > len(content) // 4


@pytest.mark.parametrize("content", [SMALL.encode(), (WEAN * 2).encode(), gzip.compress(SMALL.encode())])
def test_any_flipped_byte_gives_a_log_or_an_input_error(tmp_path: Path, content: bytes) -> None:
    random = np.random.default_rng(0)
    for _ in range(300):
        damaged = bytearray(content)
        for at in random.integers(0, len(content), 3):
            damaged[at] = random.integers(256)
        try:
            log = read_log(write(tmp_path, bytes(damaged)))
        except InputError as e:
            assert "\n" not in str(e)  # noqa: PT017
        else:
            assert np.isfinite(log.odom_from_base).all()
            assert not (log.ranges <= 0).any()
