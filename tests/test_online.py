"""Mapping online: the demo building scan by scan, against the batch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rgcore import pipeline
from rgcore.config import Config
from rgcore.exports.formats import render
from rgcore.online import Mapper, Step
from rgcore.places.automaton import GatewayEntered, RegionFound, RegionRecognised
from rgcore.places.freespace import free_space
from rgcore.places.growing import GrowingSpace
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log
from rgcore.slam.trajectory import Trajectory
from rgviz.demo import LOG

SCANS = 450


def feed(mapper: Mapper, log: ScanLog) -> list[Step]:
    return [mapper.add(log.ranges[k], log.odom_from_base[k], log.stamps[k]) for k in range(len(log))]


@pytest.fixture(scope="module")
def log() -> ScanLog:
    return read_log(LOG)[:SCANS]


@pytest.fixture(scope="module")
def mapped(log: ScanLog) -> tuple[Mapper, list[Step]]:
    mapper = Mapper.of(log)
    return mapper, feed(mapper, log)


@pytest.fixture(scope="module")
def batch(log: ScanLog) -> pipeline.Run:
    return pipeline.run(log)


@pytest.fixture(scope="module")
def finished(mapped: tuple[Mapper, list[Step]], log: ScanLog) -> pipeline.Run:
    return mapped[0].finish(log)


def test_the_map_is_that_of_the_batch_to_the_byte(finished: pipeline.Run, batch: pipeline.Run) -> None:
    assert np.array_equal(finished.trajectory.map_from_base, batch.trajectory.map_from_base)
    assert render(".json", finished.map, None) == render(".json", batch.map, None)


def test_the_region_told_is_mostly_that_of_the_finished_map(
    mapped: tuple[Mapper, list[Step]], finished: pipeline.Run
) -> None:
    mapper, steps = mapped
    true = finished.places.labels.at(finished.trajectory.map_from_base[:, :2], outside=-1)
    told = [mapper.final.get(s.region or "") for s in steps]
    right = [t == f"r{i + 1}" for t, i in zip(told, true, strict=True) if i >= 0]
    assert np.mean(right) > 0.75
    settled = [mapper.final.get(r or "") for r in mapper.settled()]
    right = [t == f"r{i + 1}" for t, i in zip(settled, true, strict=True) if i >= 0]
    assert np.mean(right) > 0.97


def test_steps_tell_poses_states_and_what_happens(mapped: tuple[Mapper, list[Step]], log: ScanLog) -> None:
    steps = mapped[1]
    assert [s.scan for s in steps] == list(range(len(log)))
    assert isinstance(steps[0].events[0], RegionFound)
    events = [e for s in steps for e in s.events]
    assert any(isinstance(e, GatewayEntered) for e in events)
    assert any(isinstance(e, RegionRecognised) for e in events)
    assert {s.state for s in steps} > {"in-unclassified"}
    assert all((s.region is None) == (s.state == "entering-unknown") for s in steps)
    assert all(e.scan == s.scan for s in steps for e in s.events)
    jumps = np.hypot(*np.diff([s.pose[:2] for s in steps], axis=0).T)
    assert np.quantile(jumps, 0.95) < 0.5


def test_the_same_log_tells_the_same(log: ScanLog) -> None:
    assert feed(Mapper.of(log), log[:100]) == feed(Mapper.of(log), log[:100])


def test_a_map_is_there_at_any_time(log: ScanLog) -> None:
    mapper = Mapper.of(log)
    assert mapper.snapshot().points.shape == (0, 2)
    feed(mapper, log[:200])
    shot = mapper.snapshot()
    assert shot.poses.shape == (200, 3)
    assert len(shot.points) > 1000
    ids = {r.id for r in shot.regions}
    assert ids
    assert all(len(r.boundary) >= 3 for r in shot.regions)
    assert all(set(g.regions) <= ids for g in shot.gateways)
    map_ = mapper.map()
    assert len(map_.lines) > 20
    assert set(map_.regions) & {r.id for r in mapper.regions()}
    assert all(set(g.regions) <= set(map_.regions) for g in map_.gateways.values())


def test_poses_alone_and_without_odometry(log: ScanLog) -> None:
    mapper = Mapper(log.bearings, log.base_from_laser, has_odometry=False, places=False)
    steps = [mapper.add(r, None, t) for r, t in zip(log.ranges[:120], log.stamps, strict=False)]
    blind = pipeline.lrgc(replace(log[:120], has_odometry=False, odom_from_base=np.zeros((120, 3))), Config().slam)
    assert not any(s.events for s in steps)
    assert np.hypot(*(blind.map_from_base[-1] - np.array(steps[-1].pose))[:2]) < 0.1


def test_a_scan_without_echoes_is_no_harm(log: ScanLog) -> None:
    mapper = Mapper.of(log)
    feed(mapper, log[:20])
    step = mapper.add(np.full(len(log.bearings), np.nan), log.odom_from_base[20], log.stamps[20])
    assert step.region == "r1"
    assert step.events == ()


def test_the_growing_raster_counts_as_the_batch_does_wherever_scans_were_before(log: ScanLog) -> None:
    some, settings = log[:60], Config().places
    trajectory = Trajectory(some.stamps, some.odom_from_base, some.base_from_laser)
    poses, away = trajectory.map_from_laser, np.array([3.0, -2.0, 0.4])
    space = GrowingSpace(some.bearings, some.max_range, settings)
    for k in range(60):
        space.add(some.ranges[k : k + 1], poses[k : k + 1] + (away if k % 2 else 0.0))
    space.move(some.ranges[1::2], poses[1::2] + away, poses[1::2])
    mine, true = space.free_space(), free_space(some, trajectory, settings)
    x, y = np.round((np.asarray(true.origin) - mine.origin) / true.resolution).astype(int)
    h, w = true.hits.shape
    for here, there in ((mine.hits, true.hits), (mine.passes, true.passes)):
        off = here[y : y + h, x : x + w] - there
        assert np.abs(off).sum() < 1e-4 * there.sum()  # a beam through the corner of a cell may be rounded either way
        assert abs(here.sum() - there.sum()) < 1e-4 * there.sum()
