"""Local registration: a scan against the local map, point to line.

The local map holds the surface points of some keyframes in a grid of cells. Each point of the scan is paired with the
nearest compatible point of *every* keyframe of the map, so one pass gives what each pair of keyframes has to say
(Lu & Milios 1997; point-to-line metric: Censi 2008), and their sum is the registration.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rgcore.geometry.compiled import inner, kernel
from rgcore.slam.small import inverse, times, wrapped
from rgcore.slam.surface import FILL, Surface

CELL = 0.3
"""Side of the cells [m] in which map points are found: about the search distance."""
NORMALS_AGREE = 0.7
"""Cosine of the largest angle between the normals of a pair: 45 degrees, which also tells the two faces of a wall
apart.
"""
DEVIATION = 0.06
"""Of a point from the nearest one of the map [m], where the scan fits: noise, and points that lie apart."""
LEAST_LEFT = 1e-3
"""Share of the information along the least certain direction that is never taken off."""
UNSEEN = 0.01
"""Information [1/m^2, 1/rad^2] of a direction about which a scan says nothing: no inverse grows beyond use."""
FALSE_INFORMATION = 0.01
"""Noise of normals of 6 degrees makes a corridor seem to resist along its axis by sin(6 deg)^2 a point; it is taken
off.
"""


class LocalMap(NamedTuple):
    """Surface points (n, 2), normals (n, 2) and their keyframe 0..owners-1 (n,), sorted by cell.

    ``start[c]..start[c+1]`` are the points of cell c of a grid with ``corner`` (2,) and ``shape`` (columns, rows).
    """

    points: np.ndarray
    normals: np.ndarray
    owner: np.ndarray
    start: np.ndarray
    corner: np.ndarray
    shape: tuple[int, int]
    owners: int


class Match(NamedTuple):
    """A registered scan.

    pose         (3,)       of the scan on the map
    information  (m, 3, 3)  of each keyframe of the map: the normal equations of its pairs at that pose, for steps
    gradient     (m, 3)     [dx dy dtheta] in the map's axes about the laser
    pairs        (m,)       how many points have a partner there
    share        of the scan's points that have any partner
    """

    pose: np.ndarray
    information: np.ndarray
    gradient: np.ndarray
    pairs: np.ndarray
    share: float


@kernel
def local_map(surfaces, members, poses):  # type: ignore[no-untyped-def]
    """The LocalMap that keyframes ``members`` (m,) of ``surfaces`` make at ``poses`` (K, 3): their points with
    normals.
    """
    most = 0
    for k in members:
        most += surfaces.start[k + 1] - surfaces.start[k]
    xy, normal, owner, n = np.empty((most, 2)), np.empty((most, 2)), np.empty(most, np.int64), 0
    left, right, low, high = np.inf, -np.inf, np.inf, -np.inf
    for o in range(len(members)):
        m = members[o]
        c, s = np.cos(poses[m, 2]), np.sin(poses[m, 2])
        for k in range(surfaces.start[m], surfaces.start[m + 1]):
            u, v = surfaces.normals[k, 0], surfaces.normals[k, 1]
            if u == 0.0 and v == 0.0:
                continue
            x, y = surfaces.points[k, 0], surfaces.points[k, 1]
            xy[n, 0], xy[n, 1] = c * x - s * y + poses[m, 0], s * x + c * y + poses[m, 1]
            normal[n, 0], normal[n, 1], owner[n] = c * u - s * v, s * u + c * v, o
            left, right = min(left, xy[n, 0]), max(right, xy[n, 0])
            low, high = min(low, xy[n, 1]), max(high, xy[n, 1])
            n += 1
    corner, width, height = np.zeros(2), 1, 1
    if n > 0:
        corner[0], corner[1] = left - CELL, low - CELL
        width, height = int((right - left) / CELL) + 3, int((high - low) / CELL) + 3
    cell, start = np.empty(n, np.int64), np.zeros(width * height + 1, np.int64)
    for k in range(n):
        cell[k] = int((xy[k, 1] - corner[1]) / CELL) * width + int((xy[k, 0] - corner[0]) / CELL)
        start[cell[k]] += 1
    for c in range(width * height):
        start[c + 1] += start[c]
    points, normals, owners = np.empty((n, 2)), np.empty((n, 2)), np.empty(n, np.int64)
    for k in range(n - 1, -1, -1):
        start[cell[k]] -= 1
        i = start[cell[k]]
        points[i, 0], points[i, 1] = xy[k, 0], xy[k, 1]
        normals[i, 0], normals[i, 1], owners[i] = normal[k, 0], normal[k, 1], owner[k]
    return LocalMap(points, normals, owners, start, corner, (width, height), len(members))


def register(
    scan: Surface, on: LocalMap, pose: np.ndarray, prior: np.ndarray, noise: float, reach: float, rounds: int = 12
) -> Match:
    """Where the scan fits on the map, from ``pose`` (3,) on.

    ``prior`` (3, 3) is the information of that first pose [1/m^2, 1/rad^2]; ``noise`` [m] the deviation of a point
    from its line; ``reach`` [m] how far off the first pose may be. Where the scan does not constrain a direction the
    first pose stands.
    """
    return Match(*_register(scan.points, scan.normals, on, np.asarray(pose, float), prior, noise, reach, rounds))


def unmatched(on: LocalMap, pose: np.ndarray) -> Match:
    """A scan at ``pose`` (3,) that says nothing of where it is on the map."""
    n = on.owners
    return Match(pose, np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros(n), 0.0)


@kernel
def likelihood(points, on, pose):  # type: ignore[no-untyped-def]
    """Mean over the scan's points (n, 2) of exp(-d^2 / (2 DEVIATION^2)), d the distance to the nearest of the map."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    width, height = on.shape
    total = 0.0
    for i in range(len(points)):
        x, y = c * points[i, 0] - s * points[i, 1] + pose[0], s * points[i, 0] + c * points[i, 1] + pose[1]
        column, row = int((x - on.corner[0]) // CELL), int((y - on.corner[1]) // CELL)
        first, last = max(0, column - 1), min(width - 1, column + 1)
        nearest = CELL * CELL
        for v in range(max(0, row - 1), min(height, row + 2)):
            if first <= last:
                for k in range(on.start[v * width + first], on.start[v * width + last + 1]):
                    dx, dy = x - on.points[k, 0], y - on.points[k, 1]
                    across = dx * on.normals[k, 0] + dy * on.normals[k, 1]
                    along = max(0.0, abs(dy * on.normals[k, 0] - dx * on.normals[k, 1]) - 0.5 * FILL)
                    nearest = min(nearest, across * across + along * along)
        total += np.exp(-0.5 * nearest / (DEVIATION * DEVIATION))
    return total / max(1, len(points))


@inner
def linearise(points, normals, on, pose, reach, noise, information, gradient, pairs):  # type: ignore[no-untyped-def]
    """Adds up the normal equations of all pairs, by keyframe of the map; returns how many points found one."""
    information.fill(0.0)
    gradient.fill(0.0)
    pairs.fill(0.0)
    c, s = np.cos(pose[2]), np.sin(pose[2])
    best, which = np.empty(on.owners), np.empty(on.owners, np.int64)
    width, height = on.shape
    ring = int(np.ceil(reach / CELL))
    found = 0
    for i in range(len(points)):
        rx, ry = c * points[i, 0] - s * points[i, 1], s * points[i, 0] + c * points[i, 1]
        nx, ny = c * normals[i, 0] - s * normals[i, 1], s * normals[i, 0] + c * normals[i, 1]
        x, y = rx + pose[0], ry + pose[1]
        known = nx != 0.0 or ny != 0.0
        column, row = int((x - on.corner[0]) // CELL), int((y - on.corner[1]) // CELL)
        best.fill(reach * reach)
        which.fill(-1)
        partners = 0
        for v in range(max(0, row - ring), min(height, row + ring + 1)):
            first, last = max(0, column - ring), min(width - 1, column + ring)
            if first > last:
                continue
            for k in range(on.start[v * width + first], on.start[v * width + last + 1]):
                o = on.owner[k]
                d = (x - on.points[k, 0]) ** 2 + (y - on.points[k, 1]) ** 2
                if d < best[o] and (not known or nx * on.normals[k, 0] + ny * on.normals[k, 1] > NORMALS_AGREE):
                    partners += which[o] < 0
                    best[o], which[o] = d, k
        if partners == 0:
            continue
        found += 1
        for o in range(on.owners):
            k = which[o]
            if k < 0:
                continue
            mx, my = on.normals[k, 0], on.normals[k, 1]
            turn = my * rx - mx * ry
            e = mx * (on.points[k, 0] - x) + my * (on.points[k, 1] - y)
            w = 1.0 / (1.0 + (e / (3.0 * noise)) ** 2)
            w = w * w / (partners * noise * noise)
            information[o, 0, 0] += w * mx * mx
            information[o, 0, 1] += w * mx * my
            information[o, 1, 1] += w * my * my
            information[o, 0, 2] += w * mx * turn
            information[o, 1, 2] += w * my * turn
            information[o, 2, 2] += w * turn * turn
            gradient[o, 0] += w * mx * e
            gradient[o, 1] += w * my * e
            gradient[o, 2] += w * turn * e
            pairs[o] += 1.0
    for o in range(on.owners):
        information[o, 1, 0] = information[o, 0, 1]
        information[o, 2, 0] = information[o, 0, 2]
        information[o, 2, 1] = information[o, 1, 2]
    return found


@kernel
def covariance(match):  # type: ignore[no-untyped-def]
    """(3, 3) covariance of a match's pose by its scan alone, map axes; some metres where the scan does not see."""
    information, gradient = np.zeros((3, 3)), np.zeros(3)
    for o in range(len(match.information)):
        for i in range(3):
            for j in range(3):
                information[i, j] += match.information[o, i, j]
    discount(information, gradient)
    for i in range(3):
        information[i, i] += UNSEEN
    return inverse(information)


@inner
def discount(information, gradient):  # type: ignore[no-untyped-def]
    """Takes off, along the least certain direction, the information that noisy normals pretend; in place.

    What is left has the same minimum (the direction is left to the prior, not pulled to where it stands).
    """
    covariance = inverse(information)
    step = times(covariance, gradient)
    angle = 0.5 * np.arctan2(2.0 * covariance[0, 1], covariance[0, 0] - covariance[1, 1])
    ux, uy = np.cos(angle), np.sin(angle)
    variance = ux * ux * covariance[0, 0] + 2.0 * ux * uy * covariance[0, 1] + uy * uy * covariance[1, 1]
    # all of 1 / variance would leave a singular matrix, and its inverse to the rounding
    off = min(FALSE_INFORMATION * (information[0, 0] + information[1, 1]), (1.0 - LEAST_LEFT) / variance)
    pull = off * (ux * step[0] + uy * step[1])
    information[0, 0] -= off * ux * ux
    information[0, 1] -= off * ux * uy
    information[1, 0] -= off * ux * uy
    information[1, 1] -= off * uy * uy
    gradient[0] -= pull * ux
    gradient[1] -= pull * uy


@kernel
def _register(points, normals, on, first, prior, noise, reach, rounds):  # type: ignore[no-untyped-def]
    pose, off = first.copy(), np.zeros(3)
    information, gradient, pairs = np.zeros((on.owners, 3, 3)), np.zeros((on.owners, 3)), np.zeros(on.owners)
    a, b = np.zeros((3, 3)), np.zeros(3)
    near, wide = reach, noise * 3.0
    for k in range(rounds):
        linearise(points, normals, on, pose, near, wide, information, gradient, pairs)
        a.fill(0.0)
        b.fill(0.0)
        for o in range(on.owners):
            for i in range(3):
                b[i] += gradient[o, i]
                for j in range(3):
                    a[i, j] += information[o, i, j]
        discount(a, b)
        off[0], off[1], off[2] = first[0] - pose[0], first[1] - pose[1], wrapped(first[2] - pose[2])
        pull = times(prior, off)
        w = 1.0 / (
            1.0 + (off[0] * pull[0] + off[1] * pull[1] + off[2] * pull[2]) / 9.0
        )  # contradicted, it has less say
        for i in range(3):
            b[i] += w * pull[i]
            for j in range(3):
                a[i, j] += w * prior[i, j]
        step = times(inverse(a), b)
        for i in range(3):
            pose[i] += step[i]
        small = abs(step[0]) + abs(step[1]) < 5e-4 and abs(step[2]) < 2e-4
        if small and near <= 0.5 * CELL and wide == noise:
            break
        if small or k >= 2:
            near, wide = max(0.5 * CELL, 0.5 * near), noise
    pose[2] = wrapped(pose[2])
    found = linearise(points, normals, on, pose, 0.5 * CELL, noise, information, gradient, pairs)
    return pose, information, gradient, pairs, found / max(1, len(points))
