"""Lines merged from scans of a world that is known."""

from __future__ import annotations

import numpy as np
import pytest

from rgcore.config import Extract
from rgcore.config import Lines as Settings
from rgcore.geometry import moments as mo
from rgcore.geometry import segments as geometry
from rgcore.geometry.raycast import cast
from rgcore.lines.merge import Lines, merge_lines
from rgcore.scans.extract import Segments, extract
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

BEARINGS = np.deg2rad(np.arange(-90.0, 91.0))
BOX = np.array([[[-30, -8], [30, -8]], [[30, -8], [30, 8]], [[30, 8], [-30, 8]], [[-30, 8], [-30, -8]]], float)


def wall(x1: float, y1: float, x2: float, y2: float) -> np.ndarray:
    return np.array([[[x1, y1], [x2, y2]]], float)


def drive(x1: float, y1: float, x2: float, y2: float, scans: int = 30) -> np.ndarray:
    """Poses on the way from one point to the other, looking to all sides in turn."""
    share = np.linspace(0, 1, scans)
    return np.stack([x1 + share * (x2 - x1), y1 + share * (y2 - y1), np.arange(scans) * np.pi / 2 % (2 * np.pi)], 1)


def see(
    worlds: list[np.ndarray], poses: list[np.ndarray], jitter: float = 0.0, origin: tuple[float, float] = (0, 0)
) -> tuple[Segments, Trajectory]:
    """What a laser with 12 mm noise sees of each world on each way; ``jitter`` [m] is the error of the poses."""
    rng = np.random.default_rng(5)
    ranges = np.concatenate([cast(w, p, BEARINGS, 80.0)[0] for w, p in zip(worlds, poses, strict=True)])
    ranges = ranges + rng.normal(0, 0.012, ranges.shape)
    at = np.concatenate(poses) + rng.normal(0, 1, (len(ranges), 3)) * [jitter, jitter, jitter / 10]
    at[:, :2] += origin
    n = len(ranges)
    log = ScanLog(np.arange(n), ranges, np.zeros((n, 3)), BEARINGS, np.zeros(3), 80.0)
    return extract(log, Extract()), Trajectory(log.stamps, at, np.zeros(3))


def merged(seen: tuple[Segments, Trajectory], region: np.ndarray | None = None) -> tuple[Lines, np.ndarray]:
    s, trajectory = seen
    return merge_lines(s, trajectory, np.zeros(len(s), int) if region is None else region, Settings())


def near(lines: Lines, x1: float, y1: float, x2: float, y2: float) -> Lines:
    """The lines whose middle lies in a window."""
    x, y = lines.ends.mean(1).T
    return lines[(x > x1) & (x < x2) & (y > y1) & (y < y2)]


def test_a_room_seen_often_is_its_four_walls() -> None:
    room = np.array([[[-2, -1], [4, -1]], [[4, -1], [4, 3]], [[4, 3], [-2, 3]], [[-2, 3], [-2, -1]]], float)
    lines, line_of = merged(see([room], [drive(-1, 0, 3, 2)], jitter=0.01))
    assert len(lines) == 4
    assert sorted(geometry.lengths(lines.ends)) == pytest.approx([4, 4, 6, 6], abs=0.06)
    corners = np.hypot(*np.moveaxis(lines.ends[:, :, None] - room[:, 0], -1, 0)).min(-1)
    assert corners.max() < 0.05
    assert (line_of >= 0).mean() > 0.95


def test_free_space_lies_to_the_left() -> None:
    lines, _ = merged(see([BOX], [drive(-5, 0, 5, 0)]))
    d, inward = lines.ends[:, 1] - lines.ends[:, 0], -lines.ends[:, 0]
    assert (d[:, 0] * inward[:, 1] - d[:, 1] * inward[:, 0] > 0).all()


def test_two_faces_of_a_thin_wall_stay_two_lines() -> None:
    world = np.concatenate([BOX, wall(-4, 0, 4, 0), wall(-4, 0.06, 4, 0.06)])
    lines, _ = merged(see([world] * 2, [drive(-3, -2, 3, -2), drive(-3, 2, 3, 2)]))
    faces = near(lines, -4, -0.5, 4, 0.5)
    assert sorted(faces.ends.mean((1, 2)) * 2) == pytest.approx([0, 0.06], abs=0.02)
    assert np.abs(np.diff(geometry.angles(faces.ends))) == pytest.approx([np.pi], abs=0.01)


def test_a_door_splits_a_wall_at_its_posts() -> None:
    world = np.concatenate([BOX, wall(-6, 2, -0.45, 2), wall(0.45, 2, 6, 2)])
    lines, _ = merged(see([world], [drive(-5, 0, 5, 0, 60)]))
    parts = near(lines, -6, 1.5, 6, 2.5)
    assert len(parts) == 2
    assert sorted(parts.ends[..., 0].ravel())[1:3] == pytest.approx([-0.45, 0.45], abs=0.04)


def test_a_gap_narrower_than_gamma_does_not() -> None:
    world = np.concatenate([BOX, wall(-3, 2, -0.05, 2), wall(0.05, 2, 3, 2)])
    lines, _ = merged(see([world], [drive(-3, 0, 3, 0)]))
    assert len(near(lines, -3, 1.5, 3, 2.5)) == 1


def test_a_door_once_closed_and_mostly_open_is_open() -> None:
    posts = np.concatenate([BOX, wall(-6, 2, -0.45, 2), wall(0.45, 2, 6, 2)])
    closed = np.concatenate([posts, wall(-0.45, 2, 0.45, 2)])
    lines, _ = merged(see([closed, posts], [drive(-3, 0, 0, 0, 8), drive(0, 0, 3, 0, 40)]))
    assert len(near(lines, -6, 1.5, 6, 2.5)) == 2


def test_what_later_scans_see_through_goes() -> None:
    cabinet = np.concatenate([BOX, wall(-0.5, 3, 0.5, 3)])
    lines, _ = merged(see([cabinet, BOX], [drive(-1, 0, 1, 0, 6), drive(-1, 0, 1, 0, 40)]))
    assert len(near(lines, -1, 2, 1, 4)) == 0
    lines, _ = merged(see([cabinet], [drive(-1, 0, 1, 0, 6)]))
    assert len(near(lines, -1, 2, 1, 4)) == 1


def test_a_ghost_behind_a_wall_is_hidden_by_it() -> None:
    shifted = BOX + np.array([0, 0.13])  # some poses are off by more than the distance threshold
    lines, _ = merged(see([BOX, shifted], [drive(-5, 0, 5, 0, 40), drive(-1, 0, 1, 0, 6)]))
    assert len(near(lines, -29, 7, 29, 9)) == 1
    assert len(near(lines, -29, -9, 29, -7)) == 1


def test_a_long_wall_does_not_drift() -> None:
    lines, _ = merged(see([BOX], [drive(-25, 5, 25, 5, 200)], jitter=0.03))
    upper = near(lines, -29, 7, 29, 9)
    assert len(upper) == 1
    assert geometry.lengths(upper.ends)[0] > 55
    assert np.abs(upper.ends[0, :, 1] - 8).max() < 0.02


def test_regions_do_not_mix_and_share_no_wall() -> None:
    world = np.concatenate([BOX, wall(0, -8, 0, -0.5), wall(0, 0.5, 0, 8)])
    s, trajectory = see([world], [drive(-20, 0, 20, 0, 60)])
    middle = geometry.transformed(trajectory.map_from_laser[s.scan], s.ends).mean(1)
    region = (middle[:, 0] > 0).astype(int)
    lines, line_of = merged((s, trajectory), region)
    for k in range(len(lines)):
        assert (region[line_of == k] == lines.region[k]).all()
    for y in (-8, 8):
        parts = near(lines, -29, y - 0.2, 29, y + 0.2)
        assert sorted(parts.region) == [0, 1]
        reach = np.sort(parts.ends[..., 0], axis=1)
        assert reach[parts.region == 0].max() <= reach[parts.region == 1].min() + 0.1


def test_the_order_of_the_segments_does_not_matter() -> None:
    world = np.concatenate([BOX, wall(-6, 2, -0.45, 2), wall(0.45, 2, 6, 2), wall(-2, -3, -1, -4)])
    s, trajectory = see([world], [drive(-5, 0, 5, 0, 40)], jitter=0.02)
    shuffled = s[np.random.default_rng(1).permutation(len(s))]
    one, _ = merged((s, trajectory))
    other, _ = merged((shuffled, trajectory))
    assert len(one) == len(other)
    gaps = np.abs(one.ends[:, None] - other.ends[None]).max((2, 3)).min(1)
    assert gaps.max() < 0.01


def test_far_from_the_origin_is_the_same_map() -> None:
    one, line_of = merged(see([BOX], [drive(-5, 0, 5, 0)], jitter=0.02))
    far, far_of = merged(see([BOX], [drive(-5, 0, 5, 0)], jitter=0.02, origin=(4e5, -5e6)))
    assert (line_of == far_of).all()
    assert far.ends - [4e5, -5e6] == pytest.approx(one.ends, abs=1e-5)


def test_lines_tell_the_truth_about_their_members() -> None:
    s, trajectory = see([BOX], [drive(-5, 0, 5, 0)], jitter=0.02)
    lines, line_of = merged((s, trajectory))
    ends = geometry.transformed(trajectory.map_from_laser[s.scan], s.ends)
    assert (np.diff(lines.first_scan) >= 0).all()
    for k in range(len(lines)):
        own = line_of == k
        assert lines.support[k] == own.sum()
        assert lines.first_scan[k] == s.scan[own].min()
        assert lines.moments[k] == pytest.approx(mo.moments(ends[own]).sum(0), rel=1e-6, abs=1e-6)
        assert 0 < lines.rms[k] < 0.06


def test_seen_once_is_not_enough() -> None:
    lines, line_of = merged(see([BOX], [drive(0, 0, 0, 0, 1)]))
    assert len(lines) == 0
    assert (line_of == -1).all()


def test_nothing_gives_nothing() -> None:
    s, trajectory = see([BOX], [drive(0, 0, 0, 0, 1)])
    lines, line_of = merged((s[:0], trajectory))
    assert (len(lines), len(line_of)) == (0, 0)
