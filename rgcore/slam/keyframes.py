"""Keyframes: the scans that the map is made of, and what they say of each other."""

from __future__ import annotations

import numpy as np

from rgcore.geometry import se2
from rgcore.geometry.compiled import kernel
from rgcore.slam.agreement import agreement
from rgcore.slam.local import LocalMap, Match, discount, local_map
from rgcore.slam.posegraph import Links
from rgcore.slam.small import inverse, times, wrapped
from rgcore.slam.surface import Surface, Surfaces, filled

LEAST_PAIRS = 10
"""Fewer paired points than this make no link."""


class Keyframes:
    """A growing list of scans with their poses, surfaces, ranges and numbers."""

    def __init__(self, bearings: np.ndarray) -> None:
        self.bearings = bearings
        self.scans: list[int] = []
        self.since = 0  # the first after the last break
        self._poses = np.zeros((64, 3))
        self._ranges = np.zeros((64, len(bearings)))
        self._echoes, self._walls = _Pile(), _Pile()

    def __len__(self) -> int:
        return len(self.scans)

    @property
    def poses(self) -> np.ndarray:
        """(K, 3) map_from_laser; a view, so that it can be written."""
        return self._poses[: len(self)]

    @property
    def ranges(self) -> np.ndarray:
        """(K, B) their readings."""
        return self._ranges[: len(self)]

    @property
    def surfaces(self) -> Surfaces:
        """Their surface points, laser frame."""
        return self._echoes.all()

    @property
    def walls(self) -> Surfaces:
        """The same :func:`filled`, to make maps of."""
        return self._walls.all()

    def surface(self, keyframe: int) -> Surface:
        """The surface points of one."""
        return self._echoes.one(keyframe)

    def add(self, pose: np.ndarray, surface: Surface, ranges: np.ndarray, scan: int) -> None:
        """Append one."""
        k = len(self)
        if k == len(self._poses):
            self._poses, self._ranges = _twice(self._poses), _twice(self._ranges)
        self._poses[k], self._ranges[k] = pose, ranges
        self._echoes.add(surface)
        self._walls.add(filled(surface))
        self.scans.append(scan)

    def map_of(self, members: np.ndarray) -> LocalMap:
        """The local map that these keyframes make."""
        on: LocalMap = local_map(self.walls, members, self.poses)
        return on

    def points_of(self, members: np.ndarray, origin: np.ndarray) -> np.ndarray:
        """(n, 2) points of the walls of these keyframes, seen from ``origin`` (3,)."""
        every = [se2.transform(se2.relative(origin, self.poses[m]), self._walls.one(m).points) for m in members]
        return np.concatenate(every)

    def agree(self, surface: Surface, ranges: np.ndarray, pose: np.ndarray, members: np.ndarray) -> np.ndarray:
        """(3,) points of a scan at ``pose`` and of the members that the other confirms, contradicts and cannot see."""
        return agreement(self.surfaces, self.ranges, self.bearings, self.poses, members, surface.points, ranges, pose)


def links_of(match: Match, poses: np.ndarray, members: np.ndarray, keyframe: int, scale: float = np.inf) -> Links:
    """What a keyframe, registered on the map of ``members``, says of its pose relative to each of them."""
    ok = match.pairs >= LEAST_PAIRS
    measured, information = np.zeros((len(members), 3)), np.zeros((len(members), 3, 3))
    write_links(match.information, match.gradient, poses, members, match.pose, measured, information)
    many = int(ok.sum())
    return Links(members[ok], np.full(many, keyframe), measured[ok], information[ok], np.full(many, scale))


@kernel
def write_links(information, gradient, poses, members, pose, measured, out):  # type: ignore[no-untyped-def]
    """Turns normal equations in the map's axes to relative poses and information in the axes of each of the
    ``members``.
    """
    for o in range(len(members)):
        a, b, m = information[o].copy(), gradient[o].copy(), members[o]
        discount(a, b)
        step = times(inverse(a), b)
        c, s = np.cos(poses[m, 2]), np.sin(poses[m, 2])
        x, y = pose[0] + step[0] - poses[m, 0], pose[1] + step[1] - poses[m, 1]
        measured[o, 0], measured[o, 1] = c * x + s * y, -s * x + c * y
        measured[o, 2] = wrapped(pose[2] + step[2] - poses[m, 2])
        xx, xy, yy, xt, yt = a[0, 0], a[0, 1], a[1, 1], a[0, 2], a[1, 2]
        out[o, 0, 0] = c * c * xx + 2.0 * c * s * xy + s * s * yy
        out[o, 1, 1] = s * s * xx - 2.0 * c * s * xy + c * c * yy
        out[o, 0, 1] = out[o, 1, 0] = c * s * (yy - xx) + (c * c - s * s) * xy
        out[o, 0, 2] = out[o, 2, 0] = c * xt + s * yt
        out[o, 1, 2] = out[o, 2, 1] = -s * xt + c * yt
        out[o, 2, 2] = a[2, 2]


class _Pile:
    """Surfaces, one after the other, with room for more."""

    def __init__(self) -> None:
        self._many = 0
        self._start = np.zeros(65, np.int64)
        self._points, self._normals = np.zeros((4096, 2)), np.zeros((4096, 2))

    def add(self, surface: Surface) -> None:
        n = self._many
        begin, end = self._start[n], self._start[n] + len(surface.points)
        if n + 2 > len(self._start):
            self._start = _twice(self._start)
        while end > len(self._points):
            self._points, self._normals = _twice(self._points), _twice(self._normals)
        self._points[begin:end], self._normals[begin:end] = surface.points, surface.normals
        self._start[n + 1] = end
        self._many += 1

    def all(self) -> Surfaces:
        n = self._many
        end = self._start[n]
        return Surfaces(self._points[:end], self._normals[:end], self._start[: n + 1])

    def one(self, k: int) -> Surface:
        part = slice(self._start[k], self._start[k + 1])
        return Surface(self._points[part], self._normals[part])


def _twice(array: np.ndarray) -> np.ndarray:
    """The array with as many empty rows after it."""
    return np.concatenate([array, np.zeros_like(array)])
