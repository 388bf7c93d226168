"""Merged lines judged by scans of a room in which somebody walks, a door is opened and a table stands."""

from __future__ import annotations

import numpy as np
import pytest

from rgcore.config import Extract
from rgcore.config import Lines as Settings
from rgcore.geometry import segments as geometry
from rgcore.geometry.raycast import cast
from rgcore.lines.complete import complete_lines
from rgcore.lines.merge import Lines, merge_lines
from rgcore.scans.extract import extract
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

BEARINGS = np.deg2rad(np.arange(-90.0, 91.0))
ROOM = np.array([[[-5, -3], [5, -3]], [[5, -3], [5, 3]], [[5, 3], [-5, 3]], [[-5, 3], [-5, -3]]], float)


def box(x: float, y: float, size: float) -> np.ndarray:
    corners = np.array([[x, y], [x, y + size], [x + size, y + size], [x + size, y]])
    return np.stack([corners, np.roll(corners, -1, 0)], 1)


def mapped(worlds: list[np.ndarray]) -> tuple[Lines, np.ndarray, int]:
    """What is found where each world is seen in one scan from a pose of its own."""
    rng, n = np.random.default_rng(2), len(worlds)
    poses = np.stack([np.linspace(-3, 3, n), np.full(n, -1.0), np.arange(n) * np.pi / 2 % (2 * np.pi)], 1)
    ranges = np.concatenate([cast(w, p[None], BEARINGS, 80.0)[0] for w, p in zip(worlds, poses, strict=True)])
    log = ScanLog(np.arange(n), ranges + rng.normal(0, 0.012, ranges.shape), poses, BEARINGS, np.zeros(3), 80.0)
    trajectory = Trajectory(log.stamps, poses, np.zeros(3))
    segments = extract(log, Extract())
    merged = merge_lines(segments, trajectory, np.zeros(len(segments), np.int64), Settings())
    s = Settings(reduction=1.0)
    lines, line_of = complete_lines(*merged, log, segments, trajectory, lambda at: np.zeros(len(at), np.int64), s)
    return lines, line_of, len(segments)


def inside(lines: Lines) -> np.ndarray:
    """The lines (K, 2, 2) that are no walls of the room."""
    x, y = np.abs(lines.ends.mean(1)).T
    return lines.ends[(x < 4.9) & (y < 2.9)]


def test_who_walks_through_leaves_nothing() -> None:
    ways = np.linspace(-4, 4, 80)
    lines, _, _ = mapped([np.concatenate([ROOM, box(x, 1.0, 0.4)]) for x in ways])
    assert len(inside(lines)) == 0
    assert len(lines) == 4


def test_legs_of_a_table_are_found_where_they_stand() -> None:
    legs = [(1.0, 1.0), (2.2, 1.0), (1.0, 1.8), (2.2, 1.8)]
    lines, _, _ = mapped([np.concatenate([ROOM, *(box(x, y, 0.05) for x, y in legs)])] * 80)
    found = inside(lines)
    assert 4 <= len(found) <= 12
    for x, y in legs:
        assert np.hypot(*(found.mean(1) - [x + 0.025, y + 0.025]).T).min() < 0.05
    assert geometry.lengths(found).max() < 0.15


def test_what_stood_there_for_a_while_goes_and_what_came_to_stay_stays() -> None:
    gone, came = np.concatenate([ROOM, box(0.0, 1.0, 0.6)]), np.concatenate([ROOM, box(-2.0, 1.0, 0.6)])
    found = inside(mapped([gone] * 10 + [came] * 70)[0])
    assert len(found) >= 2
    assert (np.abs(found.mean(1)[:, 0] + 1.7) < 0.5).all()


def test_every_segment_keeps_its_line_and_every_line_its_evidence() -> None:
    lines, line_of, count = mapped([np.concatenate([ROOM, box(1.0, 1.0, 0.05)])] * 40)
    assert line_of.shape == (count,)
    assert line_of.max() < len(lines)
    assert (lines.support >= 1).all()
    assert np.isfinite(lines.rms).all()
    assert lines.region.tolist() == [0] * len(lines)
    assert (np.diff(lines.first_scan) >= 0).all()
    walls = geometry.lengths(lines.ends) > 3
    assert np.bincount(line_of[line_of >= 0], minlength=len(lines))[walls] == pytest.approx(lines.support[walls])


def test_nothing_gives_nothing() -> None:
    lines, line_of, _ = mapped([np.array([[[90.0, 0.0], [90.0, 1.0]]])] * 3)
    assert (len(lines), len(line_of)) == (0, 0)
