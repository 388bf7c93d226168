"""CARMEN logs and their quirks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rgcore.errors import InputError
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log

Pose = tuple[float, float, float]


def flaser(ranges: list[float], laser: Pose, robot: Pose, stamp: float) -> str:
    return " ".join(map(str, ["FLASER", len(ranges), *ranges, *laser, *robot, stamp, "robot", stamp])) + "\n"


def raw(word: str, ranges: list[float], fan: tuple[float, float, float, float], remissions: list[float] | None) -> str:
    tail = [] if remissions is None else [len(remissions), *remissions]
    return " ".join(map(str, [word, 0, *fan, 0.01, 0, len(ranges), *ranges, *tail]))


def robotlaser(
    ranges: list[float],
    fan: tuple[float, float, float, float],
    laser: Pose,
    robot: Pose,
    stamp: float,
    remissions: list[float] | None = None,
) -> str:
    motion = [0.1, 0.0, 0.5, 0.5] if remissions is None else [0.1, 0.0, 0.5, 0.5, 0.0]
    rest = [*laser, *robot, *motion, stamp, "robot", stamp]
    return raw("ROBOTLASER1", ranges, fan, remissions) + " " + " ".join(map(str, rest)) + "\n"


def odom(pose: Pose, stamp: float) -> str:
    return f"ODOM {pose[0]} {pose[1]} {pose[2]} 0 0 0 {stamp} robot {stamp}\n"


def read(folder: Path, *lines: str) -> ScanLog:
    path = folder / "office.log"
    path.write_text("".join(lines))
    return read_log(path)


SOME = [1.0, 2.0, 3.0, 2.5, 1.5]
AT: list[Pose] = [(0.0, 0.0, 0.0), (1.0, 0.0, 1.0), (2.0, 1.0, 2.0), (2.0, 3.0, -2.0)]


@pytest.mark.parametrize(
    ("beams", "first", "last"),
    [(180, -90, 89), (181, -90, 90), (360, -90, 89.5), (361, -90, 90), (541, -90, 90), (90, -90, 88), (401, -50, 50)],
)
def test_flaser_angles_follow_from_the_number_of_beams(tmp_path: Path, beams: int, first: float, last: float) -> None:
    log = read(tmp_path, flaser([1.0] * beams, AT[0], AT[0], 1.0))
    assert np.degrees(log.bearings[[0, -1]]) == pytest.approx([first, last])
    assert np.ptp(np.diff(log.bearings)) < 1e-12


def test_equal_poses_mean_a_laser_in_the_robots_centre(tmp_path: Path) -> None:
    log = read(tmp_path, "PARAM robot_frontlaser_offset 0.3 robot 0\n", *(flaser(SOME, p, p, 1.0) for p in AT))
    assert log.base_from_laser.tolist() == [0, 0, 0]
    np.testing.assert_allclose(log.odom_from_base, AT)
    assert log.has_odometry


def test_constant_offset_between_the_poses_is_the_mounting(tmp_path: Path) -> None:
    ahead = [(x + 0.2 * np.cos(t), y + 0.2 * np.sin(t), t) for x, y, t in AT]
    log = read(tmp_path, *(flaser(SOME, a, p, 1.0) for a, p in zip(ahead, AT, strict=True)))
    np.testing.assert_allclose(log.base_from_laser, [0.2, 0, 0], atol=1e-9)
    np.testing.assert_allclose(log.odom_from_base, AT)
    np.testing.assert_allclose(log.odom_from_laser, ahead, atol=1e-9)


def test_poses_that_drift_apart_are_corrected_ones_and_odometry_is_used(tmp_path: Path) -> None:
    corrected = [(x * 1.3, y + 0.2 * i, t - 0.1 * i) for i, (x, y, t) in enumerate(AT)]
    lines = [flaser(SOME, c, p, 1.0) for c, p in zip(corrected, AT, strict=True)]
    log = read(tmp_path, "PARAM robot_frontlaser_offset 0.3 robot 0\n", *lines)
    np.testing.assert_allclose(log.odom_from_base, AT)
    np.testing.assert_allclose(log.base_from_laser, [0.3, 0, 0])
    assert "corrected" in log.notes


def test_unwrapped_angles_are_wrapped(tmp_path: Path) -> None:
    log = read(
        tmp_path, flaser(SOME, (0, 0, -12.9), (0, 0, -12.9), 1.0), flaser(SOME, (0, 0, -13.0), (0, 0, -13.0), 2.0)
    )
    assert log.odom_from_base[:, 2] == pytest.approx([-12.9 + 4 * np.pi, -13.0 + 4 * np.pi])


def test_a_log_without_odometry_says_so(tmp_path: Path) -> None:
    log = read(tmp_path, *(flaser(SOME, (0, 0, 0), (0, 0, 0), t) for t in (1.0, 2.0)))
    assert not log.has_odometry
    assert "no odometry" in log.notes
    assert (log.odom_from_base == 0).all()


def test_zero_poses_beside_odom_lines_take_those(tmp_path: Path) -> None:
    lines = [odom((0, 0, 0), 0.0), *(flaser(SOME, (0, 0, 0), (0, 0, 0), t) for t in (1.0, 3.0)), odom((4, 0, 0.4), 4.0)]
    log = read(tmp_path, *lines)
    assert log.has_odometry
    np.testing.assert_allclose(log.odom_from_base, [[1, 0, 0.1], [3, 0, 0.3]])


def test_stamps_keep_the_files_order(tmp_path: Path) -> None:
    stamps = [5.0, 5.0, 3.0, 6.0]
    log = read(tmp_path, *(flaser(SOME, p, p, t) for p, t in zip(AT, stamps, strict=True)))
    assert log.stamps.tolist() == stamps
    assert "stamps run backwards 1 times" in log.notes


@pytest.mark.parametrize("remissions", [None, [], [0.5] * 5])
def test_robotlaser_carries_its_own_angles(tmp_path: Path, remissions: list[float] | None) -> None:
    fan = (-1.0, 2.0, 0.5, 20.0)
    ranges = [1.0, 2.0, 20.0, 2.5, 1.5]
    lines = [robotlaser(ranges, fan, (x + 1, y, t), (x + 1, y, t), 7.5 + x, remissions) for x, y, t in AT[:2]]
    log = read(tmp_path, *lines)
    np.testing.assert_allclose(log.bearings, [-1, -0.5, 0, 0.5, 1])
    assert log.stamps.tolist() == [7.5, 8.5]
    assert np.isinf(log.ranges[:, 2]).all()
    assert log.max_range == 2.5
    np.testing.assert_allclose(log.odom_from_base[:, 0], [1, 2])


def test_a_laser_that_counts_clockwise_is_turned_round(tmp_path: Path) -> None:
    lines = [robotlaser([1.0, 2.0, 3.0], (1.0, 2.0, -1.0, 50.0), p, p, 1.0) for p in AT]
    log = read(tmp_path, *lines)
    np.testing.assert_allclose(log.bearings, [-1, 0, 1])
    assert log.ranges[0].tolist() == [3.0, 2.0, 1.0]


def test_robotlaser_is_preferred_to_the_same_scans_as_rawlaser(tmp_path: Path) -> None:
    fan = (-1.0, 2.0, 0.5, 20.0)
    both = [raw("RAWLASER1", SOME, fan, []) + " 1.0 robot 1.0\n", robotlaser(SOME, fan, AT[1], AT[1], 1.0, [])]
    log = read(tmp_path, *both, *both, both[0])
    assert len(log) == 2
    assert "3 RAWLASER1 lines not used" in log.notes


def test_rawlaser_takes_poses_from_odometry_by_time_and_the_offset_from_param(tmp_path: Path) -> None:
    fan = (-1.0, 2.0, 0.5, 20.0)
    log = read(
        tmp_path,
        "PARAM robot_frontlaser_offset 0.27 robot 0\n",
        odom((0, 0, 3.0), 10.0),
        raw("RAWLASER1", SOME, fan, []) + " 10.5 robot 10.5\n",
        odom((1, 2, -3.0), 11.0),
        raw("RAWLASER1", SOME, fan, []) + " 12.0 robot 12.0\n",
    )
    np.testing.assert_allclose(log.odom_from_base, [[0.5, 1, np.pi], [1, 2, -3.0]], atol=1e-9)
    np.testing.assert_allclose(log.base_from_laser, [0.27, 0, 0])


def test_rawlaser_goes_by_the_order_of_lines_where_the_clocks_differ(tmp_path: Path) -> None:
    fan = (-1.0, 2.0, 0.5, 20.0)
    scan = raw("RAWLASER1", SOME, fan, []) + " 976052915.6 robot 1.0\n"
    log = read(tmp_path, odom((0, 0, 0), 1.0), scan, odom((1, 0, 0), 2.0), scan, odom((3, 0, 0), 3.0))
    np.testing.assert_allclose(log.odom_from_base[:, 0], [0.5, 2.0])


def test_scans_of_another_number_of_beams_stay_rows(tmp_path: Path) -> None:
    fine = [1.0 + 0.001 * i for i in range(361)]
    coarse = [2.0 + 0.001 * i for i in range(181)]
    lines = [flaser(coarse, p, p, 1.0) for p in AT]
    log = read(tmp_path, *lines, flaser(fine, AT[0], AT[0], 2.0), flaser([5.0] * 90, AT[0], AT[0], 3.0))
    assert log.ranges.shape == (6, 181)
    np.testing.assert_allclose(log.ranges[4], fine[::2])
    assert np.isnan(log.ranges[5]).sum() <= 2
    assert "2 scans of another number of beams" in log.notes


def test_other_lines_are_counted(tmp_path: Path) -> None:
    text = "# comment\nSYNC start\nNEFF 12\nNEFF 13\nwhatever this is\n\n"
    log = read(tmp_path, text, flaser(SOME, AT[1], AT[1], 1.0))
    assert "2 NEFF, 1 SYNC, 1 whatever lines not used" in log.notes


def test_a_reading_that_is_no_number_of_metres(tmp_path: Path) -> None:
    log = read(tmp_path, flaser([1.0, float("nan"), -3.0, 1e30, 2.0], AT[1], AT[1], 1.0))
    assert np.isnan(log.ranges[0]).tolist() == [False, True, True, True, False]


@pytest.mark.parametrize(
    "damage",
    [
        lambda line: line[:40] + "\n",
        lambda line: line.replace(" 5 ", " 7 ", 1),
        lambda line: line.replace(" 5 ", " 3 ", 1),
        lambda line: line.replace("2.5", "2.5.1", 1),
        lambda line: line.replace(" 5 ", " five ", 1),
        lambda line: line.replace(" 0.75 ", " nan ", 1),
        lambda line: line.strip() + " " + line,
    ],
)
def test_a_damaged_line_is_an_error_with_file_and_line(tmp_path: Path, damage) -> None:  # type: ignore[no-untyped-def]
    line = flaser(SOME, (0.75, 0.1, 0.1), (0.75, 0.1, 0.1), 1.0)
    with pytest.raises(InputError, match=r"office\.log:3: damaged laser line: .*; repair or delete the line"):
        read(tmp_path, "# comment\n", line, damage(line), line)


def test_a_last_line_that_was_cut_off_is_left_out(tmp_path: Path) -> None:
    line = flaser(SOME, (0.75, 0.1, 0.1), (0.75, 0.1, 0.1), 976052915.25)
    for end in (20, 45, line.index("976052915") + 5, line.index("robot") + 2):
        log = read(tmp_path, line, line, line[:end])
        assert len(log) == 2
        assert "the last line (3) is cut off" in log.notes
    assert len(read(tmp_path, line, line, line.rstrip())) == 3
