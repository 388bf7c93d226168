"""Judging a trajectory by known relative poses."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from rgcore.errors import InputError
from rgcore.geometry import se2
from rgcore.slam.relations import Odometry, read_odometry, read_relations, relation_error
from rgcore.slam.trajectory import Trajectory


def trajectory(poses: np.ndarray) -> Trajectory:
    return Trajectory(np.arange(len(poses), dtype=float), poses, np.zeros(3))


CURVE = np.array([[t, 0.1 * t * t, 0.2 * t] for t in range(8)], float)


def write(path: Path, poses: np.ndarray, pairs: list[tuple[int, int]], graph: bool) -> Path:
    lines = ["# true relative poses"]
    for i, j in pairs:
        x, y, a = se2.relative(poses[i], poses[j])
        lines.append(
            f"EDGE2 {i} {j} {x:.9f} {y:.9f} {a:.9f} 1 0 1 1 0 0" if graph else f"{i} {j} {x:.9f} {y:.9f} 0 0 0 {a:.9f}"
        )
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("graph", [False, True])
def test_true_poses_have_no_error_wherever_the_map_lies(tmp_path: Path, graph: bool) -> None:
    relations = read_relations(write(tmp_path / "r", CURVE, [(0, 3), (2, 7), (7, 1)], graph))
    elsewhere = se2.compose(np.array([40.0, -7.0, 2.5]), CURVE)
    error = relation_error(trajectory(elsewhere), relations)
    assert error.matched == error.relations == 3
    assert error.trans_max < 1e-8
    assert error.rot_max < 1e-8


def test_errors_are_those_of_the_relative_pose(tmp_path: Path) -> None:
    relations = read_relations(write(tmp_path / "r", CURVE, [(0, 1), (0, 2)], True))
    bent = CURVE.copy()
    bent[2] = se2.compose(bent[2], np.array([0.3, 0.4, -0.1]))
    error = relation_error(trajectory(bent), relations)
    assert error.trans_mean == pytest.approx(0.25)
    assert error.trans_max == pytest.approx(0.5)
    assert error.rot_mean == pytest.approx(0.05)


def test_a_frame_ahead_of_the_laser(tmp_path: Path) -> None:
    ahead = se2.compose(CURVE, np.array([0.3, 0, 0]))
    relations = read_relations(write(tmp_path / "r", ahead, [(0, 4), (3, 6)], False))
    assert relation_error(trajectory(CURVE), relations, forward=0.3).trans_max < 1e-8
    assert relation_error(trajectory(CURVE), relations).trans_max > 0.01


def test_odometry_bridges_to_poses_between_scans(tmp_path: Path) -> None:
    fine = np.array([[t, 0.1 * t * t, 0.2 * t] for t in np.arange(0, 7.01, 0.5)])
    odometry = Odometry(np.arange(0, 7.01, 0.5), se2.compose(np.array([5, 5, 1.0]), fine))
    (tmp_path / "r").write_text(
        "\n".join("{} {} {} {} 0 0 0 {}".format(0.5, 5.5, *se2.relative(fine[1], fine[11])) for _ in range(2)),
        encoding="utf-8",
    )
    relations = read_relations(tmp_path / "r")
    assert relation_error(trajectory(CURVE), relations).matched == 0
    error = relation_error(trajectory(CURVE), relations, odometry)
    assert error.matched == 2
    assert error.trans_max < 1e-8


def test_only_loops(tmp_path: Path) -> None:
    path = write(tmp_path / "r", CURVE, [(0, 1), (1, 2)], True)
    path.write_text(path.read_text(encoding="utf-8") + "#LOOP EDGES\nEDGE2 0 7 1 2 3 1 0 1 1 0 0\n", encoding="utf-8")
    assert len(read_relations(path)) == 3
    assert read_relations(path, loops_only=True).pair.tolist() == [[0, 7]]


def test_nothing_matched_says_so_without_numbers(tmp_path: Path) -> None:
    relations = read_relations(write(tmp_path / "r", CURVE, [(0, 1)], True))
    assert math.isnan(relation_error(trajectory(CURVE[:1]), relations).trans_mean)


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "no relations"), ("1 2 three\n", ":1"), ("# ok\n0 1 0 0 0 0 0 0\n3 4\n", ":3"), ("\0\1", ":1")],
)
def test_damaged_relations_are_named(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "bad.relations").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"bad\.relations.*"):
        read_relations(tmp_path / "bad.relations")
    with pytest.raises(InputError, match=words):
        read_relations(tmp_path / "bad.relations")


def test_absent_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.relations"):
        read_relations(tmp_path / "none.relations")
    with pytest.raises(InputError, match=r"none\.csv"):
        read_odometry(tmp_path / "none.csv")
