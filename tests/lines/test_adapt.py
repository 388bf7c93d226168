"""Adaptation: each region gets parameters that suit it, better than any one setting for all, and always the same."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from rgcore.config import Config
from rgcore.geometry.raycast import cast
from rgcore.lines.accuracy import measure_accuracy
from rgcore.lines.adapt import LADDER, LENGTHS, SUPPORTS, adapt
from rgcore.lines.adaptation import PARAMETERS, Adaptation
from rgcore.lines.merge import merge_lines
from rgcore.scans.extract import extract
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

C = Config()
ROOM, WALL = 6.0, 0.2


def box(x: float, y: float, w: float, h: float) -> np.ndarray:
    """A clockwise ring of walls: free space outside, or inside if drawn the other way round."""
    p = np.array([(x, y), (x + w, y), (x + w, y + h), (x, y + h)])
    return np.stack([p, np.roll(p, -1, 0)], 1)


@pytest.fixture(scope="module")
def two_rooms():
    """A bare room whose poses are off by some centimetres, and a cluttered one whose poses are right."""
    rng, bearings = np.random.default_rng(0), np.deg2rad(np.arange(-180.0, 180.0, 2.0))
    boxes = [box(ROOM + WALL + x, y, 0.15, 0.15) for x in (1.2, 2.6, 4.0) for y in (1.5, 3.0, 4.5)]
    world = np.concatenate([box(0, 0, ROOM, ROOM), box(ROOM + WALL, 0, ROOM, ROOM), *boxes])
    n = 80
    where = np.concatenate([rng.uniform(1, ROOM - 1, (n, 2)), rng.uniform(0.6, 0.9, (n, 2)) * [ROOM, 1]])
    where[n:, 0] = ROOM + WALL + rng.uniform(0.5, ROOM - 0.5, n)
    poses = np.column_stack([where, rng.uniform(-3, 3, 2 * n)])
    ranges = cast(world, poses, bearings, 30.0)[0] + rng.normal(0, 0.01, (2 * n, len(bearings)))
    seen = poses + np.repeat([[0.03, 0.03, 0.004], [0.002, 0.002, 0.0]], n, 0) * rng.normal(0, 1, poses.shape)
    zero = np.zeros(3)
    log = ScanLog(np.arange(2 * n, dtype=float), ranges, np.zeros((2 * n, 3)), bearings, zero, 30.0)
    trajectory = Trajectory(log.stamps, seen, zero)
    segments = extract(log, C.extract)
    return log, segments, trajectory, (segments.scan >= n).astype(np.int64)


@pytest.fixture(scope="module")
def fitted(two_rooms) -> Adaptation:
    log, segments, trajectory, region = two_rooms
    found = adapt(log, segments, trajectory, region, 2, C.lines, C.accuracy, C.adapt)
    assert found is not None
    return found


def test_beats_the_best_single_setting_on_both_axes(two_rooms, fitted):
    log, segments, trajectory, region = two_rooms

    def outcome(by_region) -> tuple[int, float]:
        lines, _ = merge_lines(segments, trajectory, region, C.lines, by_region)
        return len(lines), measure_accuracy(log, trajectory, lines.ends, C.accuracy).of(np.ones(len(log), bool))

    best = msgspec.structs.replace(C.lines, **fitted.tried[fitted.map.chosen])
    lines, accuracy = outcome(fitted.settings(C.lines))
    single_lines, single_accuracy = outcome((best,) * 3)
    assert lines <= single_lines
    assert accuracy <= single_accuracy + 1e-9


def test_the_same_again(two_rooms, fitted):
    log, segments, trajectory, region = two_rooms
    assert adapt(log, segments, trajectory, region, 2, C.lines, C.accuracy, C.adapt) == fitted


def test_the_curve_tells_every_setting(fitted):
    tried = len(LADDER) * len(LENGTHS) * len(SUPPORTS)
    assert len(fitted.tried) == len(fitted.map.lines) == len(fitted.map.accuracy) == tried
    assert len(fitted.regions) == 3
    assert fitted.tried[0] == {k: getattr(C.lines, k) for k in PARAMETERS}
    assert all(len(r.lines) == tried and 0 <= r.chosen < tried for r in fitted.regions)
    assert msgspec.json.decode(msgspec.json.encode(fitted), type=Adaptation) == fitted


def test_its_measure_is_that_of_the_map(two_rooms, fitted):
    log, segments, trajectory, region = two_rooms
    lines, _ = merge_lines(segments, trajectory, region, C.lines)
    assert fitted.map.lines[0] == len(lines)
    measured = measure_accuracy(log, trajectory, lines.ends, C.accuracy).of(np.ones(len(log), bool))
    assert fitted.map.accuracy[0] == pytest.approx(measured, rel=0.02)


def test_dearer_lines_are_fewer(two_rooms):
    log, segments, trajectory, region = two_rooms
    count = []
    for price in (0.0, 0.05, 10.0):
        settings = msgspec.structs.replace(C.adapt, price=price)
        found = adapt(log, segments, trajectory, region, 2, C.lines, C.accuracy, settings)
        assert found is not None
        count.append(len(merge_lines(segments, trajectory, region, C.lines, found.settings(C.lines))[0]))
    assert count[0] >= count[1] >= count[2]
    assert count[0] > count[2]


def test_switched_off_and_without_segments_there_is_none(two_rooms):
    log, segments, trajectory, region = two_rooms
    off = msgspec.structs.replace(C.adapt, on=False)
    assert adapt(log, segments, trajectory, region, 2, C.lines, C.accuracy, off) is None
    assert adapt(log, segments[:0], trajectory, region[:0], 2, C.lines, C.accuracy, C.adapt) is None


def test_a_region_that_few_scans_saw_takes_the_single_setting(two_rooms):
    log, segments, trajectory, region = two_rooms
    few = np.where(segments.scan < 5, 2, region)
    found = adapt(log, segments, trajectory, few, 3, C.lines, C.accuracy, C.adapt)
    assert found is not None
    assert found.regions[2].scans == 5
    assert found.regions[2].chosen == found.map.chosen


def test_settings_by_region_hold_there_and_nowhere_else(two_rooms):
    _, segments, trajectory, region = two_rooms
    plain, _ = merge_lines(segments, trajectory, region, C.lines)
    long = msgspec.structs.replace(C.lines, min_length=1.0)
    lines, line_of = merge_lines(segments, trajectory, region, C.lines, (C.lines, long, C.lines))
    lengths = np.hypot(*(lines.ends[:, 1] - lines.ends[:, 0]).T)
    assert (lengths[lines.region == 1] >= 1.0).all()
    assert (lines.region == 0).sum() == (plain.region == 0).sum()
    assert (np.bincount(line_of[line_of >= 0], minlength=len(lines)) == lines.support).all()
    same, _ = merge_lines(segments, trajectory, region, C.lines, (C.lines,) * 3)
    np.testing.assert_allclose(same.ends, plain.ends)
