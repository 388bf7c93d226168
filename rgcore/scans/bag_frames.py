"""The frames of a bag: which hangs on which, where the laser sits on the robot, and how the robot moves (REP 105)."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

_STILL = 0.01  # m: what moves less does not drive; wheels turn on the spot
_DEEPEST = 64  # frames from one to the root; more is a circle
_WORLD = ("map", "world", "earth")


def planar(position: Any, orientation: Any) -> tuple[float, float, float]:
    """(x, y, theta) of a pose message [m, rad]."""
    m = _matrix(position, orientation)
    return float(m[0, 3]), float(m[1, 3]), float(np.arctan2(m[1, 0], m[0, 0]))


class Frames:
    """The transforms of a bag: for each frame its parent, the first transform and the whole way."""

    def __init__(self) -> None:
        self._parent: dict[str, str] = {}
        self._first: dict[str, np.ndarray] = {}
        self._poses: dict[str, list[tuple[float, float, float, float, float]]] = {}

    def add(self, transform: Any, stamp: float, recorded: float) -> None:
        """A TransformStamped message. Raises ValueError for a rotation that is none."""
        parent, child = transform.header.frame_id.strip("/"), transform.child_frame_id.strip("/")
        if parent in _WORLD:
            return  # what a localizer said on the day: not raw odometry, and a second parent for odom
        matrix = _matrix(transform.transform.translation, transform.transform.rotation)
        if self._parent.setdefault(child, parent) != parent:
            return  # a frame has one parent; the first to claim it has it
        self._first.setdefault(child, matrix)
        flat = float(matrix[0, 3]), float(matrix[1, 3]), float(np.arctan2(matrix[1, 0], matrix[0, 0]))
        self._poses.setdefault(child, []).append((*flat, stamp, recorded))

    @cached_property
    def base(self) -> str:
        """The frame that drives in its root, "" if none does: the robot by its odometry. Ask when all were added."""
        driving = [k for k, poses in self._poses.items() if np.ptp(np.array(poses)[:, :2], axis=0).max() > _STILL]
        return max(driving, key=lambda k: (self._parent[k] not in self._parent, len(self._poses[k])), default="")

    def root(self, frame: str) -> str:
        """The frame that all others hang on which ``frame`` hangs together with; not beyond the robot."""
        return self._to_root(frame)[0]

    def known(self, frame: str) -> bool:
        """Whether any transform speaks of a frame."""
        return frame in self._parent or frame in self._parent.values()

    def between(self, base: str, other: str) -> np.ndarray | None:
        """(4, 4) ``base_from_other``; None where the two do not hang together."""
        a, b = self._to_root(base), self._to_root(other)
        if a[0] != b[0]:
            return None
        return np.asarray(np.linalg.inv(a[1]) @ b[1])

    def moving(self, laser: str) -> np.ndarray:
        """(K, 5) x, y, theta, stamp, time of recording of the robot in its odometry frame; empty if nothing moves."""
        if not self.base or self.between(self.base, laser) is None:
            return np.zeros((0, 5))
        return np.array(self._poses[self.base])

    def _to_root(self, frame: str) -> tuple[str, np.ndarray]:
        """The root of a frame's tree, and (4, 4) ``root_from_frame``; a tree ends at the robot's own motion."""
        matrix = np.eye(4)
        for _ in range(_DEEPEST):
            if frame not in self._parent or frame == self.base:
                break
            matrix = self._first[frame] @ matrix
            frame = self._parent[frame]
        return frame, matrix


def _matrix(position: Any, orientation: Any) -> np.ndarray:
    """(4, 4) of a translation and a quaternion; the zero quaternion of careless drivers means no turn."""
    q = np.array([orientation.x, orientation.y, orientation.z, orientation.w], float)
    out = np.eye(4)
    if np.linalg.norm(q) > 1e-6:
        out[:3, :3] = Rotation.from_quat(q).as_matrix()
    out[:3, 3] = position.x, position.y, position.z
    if not np.isfinite(out).all():
        raise ValueError("a transform is not finite")
    return out
