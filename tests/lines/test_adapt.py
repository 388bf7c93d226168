"""Adaptation: each region gets parameters that suit it, better than any one setting for all, and always the same."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from rgcore.config import Config
from rgcore.geometry.raycast import cast
from rgcore.lines.accuracy import measure_accuracy
from rgcore.lines.adapt import LADDER, PRICES, adapt
from rgcore.lines.adaptation import PARAMETERS, Adaptation
from rgcore.lines.complete import complete_lines
from rgcore.lines.merge import Lines, merge_lines
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


def region_at(points: np.ndarray) -> np.ndarray:
    return (points[:, 0] > ROOM + WALL / 2).astype(np.int64)


def adapted(two_rooms, regions=2, region=None, **changed) -> Adaptation | None:
    log, segments, trajectory, own = two_rooms
    settings = msgspec.structs.replace(C.adapt, **{k: v for k, v in changed.items() if k != "price"})
    lines = msgspec.structs.replace(C.lines, price=changed.get("price", C.lines.price))
    where = own if region is None else region
    return adapt(log, segments, trajectory, where, regions, region_at, lines, C.accuracy, settings)


def finished(two_rooms, by_region, price=C.lines.price) -> Lines:
    log, segments, trajectory, region = two_rooms
    s = msgspec.structs.replace(C.lines, price=price, reduction=1.0)
    merged = merge_lines(segments, trajectory, region, s, by_region)
    return complete_lines(*merged, log, segments, trajectory, region_at, s, by_region)[0]


@pytest.fixture(scope="module")
def fitted(two_rooms) -> Adaptation:
    found = adapted(two_rooms)
    assert found is not None
    return found


def test_the_finished_map_beats_the_best_single_setting_on_both_axes(two_rooms, fitted):
    log, _, trajectory, _ = two_rooms

    def outcome(by_region) -> tuple[int, float]:
        lines = finished(two_rooms, by_region)
        return len(lines), measure_accuracy(log, trajectory, lines.ends, C.accuracy).of(np.ones(len(log), bool))

    best = msgspec.structs.replace(C.lines, **fitted.tried[fitted.map.chosen])
    lines, accuracy = outcome(fitted.settings(C.lines))
    single_lines, single_accuracy = outcome((best,) * 3)
    assert lines <= single_lines
    assert accuracy <= single_accuracy + 1e-9


def test_the_same_again(two_rooms, fitted):
    assert adapted(two_rooms) == fitted


def test_the_curve_tells_every_setting(fitted):
    tried = len(LADDER) + len(PRICES)
    assert len(fitted.tried) == len(fitted.map.lines) == len(fitted.map.accuracy) == tried
    assert len(fitted.regions) == 3
    assert fitted.tried[0] == {k: getattr(C.lines, k) for k in PARAMETERS}
    assert all(len(r.lines) == tried and 0 <= r.chosen < tried for r in fitted.regions)
    assert msgspec.json.decode(msgspec.json.encode(fitted), type=Adaptation) == fitted


def test_its_measure_is_that_of_the_finished_map(two_rooms, fitted):
    log, _, trajectory, _ = two_rooms
    lines = finished(two_rooms, ())
    assert fitted.map.lines[0] == pytest.approx(len(lines), rel=0.05)
    measured = measure_accuracy(log, trajectory, lines.ends, C.accuracy).of(np.ones(len(log), bool))
    assert fitted.map.accuracy[0] == pytest.approx(measured, rel=0.1)


def test_dearer_lines_are_fewer(two_rooms):
    count = []
    for price in (1.0, 22.0, 400.0):
        found = adapted(two_rooms, price=price)
        assert found is not None
        lines = msgspec.structs.replace(C.lines, price=price)
        count.append(len(finished(two_rooms, found.settings(lines), price)))
    assert count[0] >= count[1] >= count[2]
    assert count[0] > count[2]


def test_a_region_that_misses_the_goal_pays_less_for_its_lines(two_rooms):
    dear = 300.0
    rich, poor = adapted(two_rooms, price=dear, goal=10.0), adapted(two_rooms, price=dear, goal=0.2)
    assert rich is not None
    assert poor is not None
    assert all(rich.tried[r.chosen]["price"] == dear for r in rich.regions)
    paid = [r for r in poor.regions if poor.tried[r.chosen]["price"] < dear]
    assert len(paid) == 1
    lines = msgspec.structs.replace(C.lines, price=dear)
    more, fewer = (finished(two_rooms, a.settings(lines), dear) for a in (poor, rich))
    assert len(more) > len(fewer)


def test_switched_off_and_without_segments_there_is_none(two_rooms):
    log, segments, trajectory, region = two_rooms
    assert adapted(two_rooms, on=False) is None
    assert adapted((log, segments[:0], trajectory, region[:0])) is None


def test_a_region_that_few_scans_saw_takes_the_single_setting(two_rooms):
    _, segments, _, region = two_rooms
    found = adapted(two_rooms, 3, np.where(segments.scan < 5, 2, region))
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
