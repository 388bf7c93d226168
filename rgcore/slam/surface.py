"""Surface points: what a scan shows of surfaces, evenly spaced and with normals, ready to be registered."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rgcore.geometry.compiled import inner, kernel

FILL = 0.2
"""Points of a filled surface lie no farther apart than this [m]: what lies between two echoes of a wall is wall."""
STRAIGHT, OFF = 0.98, 0.06
"""Two echoes in a row are of one straight wall when the cosine between their normals is larger, and one lies no farther
[m] from the line of the other.
"""
BEAMS = 0.04
"""[rad] and no beam, or some lost ones, pass between."""


class Surface(NamedTuple):
    """Points (n, 2) [m] of one scan and their unit normals (n, 2) towards the laser; a normal of zeros is unknown."""

    points: np.ndarray
    normals: np.ndarray


class Surfaces(NamedTuple):
    """The surfaces of many scans in one: those of scan k are ``start[k]..start[k + 1]`` of points and normals (P,
    2).
    """

    points: np.ndarray
    normals: np.ndarray
    start: np.ndarray


def surface(ranges: np.ndarray, bearings: np.ndarray, max_range: float, spacing: float) -> Surface:
    """The surface points of one scan, laser frame, about ``spacing`` [m] apart or more.

    A beam without an echo gives no point. Normals are those of the total least squares line through the neighbouring
    echoes, where these lie on a line.
    """
    points, normals = np.empty((len(ranges), 2)), np.zeros((len(ranges), 2))
    n = _surface(ranges, bearings, max_range, spacing, points, normals)
    return Surface(points[:n], normals[:n])


def filled(scan: Surface) -> Surface:
    """The surface with points between those of a wall that is far away or seen aslant.

    On a map of echoes alone a scan would fit best where its echoes lie on those of the map: where the robot stood, not
    where it is.
    """
    points, normals = scan
    step = np.diff(points, axis=0)
    apart, square = np.sqrt((step**2).sum(1)), (points[:-1] ** 2).sum(1)
    same = (normals[:-1] * normals[1:]).sum(1) > STRAIGHT
    same &= np.abs((normals[:-1] * step).sum(1)) < OFF
    same &= apart * np.abs((normals[:-1] * points[:-1]).sum(1)) < BEAMS * square
    many = np.append(np.where(same, 1 + (apart / FILL).astype(np.int64), 1), 1)[: len(points)]
    of = np.repeat(np.arange(len(points)), many)
    share = (np.arange(len(of)) - np.repeat(np.cumsum(many) - many, many)) / many[of]
    return Surface(points[of] + share[:, None] * np.append(step, [[0.0, 0.0]], 0)[of], normals[of])


@kernel
def _surface(ranges, bearings, max_range, spacing, points, normals):  # type: ignore[no-untyped-def]
    """Writes the points and normals; returns how many."""
    n = 0
    xy = np.empty((len(ranges), 2))
    gap = np.empty(len(ranges))  # farthest that the neighbours of an echo on the same surface may lie
    step = abs(bearings[-1] - bearings[0]) / max(1, len(bearings) - 1)
    for i in range(len(ranges)):
        r = ranges[i]
        if 0.0 < r < max_range and np.isfinite(r):
            xy[n, 0], xy[n, 1] = r * np.cos(bearings[i]), r * np.sin(bearings[i])
            gap[n] = max(0.15, 3.0 * r * step)
            n += 1
    kept, way = 0, 0.0
    for i in range(n):
        # the spacing is that of its neighbours: chosen by its own noise, the echoes that lie farther would be kept more
        # often, to the right of what they show, and a straight corridor would seem to bend
        before, after = max(0, i - 2), min(n - 1, i + 2)
        way += np.hypot(xy[after, 0] - xy[before, 0], xy[after, 1] - xy[before, 1]) / max(1, after - before)
        if kept > 0 and way < spacing:
            continue
        way = 0.0
        points[kept, 0], points[kept, 1] = xy[i, 0], xy[i, 1]
        lo, hi = i, i
        while lo > 0 and _near(xy, lo - 1, lo, gap[i]) and _near(xy, lo - 1, i, gap[i]):
            lo -= 1
        while hi < n - 1 and _near(xy, hi + 1, hi, gap[i]) and _near(xy, hi + 1, i, gap[i]):
            hi += 1
        if hi - lo >= 2:
            _fit_normal(xy, lo, hi, normals, kept)
        kept += 1
    return kept


@inner
def _near(xy, i, j, distance):  # type: ignore[no-untyped-def]
    return (xy[i, 0] - xy[j, 0]) ** 2 + (xy[i, 1] - xy[j, 1]) ** 2 < distance * distance


@inner
def _fit_normal(xy, lo, hi, normals, k):  # type: ignore[no-untyped-def]
    """Writes normal k, that of the line through echoes lo..hi, if they make one."""
    m = hi - lo + 1
    cx, cy = 0.0, 0.0
    for i in range(lo, hi + 1):
        cx += xy[i, 0]
        cy += xy[i, 1]
    cx, cy = cx / m, cy / m
    sxx, sxy, syy = 0.0, 0.0, 0.0
    for i in range(lo, hi + 1):
        dx, dy = xy[i, 0] - cx, xy[i, 1] - cy
        sxx += dx * dx
        sxy += dx * dy
        syy += dy * dy
    along = 0.5 * (sxx + syy + np.sqrt((sxx - syy) ** 2 + 4.0 * sxy * sxy))
    across = sxx + syy - along
    if across > 0.04 * along or across > m * 0.04**2:  # a corner, a round or a jumble has no one normal
        return
    angle = 0.5 * np.arctan2(2.0 * sxy, sxx - syy)
    nx, ny = -np.sin(angle), np.cos(angle)
    if nx * cx + ny * cy > 0.0:
        nx, ny = -nx, -ny
    normals[k, 0], normals[k, 1] = nx, ny
