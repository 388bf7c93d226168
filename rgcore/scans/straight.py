"""Split and merge: the straight pieces of a scan; the compiled inner loops of the extraction.

A scan is broken where neighbouring echoes lie too far apart (the adaptive breakpoint of Borges & Aldon 2004, so that a
wall seen at grazing incidence holds together), each cluster is split at its corners, corners are settled echo by echo,
and collinear neighbours are joined again where nothing was seen *through* the gap between them (missing echoes, a chair
leg in front of the wall). Every piece is a total least squares fit; its ends are its outermost echoes projected on it.

The echoes of a scan are ``x, y`` [m] with the index ``beam`` of each. A piece is ``pieces[p] = (first, last)`` echo
with the sums of its echoes in ``sums[p]``: count, x, y, xx, yy, xy. Plain loops over rows: they compile in a fraction
of the time of array expressions.
"""

from __future__ import annotations

import numpy as np

from rgcore.geometry.compiled import inner, kernel

_INCIDENCE = np.deg2rad(10.0)  # lambda of Borges & Aldon: a wall seen at less than this cannot be told from a jump
_GRAZING = np.sin(np.deg2rad(8.0))  # nowhere seen at more: a chain of mixed pixels, or of things behind one another
_KNOWN = 4.0  # degrees of freedom that the known noise of the laser is worth beside a segment's own residuals
_LEAST_SHARE = 0.04  # of the variance of a range, across a line at grazing incidence: the footprint of the beam
_LOOK_AHEAD = 3  # pieces: a wall goes on behind up to two things in front of it


@kernel
def split_and_merge(ranges, bearings, step, ring, limits, min_points):  # type: ignore[no-untyped-def]
    """All scans (N, B): (M, 8) start, end, rms, covariance and (M, 4) scan, first beam, last beam, echoes.

    ``step`` [rad] between neighbouring beams; ``ring``: the last beam and the first are neighbours; ``limits``:
    max_range, cluster_distance, point_line_distance, variance, min_length, noise [m].
    """
    n_scans, n_beams = ranges.shape
    numbers = np.zeros((n_scans * (n_beams // min_points + 1), 8))
    indices = np.zeros((len(numbers), 4), np.int64)
    cos, sin = np.cos(bearings), np.sin(bearings)
    beam, x, y = np.zeros(n_beams, np.int64), np.zeros(n_beams), np.zeros(n_beams)
    prefix = np.zeros((n_beams + 1, 6))  # sums of the echoes before each: any run of echoes is fitted in constant time
    sums = np.zeros((n_beams + 3, 6))  # of each piece, and two rows for trying
    pieces, stack = np.zeros((n_beams + 1, 2), np.int64), np.zeros((n_beams + 1, 2), np.int64)
    m = 0
    for scan in range(n_scans):
        k = _echoes(ranges, scan, cos, sin, limits[0], 0, beam, x, y)
        if ring and k > 0:
            start = beam[_seam(x, y, beam, k, n_beams, step, limits[1])]
            k = _echoes(ranges, scan, cos, sin, limits[0], start, beam, x, y)
        _accumulate(x, y, k, prefix)
        n, start = 0, 0
        for i in range(1, k + 1):
            if i == k or _is_break(x, y, beam, i - 1, i, n_beams, step, limits[1]):
                n = _split(x, y, prefix, start, i - 1, limits, sums, stack, pieces, n)
                start = i
        _settle_corners(x, y, prefix, sums, pieces, n)
        n = _join(ranges, scan, cos, sin, step, beam, x, y, prefix, pieces, n, sums, limits)
        for p in range(n):
            if sums[p, 0] >= min_points and _lay(x, y, pieces[p, 0], pieces[p, 1], sums, p, limits, numbers, m):
                indices[m, 0], indices[m, 3] = scan, int(sums[p, 0])
                indices[m, 1], indices[m, 2] = beam[pieces[p, 0]], beam[pieces[p, 1]]
                m += 1
    return numbers[:m], indices[:m]


@inner
def _echoes(ranges, scan, cos, sin, max_range, start, beam, x, y):  # type: ignore[no-untyped-def]
    """Fill in the echoes of a scan from beam ``start`` on; their number."""
    n_beams, k = len(cos), 0
    for q in range(n_beams):
        j = (start + q) % n_beams
        r = ranges[scan, j]
        if r > 0 and r < max_range:  # false for nan
            beam[k], x[k], y[k] = j, r * cos[j], r * sin[j]
            k += 1
    return k


@inner
def _seam(x, y, beam, k, n_beams, step, cluster_distance):  # type: ignore[no-untyped-def]
    """The echo to begin a full circle with so that no wall runs across its seam."""
    start, far = 0, 0.0
    for i in range(k):
        if _is_break(x, y, beam, (i - 1) % k, i, n_beams, step, cluster_distance):
            return i
        if x[i] * x[i] + y[i] * y[i] > far:  # in a closed room without a break: the farthest corner
            start, far = i, x[i] * x[i] + y[i] * y[i]
    return start


@inner
def _is_break(x, y, beam, i, j, n_beams, step, cluster_distance):  # type: ignore[no-untyped-def]
    """Do the neighbouring echoes i and j belong to different things? (Borges & Aldon 2004; forgives a missing beam.)"""
    angle = step * min(2, (beam[j] - beam[i]) % n_beams)
    r = np.sqrt(min(x[i] * x[i] + y[i] * y[i], x[j] * x[j] + y[j] * y[j]))
    limit = cluster_distance
    if angle < 0.5 * _INCIDENCE:
        limit = max(limit, r * np.sin(angle) / np.sin(_INCIDENCE - angle))
    return (x[j] - x[i]) ** 2 + (y[j] - y[i]) ** 2 > limit * limit


@inner
def _accumulate(x, y, k, prefix):  # type: ignore[no-untyped-def]
    for i in range(k):
        prefix[i + 1, 0] = i + 1
        prefix[i + 1, 1] = prefix[i, 1] + x[i]
        prefix[i + 1, 2] = prefix[i, 2] + y[i]
        prefix[i + 1, 3] = prefix[i, 3] + x[i] * x[i]
        prefix[i + 1, 4] = prefix[i, 4] + y[i] * y[i]
        prefix[i + 1, 5] = prefix[i, 5] + x[i] * y[i]


@inner
def _fit(sums, p):  # type: ignore[no-untyped-def]
    """Total least squares line of the echoes in row p: centre, unit direction, root mean square distance."""
    n = sums[p, 0]
    cx, cy = sums[p, 1] / n, sums[p, 2] / n
    xx, yy, xy = sums[p, 3] / n - cx * cx, sums[p, 4] / n - cy * cy, sums[p, 5] / n - cx * cy
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    spread = np.sqrt((xx - yy) ** 2 + 4 * xy * xy)
    return cx, cy, np.cos(angle), np.sin(angle), np.sqrt(max(0.0, 0.5 * (xx + yy - spread)))


@inner
def _fit_run(prefix, i, j, sums, row):  # type: ignore[no-untyped-def]
    """The same of the run of echoes i..j; their sums go into ``row``."""
    for q in range(6):
        sums[row, q] = prefix[j + 1, q] - prefix[i, q]
    return _fit(sums, row)


@inner
def _distance(line, x, y):  # type: ignore[no-untyped-def]
    return abs((y - line[1]) * line[2] - (x - line[0]) * line[3])


@inner
def _split(x, y, prefix, first, last, limits, sums, stack, pieces, n):  # type: ignore[no-untyped-def]
    """Split echoes first..last until each piece is straight; appends them to ``pieces``, gives the new count."""
    stack[0, 0], stack[0, 1] = first, last
    top = 1
    while top > 0:
        top -= 1
        i, j = stack[top, 0], stack[top, 1]
        if j - i < 2 or _is_straight(x, y, prefix, i, j, limits, sums):
            pieces[n, 0], pieces[n, 1] = i, j
            n += 1
            continue
        at = _corner(x, y, i, j)
        stack[top, 0], stack[top, 1] = at + 1, j
        stack[top + 1, 0], stack[top + 1, 1] = i, at
        top += 2
    return n


@inner
def _is_straight(x, y, prefix, i, j, limits, sums):  # type: ignore[no-untyped-def]
    line = _fit_run(prefix, i, j, sums, len(sums) - 1)
    if line[4] > limits[3]:
        return False
    worst = 0.0
    for q in range(i, j + 1):
        worst = max(worst, _distance(line, x[q], y[q]))
    return worst <= limits[2]


@inner
def _corner(x, y, i, j):  # type: ignore[no-untyped-def]
    """The echo after which to split i..j: the one farthest from the chord."""
    dx, dy = x[j] - x[i], y[j] - y[i]
    at, far = i, -1.0
    for q in range(i + 1, j):
        d = abs((y[q] - y[i]) * dx - (x[q] - x[i]) * dy)
        if d > far:
            at, far = q, d
    return at


@inner
def _settle_corners(x, y, prefix, sums, pieces, n):  # type: ignore[no-untyped-def]
    """Hand the echoes at a common corner to the line that they lie nearer to."""
    for p in range(n - 1):
        first, end, last = pieces[p, 0], pieces[p, 1], pieces[p + 1, 1]
        if end + 1 != pieces[p + 1, 0] or end - first < 2 or last - end < 3:
            continue
        a = _fit_run(prefix, first, end - 1, sums, len(sums) - 1)  # without the echo at the corner
        b = _fit_run(prefix, end + 2, last, sums, len(sums) - 1)
        while end - first > 1 and _distance(a, x[end], y[end]) > _distance(b, x[end], y[end]):
            end -= 1
        while last - end > 2 and _distance(b, x[end + 1], y[end + 1]) > _distance(a, x[end + 1], y[end + 1]):
            end += 1
        pieces[p, 1], pieces[p + 1, 0] = end, end + 1


@inner
def _join(ranges, scan, cos, sin, step, beam, x, y, prefix, pieces, n, sums, limits):  # type: ignore[no-untyped-def]
    """Join collinear pieces, also past a thing in front of them; the number of pieces left, their sums in ``sums``."""
    left = 0
    for p in range(n):  # one or two echoes have no direction: they are what the others are joined across
        if pieces[p, 1] - pieces[p, 0] >= 2:
            pieces[left, 0], pieces[left, 1] = pieces[p, 0], pieces[p, 1]
            _fit_run(prefix, pieces[p, 0], pieces[p, 1], sums, left)
            left += 1
    p = 0
    while p < left:
        q = p + 1
        while q < left and q <= p + _LOOK_AHEAD:
            if not _is_one(ranges, scan, cos, sin, step, beam, x, y, pieces, p, q, sums, limits):
                q += 1
                continue
            pieces[p, 1] = pieces[q, 1]
            for c in range(6):
                sums[p, c] += sums[q, c]
            for r in range(q, left - 1):
                pieces[r, 0], pieces[r, 1] = pieces[r + 1, 0], pieces[r + 1, 1]
                for c in range(6):
                    sums[r, c] = sums[r + 1, c]
            left -= 1
            q = p + 1
        p += 1
    return left


@inner
def _is_one(ranges, scan, cos, sin, step, beam, x, y, pieces, p, q, sums, limits):  # type: ignore[no-untyped-def]
    """Are pieces p and q the same straight thing, with nothing seen through the gap between them?"""
    row = len(sums) - 2
    for c in range(6):
        sums[row, c] = sums[p, c] + sums[q, c]
    line = _fit(sums, row)
    if line[4] > limits[3]:
        return False
    for e in range(2):
        i, j = pieces[p, e], pieces[q, e]
        if _distance(line, x[i], y[i]) > limits[2] or _distance(line, x[j], y[j]) > limits[2]:
            return False
    i, j = pieces[p, 1], pieces[q, 0]
    offset = line[0] * line[3] - line[1] * line[2]  # signed distance of the line from the laser
    spacing = (x[i] * x[i] + y[i] * y[i]) * step / max(abs(offset), 1e-9)  # of echoes: range * step / sin(incidence)
    if np.sqrt((x[j] - x[i]) ** 2 + (y[j] - y[i]) ** 2) > max(limits[1], 2.5 * spacing):
        return False
    through, n_beams = 0, len(cos)
    for b in range(1, (beam[j] - beam[i]) % n_beams):
        k = (beam[i] + b) % n_beams
        r = ranges[scan, k]
        if r < limits[0] and r * abs(cos[k] * line[3] - sin[k] * line[2]) > abs(offset) + limits[2]:
            through += 1
    return through <= 1  # a single one is a mixed pixel


@inner
def _lay(x, y, i, j, sums, p, limits, numbers, m):  # type: ignore[no-untyped-def]
    """Write piece p, which runs from echo i to j, as segment m; False if it is none: bent, short or only grazed."""
    cx, cy, ux, uy, rms = _fit(sums, p)
    s = (x[i] - cx) * ux + (y[i] - cy) * uy
    e = (x[j] - cx) * ux + (y[j] - cy) * uy
    left = uy * cx - ux * cy  # distance of the laser from the line, positive to the left
    nearest = np.sqrt(min(x[i] * x[i] + y[i] * y[i], x[j] * x[j] + y[j] * y[j]))
    if abs(e - s) < limits[4] or rms > limits[3] or abs(left) < _GRAZING * nearest:
        return False
    if (left > 0) != (s < e):
        s, e = e, s
    numbers[m, 0], numbers[m, 1] = cx + s * ux, cy + s * uy
    numbers[m, 2], numbers[m, 3] = cx + e * ux, cy + e * uy
    numbers[m, 4] = rms
    _propagate(x, y, i, j, limits, numbers, m)
    return True


@inner
def _propagate(x, y, i, j, limits, numbers, m):  # type: ignore[no-untyped-def]
    """Covariance of segment m, which runs from echo i to j, about its middle: of offset, of both, of direction.

    The noise of a range counts by its share across the line (Diosi & Kleeman 2003): a wall that is grazed is sure
    across. What the residuals say of the noise is weighed against what is known of the laser.
    """
    mx, my = 0.5 * (numbers[m, 0] + numbers[m, 2]), 0.5 * (numbers[m, 1] + numbers[m, 3])
    ux, uy = numbers[m, 2] - mx, numbers[m, 3] - my
    half = np.sqrt(ux * ux + uy * uy)
    ux, uy = ux / half, uy / half
    offset = mx * uy - my * ux
    n, st, stt, sv, stv, sttv, chi = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for q in range(i, j + 1):
        across, t = (y[q] - my) * ux - (x[q] - mx) * uy, (x[q] - mx) * ux + (y[q] - my) * uy
        if abs(across) > limits[2]:  # a thing in front of the wall, or a mixed pixel
            continue
        v = limits[5] ** 2 * max(_LEAST_SHARE, offset * offset / (x[q] * x[q] + y[q] * y[q]))
        n, st, stt, chi = n + 1.0, st + t, stt + t * t, chi + across * across / v
        sv, stv, sttv = sv + v, stv + t * v, sttv + t * t * v
    scale = (_KNOWN + chi) / (_KNOWN + max(0.0, n - 2.0))
    t, spread = st / n, stt - st * st / n  # of the echoes about their centre
    mean, both = sv / (n * n), (stv - t * sv) / (n * spread)
    turn = (sttv - 2.0 * t * stv + t * t * sv) / (spread * spread)
    numbers[m, 5] = scale * (mean - 2.0 * t * both + t * t * turn)
    numbers[m, 6] = scale * (both - t * turn)
    numbers[m, 7] = scale * turn
