"""Segments of scans whose walls are known."""

from __future__ import annotations

import numpy as np
import pytest

from rgcore.config import Extract
from rgcore.geometry import segments as geometry
from rgcore.geometry.raycast import cast
from rgcore.scans.extract import Segments, adapted, extract, extract_scan, polar
from rgcore.scans.log import ScanLog

HALF = np.deg2rad(np.arange(-90.0, 91.0))
FULL = np.deg2rad(np.arange(-180.0, 180.0))
SIGMA = 0.012  # m, a usual laser


def walls(*corners: tuple[float, float]) -> np.ndarray:
    """A chain of walls through the corners."""
    c = np.array(corners, float)
    return np.stack([c[:-1], c[1:]], 1)


def see(
    world: np.ndarray, bearings: np.ndarray = HALF, pose: tuple[float, float, float] = (0, 0, 0), sigma: float = SIGMA
) -> np.ndarray:
    """(B,) ranges of one scan."""
    ranges = cast(world, np.array([pose], float), bearings, 80.0)[0][0]
    return ranges + np.random.default_rng(3).normal(0, sigma, len(bearings))


def segments(ranges: np.ndarray, bearings: np.ndarray = HALF) -> Segments:
    return extract_scan(ranges, bearings, Extract())


def test_a_room_is_its_four_walls_also_across_the_seam_of_a_full_circle() -> None:
    room = walls((-2, -1.5), (3, -1.5), (3, 2), (-2, 2), (-2, -1.5))  # the beam at 180 degrees ends on a wall
    s = segments(see(room, FULL), FULL)
    assert sorted(geometry.lengths(s.ends)) == pytest.approx([3.5, 3.5, 5, 5], abs=0.2)  # two spacings of echoes
    corners = room[:, 0]
    nearest = np.hypot(*np.moveaxis(s.ends[:, :, None] - corners, -1, 0)).min(-1)
    assert nearest.max() < 0.16


def test_the_laser_lies_to_the_left() -> None:
    for bearings in (FULL, FULL[::-1]):  # the second: a laser mounted upside down
        s = segments(
            see(walls((-2, -2), (2, -2), (2, 2), (-2, 2), (-2, -2)), FULL)[:: 1 if bearings is FULL else -1], bearings
        )
        d, to_laser = s.ends[:, 1] - s.ends[:, 0], -s.ends[:, 0]
        assert len(s) == 4
        assert (d[:, 0] * to_laser[:, 1] - d[:, 1] * to_laser[:, 0] > 0).all()


def test_missing_echoes_do_not_chop_a_wall() -> None:
    ranges = see(walls((2, -3), (2, 3)))
    ranges[::7] = np.inf
    ranges[60:64] = np.nan
    s = segments(ranges)
    assert len(s) == 1
    assert geometry.lengths(s.ends)[0] == pytest.approx(6, abs=0.3)


def test_one_wrong_echo_does_not_chop_a_wall() -> None:
    for wrong in (1.2, 2.3, 9.0):
        ranges = see(walls((2, -3), (2, 3)))
        ranges[90] = wrong
        assert len(segments(ranges)) == 1


def test_a_chair_leg_in_front_does_not_chop_a_wall() -> None:
    ranges = see(np.concatenate([walls((2, -3), (2, 3)), walls((1.5, 0.1), (1.5, 0.13))]))
    assert (ranges < 1.6).any()
    assert len(segments(ranges)) == 1


def test_a_door_does_chop_it_at_its_posts() -> None:
    world = np.concatenate([walls((2, -3), (2, -0.45)), walls((2, 0.45), (2, 3)), walls((6, -9), (6, 9))])
    s = segments(see(world))
    near = s[s.ends[:, 0, 0] < 3]
    assert len(near) == 2
    assert sorted(near.ends[..., 1].ravel())[1:3] == pytest.approx([-0.45, 0.45], abs=0.05)


def test_a_long_corridor_wall_holds_together_at_grazing_incidence() -> None:
    s = segments(see(walls((-1, 1), (9, 1))))
    assert len(s) == 1
    assert geometry.lengths(s.ends)[0] > 5  # neighbouring echoes up to 0.5 m apart


def test_an_inner_corner_is_cut_at_the_corner() -> None:
    s = segments(see(walls((1, -2), (3, 0), (1, 2))))
    assert len(s) == 2
    assert s.ends[0, 1] == pytest.approx([3, 0], abs=0.06)
    assert s.ends[1, 0] == pytest.approx([3, 0], abs=0.06)


def test_a_chain_of_things_behind_one_another_is_no_wall() -> None:
    bearings = np.deg2rad(np.arange(-90, 90.5, 0.5))
    ranges = np.full(len(bearings), np.inf)
    ranges[180:186] = [2.0, 2.3, 2.6, 2.9, 3.2, 3.5]  # straight away from the laser
    assert len(segments(ranges, bearings)) == 0


def test_the_fit_is_better_than_the_noise() -> None:
    s = segments(see(walls((2, -2), (2, 2))))
    assert np.abs(s.ends[0, :, 0] - 2).max() < SIGMA
    assert s.rms[0] == pytest.approx(SIGMA, rel=0.4)
    assert s.points[0] == s.beams[0, 1] - s.beams[0, 0] + 1


def test_settings_leave_out_the_far_the_short_and_the_few() -> None:
    ranges = see(walls((4, -2), (4, 2)))
    assert len(extract_scan(ranges, HALF, Extract(max_range=3))) == 0
    assert len(extract_scan(ranges, HALF, Extract(min_length=5))) == 0
    assert len(extract_scan(ranges, HALF, Extract(min_points=100))) == 0


def test_scans_without_echoes_and_logs_without_scans() -> None:
    assert len(segments(np.full(181, np.inf))) == 0
    assert len(segments(np.full(181, np.nan))) == 0
    none = ScanLog(np.zeros(0), np.zeros((0, 181)), np.zeros((0, 3)), HALF, np.zeros(3), 80.0)
    assert len(extract(none, Extract())) == 0


def test_a_log_gives_what_its_scans_give() -> None:
    world = walls((-4, -3), (5, -3), (5, 3), (-4, 3), (-4, -3))
    ranges = np.stack([see(world, pose=(x, 0, 0.3 * x)) for x in range(4)])
    log = ScanLog(np.zeros(4), ranges, np.zeros((4, 3)), HALF, np.zeros(3), 80.0)
    s = extract(log, Extract())
    for k in range(4):
        one = segments(ranges[k])
        assert (s[s.scan == k].ends == one.ends).all()
        assert (s[s.scan == k].beams == one.beams).all()


# a hall with a wall ahead at y = 3 and one at x = 6, seen from many places
AHEAD, ASIDE = np.pi / 2, 0.0
HALL = np.array([[[-40, 3.0], [6, 3.0]], [[6, 3], [6, -40.0]]])


def drive(sigma: float, bearings: np.ndarray, scans: int = 400) -> ScanLog:
    """A log whose odometry is the truth."""
    chance = np.random.default_rng(1)
    poses = chance.uniform([-3, -2, -np.pi], [3, 2.5, np.pi], (scans, 3))
    ranges = cast(HALL, poses, bearings, 30.0)[0]
    ranges += chance.normal(0, sigma, ranges.shape)
    return ScanLog(np.arange(scans), ranges, poses, bearings, np.zeros(3), 30.0)


LASERS = {
    "half a turn": HALF,
    "a full turn": FULL,
    "1081 beams": np.deg2rad(np.linspace(-135, 135, 1081)),
    "90 beams": np.deg2rad(np.arange(-180, 180, 4)),
}


@pytest.mark.parametrize("bearings", LASERS.values(), ids=LASERS)
@pytest.mark.parametrize("sigma", [0.004, 0.012, 0.03])
def test_the_covariance_is_that_of_the_true_errors(sigma: float, bearings: np.ndarray) -> None:
    log = drive(sigma, bearings)
    s = extract(log, Extract())
    s = s[s.points >= 5]
    rho, alpha, covariance = polar(s)
    pose = log.odom_from_laser[s.scan]
    normals, offsets = np.array([AHEAD, ASIDE]), np.array([3.0, 6.0])
    turn = np.angle(np.exp(1j * (alpha[:, None] - normals + pose[:, 2:])))
    far = rho[:, None] - (offsets - pose[:, :1] * np.cos(normals) - pose[:, 1:2] * np.sin(normals))
    wall = np.argmin(np.abs(turn) + np.abs(far), 1)[:, None]
    errors = np.concatenate([np.take_along_axis(far, wall, 1), np.take_along_axis(turn, wall, 1)], 1)
    whitened = np.linalg.solve(np.linalg.cholesky(covariance), errors[..., None])[..., 0]
    assert len(s) > 300
    assert 1.4826 * np.median(np.abs(whitened), 0) == pytest.approx(1, abs=0.15)
    assert (np.abs(whitened) < 3).mean() > 0.98


@pytest.mark.parametrize("bearings", LASERS.values(), ids=LASERS)
@pytest.mark.parametrize("sigma", [0.012, 0.03, 0.05])
def test_walls_hold_together_however_noisy_the_laser(sigma: float, bearings: np.ndarray) -> None:
    log = drive(sigma, bearings)
    still = extract(drive(0.0, bearings), Extract())
    s = extract(log, Extract())
    assert len(s) < 1.2 * len(still)
    assert geometry.lengths(s.ends).sum() > 0.9 * geometry.lengths(still.ends).sum()


def test_the_noise_of_a_laser_is_told_by_its_log() -> None:
    for sigma in (0.005, 0.012, 0.03, 0.05):
        assert adapted(drive(sigma, HALF), Extract()).noise == pytest.approx(sigma, rel=0.15)
    assert adapted(drive(0.03, HALF, scans=5), Extract()).noise == Extract().noise  # too few walls


def test_a_usual_laser_changes_no_threshold() -> None:
    log = drive(0.013, HALF, scans=50)
    assert adapted(log, Extract()).noise != Extract().noise
    one = [extract_scan(r, HALF, Extract()) for r in log.ranges]
    assert (extract(log, Extract()).ends == np.concatenate([s.ends for s in one])).all()


def test_grazing_walls_are_surer_across_than_facing_ones() -> None:
    facing, grazed = segments(see(walls((2, -1), (2, 1)))), segments(see(walls((2, 0.5), (6, 0.5))))
    assert grazed.covariance[0, 0] * grazed.points[0] < 0.3 * facing.covariance[0, 0] * facing.points[0]


def test_mixed_pixels_at_the_edge_of_a_wall_do_not_bend_it() -> None:
    world = np.concatenate([walls((2, -2), (2, 0)), walls((3, -30), (3, 30))])
    ranges = see(world)
    edge = np.flatnonzero((ranges[:-1] < 2.1) & (ranges[1:] > 2.9))[0]
    for share in (0.1, 0.3, 0.5, 0.9):
        mixed = ranges.copy()
        mixed[edge + 1] = (1 - share) * ranges[edge] + share * ranges[edge + 1]
        s = segments(mixed)
        assert len(s) == 3  # the wall, and what is left and right of it behind
        assert sorted(np.round(s.ends.mean(1)[:, 0])) == [2, 3, 3]
        assert np.abs(s.ends[..., 0] - np.round(s.ends.mean(1)[:, :1])).max() < 0.02


def test_outliers_all_over_a_wall_do_not_chop_it() -> None:
    ranges = see(walls((2, -4), (2, 4)))
    ranges[40:140:13] += np.random.default_rng(0).choice([-0.5, 0.5, 3.0], 8)
    s = segments(ranges)
    assert len(s) == 1
    assert np.abs(s.ends[0, :, 0] - 2).max() < 0.02


def test_a_step_of_a_wall_is_two_walls() -> None:
    s = segments(see(np.concatenate([walls((2, -2), (2, 0)), walls((2.15, 0), (2.15, 2))])))
    assert len(s) == 2
    assert sorted(s.ends.mean(1)[:, 0]) == pytest.approx([2, 2.15], abs=0.015)


def test_far_walls_of_a_far_reaching_laser() -> None:
    bearings = LASERS["1081 beams"]
    s = extract_scan(see(walls((35, -10), (35, 10)), bearings), bearings, Extract(max_range=40.0))
    assert len(s) == 1
    assert geometry.lengths(s.ends)[0] == pytest.approx(20, abs=0.5)
