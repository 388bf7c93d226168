"""A scan against the lines of a map: where it fits, and how well.

Point to line (Censi 2008), by Gauss-Newton with robust weights. What many points say of one line is worth no more than
the line itself: its own error is common to them all.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rgcore.geometry.compiled import kernel
from rgcore.robot.linemap import LineMap, expect, nearest
from rgcore.slam.local import discount
from rgcore.slam.small import inverse, times, wrapped
from rgcore.slam.surface import Surface, surface

NORMALS_AGREE = 0.7
"""Cosine of the largest angle between the normals of an echo and its line."""
SEEN_AGREE = 0.05
"""The same where the echo's normal is unknown: the beam came from the free side of the line, and not along it."""
ROUNDS = 12


class View(NamedTuple):
    """What a scan shows, laser frame.

    points      (n, 2) m
    directions  (n, 2) their normals, or the direction to the laser where these are unknown
    agree       (n,)   least cosine between the direction and the normal of a line
    """

    points: np.ndarray
    directions: np.ndarray
    agree: np.ndarray


class Fit(NamedTuple):
    """How readings compare with the lines, as shares of them.

    They are ``explained`` by a line, ``short`` of what the map predicts (people, new things), or ``crossed``: gone
    through a line that should have stopped them.
    """

    explained: float
    short: float
    crossed: float

    @property
    def quality(self) -> float:
        """What speaks for a pose less what speaks against it; people in front of the laser do neither."""
        return self.explained - self.crossed


def view(ranges: np.ndarray, bearings: np.ndarray, max_range: float, spacing: float) -> View:
    """The View of a scan of ``ranges`` (B,) at ``bearings`` (B,)."""
    return view_of(surface(ranges, bearings, max_range, spacing))


def view_of(scan: Surface) -> View:
    """The View of surface points in the laser's frame."""
    known = (scan.normals != 0.0).any(1)
    far = np.maximum(np.hypot(scan.points[:, 0], scan.points[:, 1]), 1e-9)
    directions = np.where(known[:, None], scan.normals, -scan.points / far[:, None])
    return View(scan.points.copy(), directions, np.where(known, NORMALS_AGREE, SEEN_AGREE))


def fit(seen: View, lines: LineMap, pose: np.ndarray, tolerance: float) -> Fit:
    """How well the readings of one scan at ``pose`` (3,) agree with the lines, to ``tolerance`` [m]."""
    if len(seen.points) == 0:
        return Fit(0.0, 0.0, 0.0)
    bearings = np.arctan2(seen.points[:, 1], seen.points[:, 0])
    order = np.argsort(bearings, kind="stable")
    ranges = np.hypot(seen.points[:, 0], seen.points[:, 1])
    predicted, visible = expect(lines, pose, bearings[order], float(ranges.max()) + 1.0)
    return Fit(*_compare(View(*(a[order] for a in seen)), lines, visible, pose, ranges[order], predicted, tolerance))


@kernel
def register(seen, lines, visible, first, prior, noise, line_variance, reach):  # type: ignore[no-untyped-def]
    """Where a View fits on the lines that are ``visible`` (L,), from ``first`` (3,) of information ``prior`` (3, 3) on.

    Returns the pose (3,) and its information (3, 3). ``noise`` [m] is the deviation of an echo from its line,
    ``line_variance`` (L,) [m2] is that of a line off its wall, ``reach`` [m] how far off the first pose may be. Where
    the scan does not constrain a direction the first pose stands.
    """
    pose, off = first.copy(), np.zeros(3)
    partner, count = np.empty(len(seen.points), np.int64), np.zeros(len(lines.start))
    a, b = np.zeros((3, 3)), np.zeros(3)
    near, wide, fine = reach, 3.0 * noise, 5.0 * noise
    for k in range(ROUNDS):
        c, s = np.cos(pose[2]), np.sin(pose[2])
        count.fill(0.0)
        for i in range(len(partner)):
            px, py, dx, dy = seen.points[i, 0], seen.points[i, 1], seen.directions[i, 0], seen.directions[i, 1]
            x, y = c * px - s * py + pose[0], s * px + c * py + pose[1]
            partner[i] = nearest(lines, visible, x, y, c * dx - s * dy, s * dx + c * dy, seen.agree[i], near)
            if partner[i] >= 0:
                count[partner[i]] += 1.0
        a.fill(0.0)
        b.fill(0.0)
        for i in range(len(partner)):
            j = partner[i]
            if j < 0:
                continue
            rx, ry = c * seen.points[i, 0] - s * seen.points[i, 1], s * seen.points[i, 0] + c * seen.points[i, 1]
            nx, ny = -lines.along[j, 1], lines.along[j, 0]
            e = nx * (lines.start[j, 0] - rx - pose[0]) + ny * (lines.start[j, 1] - ry - pose[1])
            turn = ny * rx - nx * ry
            w = 1.0 / (1.0 + (e / (3.0 * wide)) ** 2)
            w = w * w / (noise * noise + count[j] * line_variance[j])
            a[0, 0] += w * nx * nx
            a[0, 1] += w * nx * ny
            a[1, 1] += w * ny * ny
            a[0, 2] += w * nx * turn
            a[1, 2] += w * ny * turn
            a[2, 2] += w * turn * turn
            b[0] += w * nx * e
            b[1] += w * ny * e
            b[2] += w * turn * e
        a[1, 0], a[2, 0], a[2, 1] = a[0, 1], a[0, 2], a[1, 2]
        discount(a, b)
        off[0], off[1], off[2] = first[0] - pose[0], first[1] - pose[1], wrapped(first[2] - pose[2])
        pull = times(prior, off)
        share = 1.0 / (
            1.0 + (off[0] * pull[0] + off[1] * pull[1] + off[2] * pull[2]) / 9.0
        )  # contradicted, it says less
        for i in range(3):
            b[i] += share * pull[i]
            for j in range(3):
                a[i, j] += share * prior[i, j]
        step = times(inverse(a), b)
        for i in range(3):
            pose[i] += step[i]
        small = abs(step[0]) + abs(step[1]) < 5e-4 and abs(step[2]) < 2e-4
        if small and near <= fine:
            break
        if small or k >= 2:
            near, wide = max(fine, 0.5 * near), noise
    pose[2] = wrapped(pose[2])
    return pose, a


@kernel
def _compare(seen, lines, visible, pose, ranges, predicted, tolerance):  # type: ignore[no-untyped-def]
    """Shares of explained, short and crossed readings; beams graze edges, so that the nearest line explains too."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    explained, short, crossed = 0, 0, 0
    for i in range(len(ranges)):
        px, py, dx, dy = seen.points[i, 0], seen.points[i, 1], seen.directions[i, 0], seen.directions[i, 1]
        x, y = c * px - s * py + pose[0], s * px + c * py + pose[1]
        if (
            abs(ranges[i] - predicted[i]) < tolerance
            or nearest(lines, visible, x, y, c * dx - s * dy, s * dx + c * dy, seen.agree[i], tolerance) >= 0
        ):
            explained += 1
        elif ranges[i] > predicted[i]:
            crossed += 1
        else:
            short += 1
    n = len(ranges)
    return explained / n, short / n, crossed / n
