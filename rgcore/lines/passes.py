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
    """The beams of a segment are a fan: each line that a cell under it holds is asked once for all of them."""
    passes, asked, beams = np.zeros(first_bin[-1]), np.full(len(lines), -1), np.zeros((points.max(), 3))
    fan = np.zeros((3, 2))
    for m in range(len(segments)):
        ax, ay = segments[m, 0, 0] - eyes[m, 0], segments[m, 0, 1] - eyes[m, 1]
        bx, by = segments[m, 1, 0] - eyes[m, 0], segments[m, 1, 1] - eyes[m, 1]
        area = ax * by - ay * bx
        if area == 0.0:
            continue
        if area < 0.0:
            ax, ay, bx, by, area = bx, by, ax, ay, -area
        for k in range(2):
            start = (eyes[m, k] - origin[k]) / cell
            fan[0, k] = start
            fan[1, k] = start + (ax, ay)[k] / cell
            fan[2, k] = start + (bx, by)[k] / cell
        laid = False
        for ix in range(max(0, int(fan[:, 0].min())), min(shape[0] - 1, int(fan[:, 0].max())) + 1):
            low, high = _rows(fan, ix)
            for iy in range(max(0, int(low)), min(shape[1] - 1, int(high)) + 1):
                c = ix * shape[1] + iy
                for e in range(first[c], first[c + 1]):
                    i = members[e]
                    if asked[i] == m:
                        continue
                    asked[i] = m
                    if not _meets(lines[i], eyes[m], ax, ay, bx, by, area, margin):
                        continue
                    if not laid:
                        _lay(ax, ay, bx, by, area, margin, points[m], beams)
                        laid = True
                    _cross(lines[i], eyes[m], beams[: points[m]], passes[first_bin[i] : first_bin[i + 1]], bin_size)
    return passes


@inner
def _rows(fan, ix):  # type: ignore[no-untyped-def]
    """Between which y a triangle (3, 2) lies where x is in ix..ix + 1."""
    low, high = np.inf, -np.inf
    for k in range(3):
        x, y, ex, ey = fan[k, 0], fan[k, 1], fan[(k + 1) % 3, 0], fan[(k + 1) % 3, 1]
        if max(x, ex) < ix or min(x, ex) > ix + 1:
            continue
        for end in (max(ix, min(x, ex)), min(ix + 1, max(x, ex))):
            at = y + (ey - y) * (end - x) / (ex - x) if ex != x else y
            low, high = min(low, at), max(high, at)
        if ex == x:
            low, high = min(low, ey), max(high, ey)
    return low, high


@inner
def _meets(line, eye, ax, ay, bx, by, area, margin):  # type: ignore[no-untyped-def]
    """Whether some of a line may lie in the fan of beams that end ``margin`` before a segment a, b."""
    sx, sy, ex, ey = line[0, 0] - eye[0], line[0, 1] - eye[1], line[1, 0] - eye[0], line[1, 1] - eye[1]
    if (ax * sy < ay * sx and ax * ey < ay * ex) or (bx * sy > by * sx and bx * ey > by * ex):
        return False
    dx, dy = bx - ax, by - ay
    least = area * (1.0 - margin / np.sqrt(max(ax * ax + ay * ay, bx * bx + by * by)))
    return sx * dy - sy * dx < least or ex * dy - ey * dx < least


@inner
def _lay(ax, ay, bx, by, area, margin, n, beams):  # type: ignore[no-untyped-def]
    """Directions and lengths of the n beams to a segment."""
    step = np.arctan2(area, ax * bx + ay * by) / n
    c, s, first = np.cos(step), np.sin(step), np.arctan2(ay, ax) + 0.5 * step
    ux, uy = np.cos(first), np.sin(first)
    for k in range(n):
        reach = area / (ux * (by - ay) - uy * (bx - ax)) - margin
        beams[k, 0], beams[k, 1], beams[k, 2] = ux, uy, reach if reach < _FARTHEST else 0.0
        ux, uy = c * ux - s * uy, s * ux + c * uy


@inner
def _cross(line, eye, beams, passes, bin_size):  # type: ignore[no-untyped-def]
    """Adds the beams to the stretches of a line that they cross."""
    dx, dy = line[1, 0] - line[0, 0], line[1, 1] - line[0, 1]
    sx, sy = line[0, 0] - eye[0], line[0, 1] - eye[1]
    length = np.hypot(dx, dy)
    for k in range(len(beams)):
        across = beams[k, 0] * dy - beams[k, 1] * dx
        if abs(across) < _SLANT * length:
            continue
        t, s = (sx * dy - sy * dx) / across, (sx * beams[k, 1] - sy * beams[k, 0]) / across
        if 0.0 <= t < beams[k, 2] and 0.0 <= s <= 1.0:
            passes[min(int(s * length / bin_size), len(passes) - 1)] += 1.0
