"""Where later scans see *through* a line: beams that cross it and end well behind."""

from __future__ import annotations

import numpy as np

from rgcore.geometry.compiled import inner, kernel

_CELL = 0.5  # m, of the raster over the lines
_FARTHEST = 200.0  # m: a bound on the walk, whatever the input
_SLANT = np.sin(np.deg2rad(12.0))  # a beam nearly along a line crosses it or not by chance


def count_passes(
    lines: np.ndarray,
    first_bin: np.ndarray,
    bin_size: float,
    segments: np.ndarray,
    eyes: np.ndarray,
    points: np.ndarray,
    margin: float,
) -> np.ndarray:
    """Beams through each stretch of each line: (K,) for all stretches of ``bin_size`` [m] of all lines.

    The stretches of line l are ``first_bin[l]:first_bin[l + 1]``, from its start on. Beams run from the lasers
    ``eyes`` (M, 2) to the segments (M, 2, 2) of ``points`` (M,) echoes that they saw; those that end within
    ``margin`` [m] behind a line do not count. All in the map frame.
    """
    origin = np.minimum(lines.min((0, 1)), eyes.min(0)) - _CELL
    extent = np.maximum(lines.max((0, 1)), eyes.max(0)) + _CELL - origin
    cell = max(_CELL, float(extent.max()) / 2000)  # bounds the raster where the lines lie far apart
    shape = (int(extent[0] / cell) + 1, int(extent[1] / cell) + 1)
    first, members = _rasterize(lines, origin, cell, shape)
    return _count(
        lines,
        first_bin,
        bin_size,
        segments,
        eyes,
        points,
        margin,
        origin,
        cell,
        shape,
        first,
        members,
    )


@kernel
def _rasterize(lines, origin, cell, shape):  # type: ignore[no-untyped-def]
    """Lines by cell: those of cell c are ``members[first[c]:first[c + 1]]``."""
    ny = shape[1]
    first = np.zeros(shape[0] * ny + 1, np.int64)
    members = np.zeros(0, np.int64)
    for filling in range(2):  # count, then fill
        if filling:
            total = 0
            for c in range(len(first)):
                total, first[c] = total + first[c], total
            members = np.zeros(total, np.int64)
        for i in range(len(lines)):
            ax, ay = (lines[i, 0, 0] - origin[0]) / cell, (lines[i, 0, 1] - origin[1]) / cell
            bx, by = (lines[i, 1, 0] - origin[0]) / cell, (lines[i, 1, 1] - origin[1]) / cell
            dx, dy = bx - ax, by - ay
            slack = 0.5 * (abs(dx) + abs(dy)) + 1e-9
            for ix in range(int(min(ax, bx)), int(max(ax, bx)) + 1):
                for iy in range(int(min(ay, by)), int(max(ay, by)) + 1):
                    if abs((ix + 0.5 - ax) * dy - (iy + 0.5 - ay) * dx) <= slack:
                        c = ix * ny + iy
                        if filling:
                            members[first[c]] = i
                        first[c] += 1
    for c in range(len(first) - 1, 0, -1):  # filling moved each start to the next
        first[c] = first[c - 1]
    first[0] = 0
    return first, members


@kernel
def _count(lines, first_bin, bin_size, segments, eyes, points, margin, origin, cell, shape, first, members):  # type: ignore[no-untyped-def]
    passes = np.zeros(first_bin[-1])
    for m in range(len(segments)):
        ax, ay = segments[m, 0, 0] - eyes[m, 0], segments[m, 0, 1] - eyes[m, 1]
        bx, by = segments[m, 1, 0] - eyes[m, 0], segments[m, 1, 1] - eyes[m, 1]
        area = ax * by - ay * bx
        n = points[m]
        first_angle, angle = np.arctan2(ay, ax), np.arctan2(area, ax * bx + ay * by)
        for k in range(n):
            turn = first_angle + (k + 0.5) / n * angle
            ux, uy = np.cos(turn), np.sin(turn)
            reach = area / (ux * (by - ay) - uy * (bx - ax)) - margin
            if 0.0 < reach < _FARTHEST:
                beam = (eyes[m, 0], eyes[m, 1], ux, uy, reach)
                _walk(beam, lines, first_bin, bin_size, passes, origin, cell, shape, first, members)
    return passes


@inner
def _walk(beam, lines, first_bin, bin_size, passes, origin, cell, shape, first, members):  # type: ignore[no-untyped-def]
    """Add one beam to all stretches that it crosses, walking the raster cell by cell (Amanatides & Woo 1987)."""
    px, py, ux, uy, reach = beam
    x, y = px - origin[0], py - origin[1]
    ix, iy = int(x / cell), int(y / cell)
    each_x = cell / abs(ux) if ux != 0.0 else np.inf
    each_y = cell / abs(uy) if uy != 0.0 else np.inf
    next_x = ((ix + (ux > 0)) * cell - x) / ux if ux != 0.0 else np.inf
    next_y = ((iy + (uy > 0)) * cell - y) / uy if uy != 0.0 else np.inf
    enter = 0.0
    while enter < reach and 0 <= ix < shape[0] and 0 <= iy < shape[1]:  # beyond the raster there are no lines
        leave = min(next_x, next_y, reach)
        c = ix * shape[1] + iy
        for k in range(first[c], first[c + 1]):
            i = members[k]
            dx, dy = lines[i, 1, 0] - lines[i, 0, 0], lines[i, 1, 1] - lines[i, 0, 1]
            length = np.hypot(dx, dy)
            across = ux * dy - uy * dx
            if abs(across) < _SLANT * length:
                continue
            sx, sy = lines[i, 0, 0] - px, lines[i, 0, 1] - py
            t, s = (sx * dy - sy * dx) / across, (sx * uy - sy * ux) / across
            if enter <= t < leave and 0.0 <= s <= 1.0:  # each crossing lies in one cell, so it counts once
                b = min(first_bin[i] + int(s * length / bin_size), first_bin[i + 1] - 1)
                passes[b] += 1.0
        enter = leave
        if next_x < next_y:
            ix += 1 if ux > 0 else -1
            next_x += each_x
        else:
            iy += 1 if uy > 0 else -1
            next_y += each_y
