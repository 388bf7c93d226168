"""LRGC as its users see it: true poses from drives with bad odometry, and from logs with hardly anything in them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drives import BEARINGS, LASER, around, chain, error, record, ring

from rgcore.config import Slam
from rgcore.geometry import se2
from rgcore.geometry.raycast import cast
from rgcore.progress import Progress
from rgcore.scans.log import ScanLog
from rgcore.slam.loops import Loops
from rgcore.slam.lrgc import Lrgc, lrgc

TRUE = around(1.3)
LOG = record(ring(), TRUE)


def test_a_loop_with_drifting_odometry_closes() -> None:
    assert error(LOG.odom_from_base, TRUE) > 1.0
    trajectory = lrgc(LOG, Slam())
    assert error(trajectory.map_from_base, TRUE) < 0.03
    assert np.abs(se2.wrap(trajectory.map_from_base[:, 2] - TRUE[:, 2])).max() < 0.02
    assert np.allclose(trajectory.map_from_base[0], LOG.odom_from_base[0])
    assert np.array_equal(trajectory.stamps, LOG.stamps)


def test_a_loop_missed_on_the_way_is_closed_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Loops, "seek", lambda self: None)
    mapper = Lrgc(LOG.bearings, Slam())
    for k in range(len(LOG)):
        mapper.add(LOG.ranges[k], LOG.odom_from_laser[k])
    on_the_way = se2.compose(mapper.poses(), se2.invert(LASER))
    at_the_end = se2.compose(mapper.finish(), se2.invert(LASER))
    assert error(at_the_end, TRUE) < 0.03
    assert error(at_the_end, TRUE) < error(on_the_way, TRUE)
    assert mapper.loops.accepted


def test_every_second_scan_is_enough() -> None:
    assert error(lrgc(LOG[::2], Slam()).map_from_base, TRUE[::2]) < 0.03


def test_odometry_with_the_wrong_sign_is_not_believed() -> None:
    moved = se2.relative(LOG.odom_from_base[:-1], LOG.odom_from_base[1:])
    moved[40:70, :2] *= -1.0
    odometry = [TRUE[0]]
    for m in moved:
        odometry.append(se2.compose(odometry[-1], m))
    assert error(lrgc(replace(LOG, odom_from_base=np.array(odometry)), Slam()).map_from_base, TRUE) < 0.05


def test_without_odometry() -> None:
    blind = replace(LOG, odom_from_base=np.zeros_like(LOG.odom_from_base), has_odometry=False)
    trajectory = lrgc(blind, Slam())
    assert error(se2.compose(TRUE[0], trajectory.map_from_base), TRUE) < 0.05


def test_stamps_play_no_part() -> None:
    same = lrgc(replace(LOG, stamps=np.zeros(len(LOG))), Slam())
    assert np.array_equal(same.map_from_base, lrgc(LOG, Slam()).map_from_base)


def test_a_third_of_the_beams_missing() -> None:
    ranges = np.array(LOG.ranges)
    ranges[np.random.default_rng(1).random(ranges.shape) < 0.3] = np.nan
    assert error(lrgc(replace(LOG, ranges=ranges), Slam()).map_from_base, TRUE) < 0.05


def test_standing_still() -> None:
    poses = np.repeat(TRUE[:1], 60, 0)
    trajectory = lrgc(record(ring(), poses), Slam())
    assert np.abs(trajectory.map_from_base - poses).max() < 0.005


def test_one_scan() -> None:
    trajectory = lrgc(LOG[:1], Slam())
    assert np.allclose(trajectory.map_from_base, LOG.odom_from_base[:1])


@pytest.mark.parametrize("nothing", [np.inf, np.nan])
def test_no_echo_at_all_leaves_the_odometry(nothing: float) -> None:
    log = replace(LOG, ranges=np.full_like(LOG.ranges, nothing))
    trajectory = lrgc(log, Slam())
    assert np.allclose(trajectory.map_from_base[:, :2], LOG.odom_from_base[:, :2], atol=1e-6)


def test_a_stretch_without_echoes_is_bridged() -> None:
    ranges = np.array(LOG.ranges)
    ranges[30:36] = np.inf
    assert error(lrgc(replace(LOG, ranges=ranges), Slam()).map_from_base, TRUE) < 0.1


def test_a_featureless_corridor_keeps_the_length_that_odometry_tells() -> None:
    walls = chain((-100, 0), (100, 0))
    walls = np.concatenate([walls, walls[:, ::-1] + [0, 2.2]])
    true = np.column_stack([np.arange(0, 20, 0.2), np.full(100, 1.0), np.zeros(100)])
    log = record(walls, true, drift=0.0)
    poses = lrgc(log, Slam()).map_from_base
    assert abs(poses[-1, 0] - true[-1, 0]) < 0.3
    assert np.abs(poses[:, 1] - true[:, 1]).max() < 0.03


def test_carried_elsewhere_is_told_and_bends_nothing() -> None:
    """The robot is lifted out of the ring into another room, and its odometry knows nothing of that."""
    room = chain((30, 0), (36, 0), (36, 1.5), (34.8, 1.5), (34.8, 5), (30, 5), (30, 0))
    true = np.concatenate([TRUE[:60], np.column_stack([np.arange(31, 34, 0.2), np.full(15, 2.5), np.full(15, 0.3)])])
    ranges, _ = cast(np.concatenate([ring(), room]), se2.compose(true, LASER), BEARINGS, 30.0)
    odometry = np.concatenate([LOG.odom_from_base[:60], LOG.odom_from_base[60:75]])
    log = ScanLog(np.arange(75.0), ranges, odometry, BEARINGS, LASER, 30.0)
    mapper = Lrgc(log.bearings, Slam())
    for k in range(len(log)):
        mapper.add(log.ranges[k], log.odom_from_laser[k])
    assert 60 in mapper.breaks
    base = se2.compose(mapper.finish(), se2.invert(LASER))
    assert error(base[:60], TRUE[:60]) < 0.05
    after = se2.relative(base[61], base[61:])
    assert np.hypot(*(after - se2.relative(true[61], true[61:]))[:, :2].T).max() < 0.1


def test_two_rooms_that_look_alike_stay_two() -> None:
    """Along a corridor with twin rooms on one side; in the second the first one fits perfectly."""
    walls = [chain((-2, -1), (24, -1), (24, 1), (17, 1)), chain((15, 1), (7, 1)), chain((5, 1), (-2, 1), (-2, -1))]
    for x in (6.0, 16.0):
        walls.append(
            chain(
                (x - 1, 1), (x - 2, 1), (x - 2, 5), (x - 0.5, 5), (x - 0.5, 4.4), (x + 2, 4.4), (x + 2, 1), (x + 1, 1)
            )
        )
    lane = [
        np.column_stack([np.arange(a, b, 0.2), np.zeros(round((b - a) / 0.2)), np.zeros(round((b - a) / 0.2))])
        for a, b in ((0, 6), (6, 16))
    ]
    turns = np.pi / 2 * np.linspace(0, 1, 6)
    up = np.column_stack([np.zeros(15), np.arange(0, 3, 0.2), np.full(15, np.pi / 2)])
    visit = np.concatenate(
        [
            np.column_stack([0 * turns, 0 * turns, turns]),
            up,
            up[::-1],
            np.column_stack([0 * turns, 0 * turns, turns[::-1]]),
        ]
    )
    true = np.concatenate([lane[0], visit + np.array([6.0, 0, 0]), lane[1], visit + np.array([16.0, 0, 0])])
    assert error(lrgc(record(np.concatenate(walls), true, seed=3), Slam()).map_from_base, true) < 0.15


def test_the_work_of_a_scan_does_not_grow_with_the_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    """It goes by the keyframes of the local map, and by the searches for closures."""
    true, members = around(4), []
    renew = Lrgc._renew_map
    monkeypatch.setattr(Lrgc, "_renew_map", lambda self: (renew(self), members.append(len(self._members))))
    log, mapper, tried = record(ring(), true, seed=1), Lrgc(BEARINGS, Slam()), []
    for k in range(len(log)):
        mapper.add(log.ranges[k], log.odom_from_laser[k])
        tried.append(mapper.loops.tried)
    assert max(members) <= 2 * Slam().local_keyframes
    half = len(log) // 2
    assert tried[-1] - tried[half] <= tried[half]
    mapper.finish()
    assert mapper.loops.tried - tried[-1] <= tried[half]


def test_one_scan_at_a_time_is_the_same_as_a_log() -> None:
    mapper = Lrgc(LOG.bearings, Slam())
    for k in range(len(LOG)):
        pose = mapper.add(LOG.ranges[k], LOG.odom_from_laser[k])
        assert np.hypot(*(pose - se2.compose(TRUE[k], LASER))[:2]) < 1.0
    assert mapper.poses().shape == (len(LOG), 3)
    final = se2.compose(mapper.finish(), se2.invert(LASER))
    assert np.allclose(final, lrgc(LOG, Slam()).map_from_base)


def test_the_watcher_sees_the_map_grow() -> None:
    seen: list[Progress] = []
    lrgc(LOG[:120], Slam(), seen.append)
    assert [p.done for p in seen] == [50, 100]
    assert all(p.stage == "slam" and p.total == 120 and p.partial.shape == (p.done, 3) for p in seen)
