"""Local registration: finds known poses, says what it does not see, keeps what it does not know."""

from __future__ import annotations

import numpy as np
from drives import BEARINGS, chain, ring
from hypothesis import given, settings
from hypothesis import strategies as st

from rgcore.geometry import se2
from rgcore.geometry.raycast import cast
from rgcore.slam.keyframes import Keyframes
from rgcore.slam.local import LocalMap, register
from rgcore.slam.surface import Surface, surface

POSE = np.array([5.0, 1.0, 0.1])


def see(walls: np.ndarray, pose: np.ndarray) -> Surface:
    return surface(cast(walls, pose[None], BEARINGS, 30.0)[0][0], BEARINGS, 25.0, 0.05)


def map_from(walls: np.ndarray, *poses: np.ndarray) -> LocalMap:
    frames = Keyframes(BEARINGS)
    for pose in poses:
        frames.add(pose, see(walls, pose), cast(walls, pose[None], BEARINGS, 30.0)[0][0], len(frames))
    return frames.map_of(np.arange(len(frames)))


ON_RING = map_from(ring(), POSE, POSE + np.array([0.4, 0.0, 0.1]), POSE + np.array([0.8, 0.1, -0.1]))


@settings(max_examples=30, deadline=None)
@given(st.floats(-0.25, 0.25), st.floats(-0.25, 0.25), st.floats(-0.2, 0.2), st.floats(-0.3, 1.0))
def test_finds_the_pose_from_nearby(dx: float, dy: float, turn: float, further: float) -> None:
    true = POSE + np.array([further, 0.1, 0.05])
    match = register(see(ring(), true), ON_RING, true + np.array([dx, dy, turn]), np.eye(3), 0.02, 0.5)
    assert np.hypot(*(match.pose - true)[:2]) < 0.01
    assert abs(match.pose[2] - true[2]) < 0.003
    assert match.share > 0.7


def test_a_corridor_says_nothing_along_itself() -> None:
    walls = chain((-50, 0), (50, 0))
    walls = np.concatenate([walls, walls[:, ::-1] + [0, 2]])
    on = map_from(walls, np.array([0.0, 1.0, 0.0]), np.array([0.4, 1.0, 0.02]))
    true, odometry = np.array([1.0, 1.0, 0.0]), np.array([1.2, 1.05, 0.03])
    match = register(see(walls, true), on, odometry, np.diag([100.0, 100.0, 100.0]), 0.02, 0.5)
    assert abs(match.pose[0] - odometry[0]) < 0.01, "along the corridor the first pose stands"
    assert abs(match.pose[1] - true[1]) < 0.005, "across it the walls decide"
    assert abs(match.pose[2]) < 0.002
    information = match.information.sum(0)
    assert information[0, 0] < 0.01 * information[1, 1]


def test_the_two_faces_of_a_thin_wall_are_not_confused() -> None:
    near, far = chain((4, 0), (0, 0)), chain((0, 0.06), (4, 0.06))
    on = map_from(near, np.array([2.0, -1.5, np.pi / 2]))
    seen = see(far, np.array([2.0, 1.5, -np.pi / 2]))
    match = register(seen, on, np.array([2.0, 1.5, -np.pi / 2]), np.eye(3), 0.02, 0.3)
    assert match.share == 0.0


def test_normals_look_at_the_laser() -> None:
    s = see(ring(), POSE)
    known = (s.normals != 0).any(1)
    assert known.mean() > 0.6
    assert np.allclose(np.hypot(*s.normals[known].T), 1.0)
    assert ((s.points[known] * s.normals[known]).sum(1) < 0).all()


def test_a_scan_without_echoes_stays_where_it_was_expected() -> None:
    nothing = surface(np.full(len(BEARINGS), np.inf), BEARINGS, 25.0, 0.05)
    match = register(nothing, ON_RING, POSE, np.eye(3), 0.02, 0.5)
    assert np.allclose(match.pose, POSE)
    assert match.share == 0.0


def test_the_map_of_nothing_moves_nobody() -> None:
    frames = Keyframes(BEARINGS)
    frames.add(POSE, Surface(np.zeros((0, 2)), np.zeros((0, 2))), np.full(len(BEARINGS), np.nan), 0)
    match = register(see(ring(), POSE), frames.map_of(np.array([0])), POSE, np.eye(3), 0.02, 0.5)
    assert np.allclose(match.pose, POSE)


def test_scans_that_see_through_each_others_walls_disagree() -> None:
    frames = Keyframes(BEARINGS)
    readings = cast(ring(), POSE[None], BEARINGS, 30.0)[0][0]
    frames.add(POSE, see(ring(), POSE), readings, 0)
    here = frames.agree(see(ring(), POSE), readings, POSE, np.array([0]))
    assert here[0] > 100
    assert here[1] == 0
    turned = se2.compose(POSE, np.array([0.0, 0.0, 0.6]))
    elsewhere = frames.agree(see(ring(), POSE), readings, turned, np.array([0]))
    assert elsewhere[1] > 0.3 * elsewhere[:2].sum()
