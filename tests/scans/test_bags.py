"""Bags of both versions: what the robot meant comes out, and what is missing or damaged is said in a line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from make_bags import Bag, Laser, drive, wall_ranges

from rgcore.errors import InputError
from rgcore.scans.bags import Topics, topics
from rgcore.scans.read import read_log

KINDS = [(1, "sqlite3", "a.bag"), (2, "sqlite3", "a"), (2, "mcap", "a")]


@pytest.mark.parametrize(("version", "storage", "name"), KINDS)
def test_a_bag_is_read(tmp_path: Path, version: int, storage: str, name: str) -> None:
    log = read_log(drive(Bag(version)).write(tmp_path / name, storage))
    assert log.format == "bag"
    assert log.has_odometry
    np.testing.assert_allclose(log.stamps, 100 + 0.1 * np.arange(5))
    np.testing.assert_allclose(log.odom_from_base, [(0.1 * k, 0, 0.02 * k) for k in range(5)], atol=1e-6)
    np.testing.assert_allclose(log.base_from_laser, (0.2, 0, 0.5), atol=1e-6)
    np.testing.assert_allclose(log.bearings, -1.5 + 0.01 * np.arange(301), atol=1e-6)
    np.testing.assert_allclose(log.ranges[3], wall_ranges(), atol=1e-6)


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_the_file_of_a_bag_alone_is_read_too(tmp_path: Path, storage: str) -> None:
    folder = drive(Bag()).write(tmp_path / "a", storage)
    (file,) = folder.glob("*.db3" if storage == "sqlite3" else "*.mcap")
    alone = file.rename(tmp_path / file.name)
    assert len(read_log(alone)) == 5


def test_a_clockwise_laser_is_turned_round(tmp_path: Path) -> None:
    log = read_log(drive(Bag(), laser=Laser(angle_min=1.5, step=-0.01)).write(tmp_path / "a"))
    np.testing.assert_allclose(log.bearings, -1.5 + 0.01 * np.arange(301), atol=1e-5)
    np.testing.assert_allclose(log.ranges[0], wall_ranges()[::-1], atol=1e-6)
    assert "clockwise" in log.notes


def test_a_laser_that_hangs_upside_down_sees_left_as_right(tmp_path: Path) -> None:
    log = read_log(drive(Bag(), laser=Laser(over=True)).write(tmp_path / "a"))
    np.testing.assert_allclose(log.base_from_laser, (0.2, 0, 0.5), atol=1e-6)
    np.testing.assert_allclose(log.bearings, -1.5 + 0.01 * np.arange(301), atol=1e-5)
    np.testing.assert_allclose(log.ranges[0], wall_ranges()[::-1], atol=1e-6)


def test_no_echo_too_near_and_failed_readings_are_told_apart(tmp_path: Path) -> None:
    ranges = wall_ranges(8)
    ranges[:5] = np.inf, 30.0, 0.05, np.nan, -np.inf
    bag = Bag()
    bag.scan(1.0, ranges)
    log = read_log(bag.write(tmp_path / "a"))
    assert np.isinf(log.ranges[0, :2]).all()
    assert np.isnan(log.ranges[0, 2:5]).all()
    assert np.isfinite(log.ranges[0, 5:]).all()


def test_scans_of_changing_length(tmp_path: Path) -> None:
    bag = Bag()
    for k in range(6):
        beams = 301 if k != 3 else 250
        bag.scan(1.0 + k, wall_ranges(beams), Laser(step=3.0 / (beams - 1)))
    log = read_log(bag.write(tmp_path / "a"))
    assert log.ranges.shape == (6, 301)
    assert "1 scans of another fan" in log.notes


def test_without_odometry_the_transforms_tell_it(tmp_path: Path) -> None:
    bag = Bag()
    bag.transform(1.0, "base_link", "laser", (0.1, 0.2, 0.0))
    for k in range(4):
        bag.transform(1.0 + k, "odom", "base_link", (0.5 * k, 0, 0))
        bag.scan(1.0 + k, wall_ranges())
    log = read_log(bag.write(tmp_path / "a"))
    np.testing.assert_allclose(log.odom_from_base[:, 0], [0, 0.5, 1.0, 1.5], atol=1e-6)
    np.testing.assert_allclose(log.base_from_laser, (0.1, 0.2, 0), atol=1e-6)
    assert "odometry is taken from the transforms" in log.notes


def test_scans_alone_are_a_log_without_odometry(tmp_path: Path) -> None:
    bag = Bag()
    bag.scan(1.0, wall_ranges())
    log = read_log(bag.write(tmp_path / "a"))
    assert not log.has_odometry
    assert "no odometry" in log.notes
    assert "taken to sit in the middle" in log.notes


def test_a_bag_whose_laser_has_another_clock(tmp_path: Path) -> None:
    bag = Bag()
    for k in range(5):
        bag.odom(100.0 + k, (0.1 * k, 0, 0))
        bag.scan(100.0 + k, wall_ranges(), stamp=7.0 + k)
    log = read_log(bag.write(tmp_path / "a"))
    np.testing.assert_allclose(log.odom_from_base[:, 0], 0.1 * np.arange(5), atol=1e-6)
    assert "clocks" in log.notes


def test_stamps_that_were_never_set(tmp_path: Path) -> None:
    bag = Bag()
    for k in range(3):
        bag.scan(100.0 + k, wall_ranges(), stamp=0.0)
    log = read_log(bag.write(tmp_path / "a"))
    np.testing.assert_allclose(log.stamps, [100, 101, 102])


def test_of_several_lasers_the_usual_one_or_the_one_asked_for(tmp_path: Path) -> None:
    bag = drive(Bag())
    for k in range(9):
        bag.scan(100.0 + 0.05 * k, wall_ranges(base=5.0), Laser(topic="/rear"))
    path = bag.write(tmp_path / "a")
    usual, rear = read_log(path), read_log(path, Topics(scan="rear"))
    assert len(usual) == 5
    assert "choose another by --scan-topic: /rear (9)" in usual.notes
    assert len(rear) == 9
    assert usual.sha256 != rear.sha256
    assert {t.name for t in topics(path)} == {"/odom", "/rear", "/scan", "/tf_static"}
    with pytest.raises(InputError, match="no laser topic /front; there is: /rear, /scan"):
        read_log(path, Topics(scan="/front"))
    with pytest.raises(InputError, match="no odometry topic /visual; there is: /odom"):
        read_log(path, Topics(odometry="/visual"))


def test_a_bag_without_a_laser_says_what_it_holds(tmp_path: Path) -> None:
    bag = Bag()
    bag.odom(1.0, (0, 0, 0))
    with pytest.raises(
        InputError, match=r"no laser topic \(LaserScan or MultiEchoLaserScan\); it holds: /odom \(Odometry\)"
    ):
        read_log(bag.write(tmp_path / "a"))


@pytest.mark.parametrize(("version", "storage", "name"), KINDS)
def test_a_damaged_bag_is_refused_or_read_as_far_as_it_goes(
    tmp_path: Path, version: int, storage: str, name: str
) -> None:
    path = drive(Bag(version), scans=40).write(tmp_path / name, storage)
    file = path if path.is_file() else next(p for p in path.iterdir() if p.suffix != ".yaml")
    whole = file.read_bytes()
    rng, told = np.random.default_rng(1), list[str]()
    for n in range(30):
        damaged = bytearray(whole[: int(len(whole) * rng.uniform(0.01, 1))] if n % 2 else whole)
        for at in rng.integers(0, len(damaged), 0 if n % 4 == 1 else 20):
            damaged[at] = rng.integers(0, 256)
        file.write_bytes(bytes(damaged))
        try:
            assert 0 < len(read_log(path)) <= 41
        except InputError as e:
            told.append(str(e))
    assert told
    assert all(str(path) in text and "\n" not in text for text in told)


def test_a_text_that_is_no_bag_in_a_folder_of_one(tmp_path: Path) -> None:
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information: 7\n")
    with pytest.raises(InputError, match="the bag cannot be read"):
        read_log(tmp_path)


def test_metadata_that_does_not_count_the_messages_of_a_topic(tmp_path: Path) -> None:
    folder = drive(Bag()).write(tmp_path / "a", "sqlite3")
    metadata = folder / "metadata.yaml"
    uncounted, lines = re.subn(r"- message_count: \d+", "- message_count: null", metadata.read_text())
    assert lines
    metadata.write_text(uncounted)
    assert len(read_log(folder)) == 5


def test_a_zero_is_a_reading_that_failed_and_no_free_way(tmp_path: Path) -> None:
    """Drivers without inf write it on dark walls, too; REP 117 and the limits of the message leave no other meaning."""
    bag = Bag()
    for k in range(30):
        ranges = wall_ranges()
        ranges[3:9] = 0.0
        bag.scan(100.0 + k, ranges)
    log = read_log(bag.write(tmp_path / "bag"))
    assert np.isnan(log.ranges[:, 3:9]).all()
    assert not np.isinf(log.ranges).any()
    assert "180 readings of 0 m tell nothing" in log.notes
