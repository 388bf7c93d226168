"""Lines that are as sure as they say, against walls that are known."""

from __future__ import annotations

import numpy as np
import pytest
from walls import driven, normalized

from rgcore import pipeline
from rgcore.config import Config
from rgcore.geometry import segments as geometry
from rgcore.geometry.raycast import cast
from rgcore.lines.covariance import fitted, line_covariance, turned
from rgcore.lines.merge import Lines, merge_lines
from rgcore.scans.extract import Segments, extract
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

CONFIG = Config()
BEARINGS = np.deg2rad(np.arange(-90.0, 91.0))


def rooms(count: int = 12, size: float = 5.0) -> np.ndarray:
    """Rooms in a row, each turned its own way, without doors: their walls run counter-clockwise."""
    out = []
    for k in range(count):
        a = 0.3 * k + np.array([0, 1, 2, 3]) * np.pi / 2
        corners = np.column_stack([12 * k + (1 + 0.1 * k) * size / 2 * np.cos(a), size / 2 * np.sin(a)])
        out += [[corners[i], corners[(i + 1) % 4]] for i in range(4)]
    return np.array(out)


def drive(sigma: float, across: float, heading: float, reach: float) -> tuple[Segments, Trajectory, np.ndarray]:
    """Segments of a drive from room to room, poses that err by a process alike over ``reach`` [m], the true walls."""
    chance, world = np.random.default_rng(4), rooms()
    t = np.linspace(0, 2 * np.pi, 60)
    ring = np.column_stack([0.9 * np.cos(t), 0.9 * np.sin(t), 2 * t])
    true = np.concatenate([ring + np.array([12 * k, 0, 0]) for k in range(12)])
    ranges = cast(world, true, BEARINGS, 30.0)[0] + chance.normal(0, sigma, (len(true), len(BEARINGS)))
    log = ScanLog(np.arange(len(true)), ranges, true, BEARINGS, np.zeros(3), 30.0)
    error, step = np.zeros((len(true), 3)), np.hypot(*np.diff(true[:, :2], axis=0).T)
    error[0] = chance.normal(0, 1, 3)
    for k, alike in enumerate(np.exp(-(step + np.abs(np.diff(true[:, 2]))) / reach)):
        error[k + 1] = alike * error[k] + np.sqrt(1 - alike**2) * chance.normal(0, 1, 3)
    return (
        extract(log, CONFIG.extract),
        Trajectory(log.stamps, true + error * [across, across, heading], np.zeros(3)),
        world,
    )


def settled(
    segments: Segments, trajectory: Trajectory
) -> tuple[Lines, np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray, Segments, Trajectory]]:
    """Merged lines, their ends on the robust fit, its covariance, and what :func:`line_covariance` takes."""
    lines, line_of = merge_lines(segments, trajectory, np.zeros(len(segments), np.int64), CONFIG.lines)
    correction, covariance = fitted(lines.ends, line_of, segments, trajectory)
    return lines, turned(lines.ends, correction), covariance, (lines.ends, line_of, segments, trajectory)


def errors(ends: np.ndarray, world: np.ndarray) -> np.ndarray:
    """(L, 2) offset of the lines' middles from the nearest wall [m] and turn from it [rad], to the left."""
    d = world[:, 1] - world[:, 0]
    u = d / np.hypot(*d.T)[:, None]
    to = ends.mean(1)[:, None] - world[:, 0]
    off = u[:, 0] * to[..., 1] - u[:, 1] * to[..., 0]
    along = ends[:, 1] - ends[:, 0]
    turn = np.arctan2(u[:, 0] * along[:, 1:] - u[:, 1] * along[:, :1], along[:, :1] * u[:, 0] + along[:, 1:] * u[:, 1])
    middle = np.hypot(*np.moveaxis(ends.mean(1)[:, None] - world.mean(1), -1, 0))
    nearest = np.argmin(middle + 20 * np.abs(off) + 5 * np.abs(turn), 1)
    row = np.arange(len(ends))
    return np.column_stack([off[row, nearest], turn[row, nearest]])


CASES = {
    "true poses": (0.012, 0.0, 0.0, 1.0),
    "true poses, a poor laser": (0.025, 0.0, 0.0, 1.0),
    "poses that err scan by scan": (0.012, 0.02, 0.004, 0.01),
    "poses that err over some metres": (0.012, 0.015, 0.003, 1.0),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_errors_are_as_large_as_the_covariance_says(case: tuple[float, float, float, float]) -> None:
    segments, trajectory, world = drive(*case)
    lines, ends, covariance, parts = settled(segments, trajectory)
    good = (geometry.lengths(ends) > 0.5) & (lines.support > 10)
    z = errors(ends, world)[good] / np.sqrt(covariance[good][:, [0, 2]])
    assert len(z) >= 40
    assert np.sqrt((z**2).mean(0)) == pytest.approx(0.9, abs=0.3)
    assert (np.abs(z) < 3).mean() > 0.97
    drawn = errors(lines.ends, world)[good] / np.sqrt(line_covariance(*parts, surveyed=True)[good][:, [0, 2]])
    assert np.median(np.abs(drawn)) < 1.0
    assert (np.abs(drawn) < 3).mean() > 0.97


def test_the_robust_fit_is_nearer_to_the_walls_than_the_moments() -> None:
    segments, trajectory, world = drive(*CASES["true poses, a poor laser"])
    lines, ends, _, _ = settled(segments, trajectory)
    long = geometry.lengths(ends) > 0.5
    off, moments = (np.median(np.abs(errors(e, world)[long]), 0) for e in (ends, lines.ends))
    assert (off < 1.1 * moments).all()


def test_lines_without_segments_have_no_covariance() -> None:
    segments, trajectory, world = drive(*CASES["true poses"])
    none = line_covariance(world, np.full(len(segments), -1), segments, trajectory)
    assert none.shape == (len(world), 3)
    assert not none.any()


def test_lines_of_the_mappers_own_poses_are_as_sure_as_they_say() -> None:
    robot = driven()
    run = pipeline.run(robot.log)
    z = normalized(robot, run.lines, run.trajectory)
    assert len(z) > 25
    assert np.sqrt((z**2).mean()) == pytest.approx(1.0, abs=0.2)
    assert (np.abs(z) < 3).mean() > 0.95


def test_poses_that_are_known_bend_nothing() -> None:
    segments, trajectory, _ = drive(*CASES["true poses"])
    _, _, _, parts = settled(segments, trajectory)
    surveyed, estimated = line_covariance(*parts, surveyed=True), line_covariance(*parts)
    assert (surveyed[:, [0, 2]] < estimated[:, [0, 2]]).all()
