"""What each line is worth: how much worse the scans would be predicted without it.

The paper names the trade-off of few lines against an accurate map (section IV-C) and leaves it to heuristics. Here a
line has a price, in readings told right, and stays as long as it is worth it. The worth of a line is exact: beams keep
all lines that they meet, so what a beam would meet without one is known, and lines go one by one, the least first.
"""

from __future__ import annotations

import heapq

import numpy as np

from rgcore.geometry import segments as geometry
from rgcore.geometry.compiled import inner, kernel

DEPTH = 8  # lines that a beam keeps: hardly ever more stand before, at or close behind its echo
FAR = 1.0  # m: a prediction that is off by more tells nothing (the penalty of the accuracy measure)
NEAR = 0.1  # m: one that is off by less is right
_LEVELS = (1.0, 0.75, 0.5, 0.25, 0.0)  # powers of the weights
_RIGHT = 0.4  # weight of being right within NEAR, against the square of the difference


class Sights:
    """The lines that each of the beams (N scans x B) meets, the nearest first.

    line     (N B, DEPTH) index, -1 = no more
    distance (N B, DEPTH) m
    along    (N B, DEPTH) m, from the start of the line
    """

    def __init__(
        self, poses: np.ndarray, bearings: np.ndarray, ranges: np.ndarray, weight: np.ndarray | None = None
    ) -> None:
        """``poses`` (N, 3) of the laser, ``bearings`` (B,) ascending, ``ranges`` (N, B) [m], 0 = not usable.

        ``weight`` (N,): for how many readings each of a scan counts; one, if nothing is said.
        """
        self.weight = np.ones(len(poses)) if weight is None else np.ascontiguousarray(weight, float)
        self.poses, self.bearings = np.ascontiguousarray(poses, float), np.ascontiguousarray(bearings, float)
        self.ranges = np.ascontiguousarray(ranges, float)
        self.reach = float(ranges.max(initial=0.0)) + FAR
        self.clear()

    def clear(self) -> None:
        shape = (self.ranges.size, DEPTH)
        self.line = np.full(shape, -1, np.int32)
        self.distance = np.full(shape, np.inf, np.float32)
        self.along = np.zeros(shape, np.float32)

    def add(self, lines: np.ndarray, number: int = 0) -> None:
        """Let the beams meet more lines (L, 2, 2), numbered from ``number`` on."""
        lines = np.ascontiguousarray(lines, float)
        first, worth = np.zeros(0, np.int64), np.zeros(0)
        self._meet(lines, number, first, 0.0, worth)

    def worthy(self, lines: np.ndarray, price: float, size: float) -> np.ndarray:
        """(K, 2, 2) the stretches of further lines (L, 2, 2) that would be worth their price, each alone."""
        first, worth = self._bins(lines, size)
        self._meet(lines, 0, first, size, worth)
        runs, of = _best(worth, first, price)
        return _cut(lines, runs, of, size)[0]

    def _meet(self, lines: np.ndarray, number: int, first: np.ndarray, size: float, worth: np.ndarray) -> None:
        lines, limits = np.ascontiguousarray(lines, float), (number, self.reach, size)
        beams = (self.poses, self.bearings, self.ranges, self.weight)
        _meet(lines, beams, limits, self.line, self.distance, self.along, first, worth)

    def unexplained(self, there: np.ndarray) -> np.ndarray:
        """(N, B) mask: echoes that come from before all lines of the mask ``there`` (L,), or from where none is."""
        return _unexplained(self.line, self.distance, self.ranges, there)

    def keep(self, there: np.ndarray, price: float) -> np.ndarray:
        """(L,) mask: the lines of ``there`` that are worth their ``price`` [readings]; the others go one by one."""
        limits = (price, np.inf, price)
        there = _keep(self.line, self.distance, self.ranges, self.weight, there.copy(), limits)
        _forget(self.line, self.distance, self.along, there)
        return there

    def few(self, count: int, price: float, most: int, highest: float) -> np.ndarray:
        """(L,) mask: those of ``count`` lines that are worth their ``price`` and, if they can be, at most ``most``.

        If they are more, the weights of the scans are levelled step by step; then the price rises, but not above
        ``highest``.
        """
        there = np.ones(count, bool)
        for level in _LEVELS:
            limits = (price, float(most), highest if level == _LEVELS[-1] else price)
            weight = self.weight**level
            there = _keep(self.line, self.distance, self.ranges, weight, np.ones(count, np.bool_), limits)
            if there.sum() <= most:
                break
        return there

    def stretches(self, lines: np.ndarray, price: float, size: float) -> tuple[np.ndarray, np.ndarray]:
        """(K, 2, 2) the stretches of the lines worth most together, each for its price, and the line of each (K,).

        ``size`` [m] is how finely lines are cut. What nobody looked at stays. The least worth are cut first: of two
        lines that explain the same readings one stays.
        """
        first, worth = self._bins(lines, size)
        runs, of = _stretches(
            self.line, self.distance, self.along, self.ranges, self.weight, first, (size, price), worth
        )
        order = np.lexsort((runs[:, 0], of))
        return _cut(lines, runs[order], of[order], size)

    @staticmethod
    def _bins(lines: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray]:
        """Stretches of all lines: those of line k are ``first[k]:first[k + 1]``; and room for their worth."""
        count = np.maximum(1, np.ceil(geometry.lengths(lines) / size)).astype(np.int64)
        first = np.concatenate([[0], np.cumsum(count)])
        return first, np.zeros(first[-1])


def _cut(lines: np.ndarray, runs: np.ndarray, of: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Stretches ``runs`` (K, 2) [bins] of the lines ``of`` (K,)."""
    length = geometry.lengths(lines)[of][:, None]
    t = np.minimum(runs * size, length) / length
    return lines[of, :1] + t[..., None] * (lines[of, 1:] - lines[of, :1]), of


@kernel
def _meet(lines, beams, limits, line, distance, along, first_of, worth):  # type: ignore[no-untyped-def]
    """Let the beams meet the lines; or, where there are ``first_of``, add up what they gain by each stretch."""
    poses, bearings, ranges, weight = beams
    number, reach, size = limits
    cos, sin, turn = np.cos(bearings), np.sin(bearings), 2 * np.pi
    n_beams, ahead = len(bearings), bearings[0] >= -0.5 * np.pi - 1e-3 and bearings[-1] <= 0.5 * np.pi + 1e-3
    for n in range(len(poses)):
        x, y, c, s = poses[n, 0], poses[n, 1], np.cos(poses[n, 2]), np.sin(poses[n, 2])
        for k in range(len(lines)):
            dx, dy = lines[k, 0, 0] - x, lines[k, 0, 1] - y
            ax, ay = c * dx + s * dy, c * dy - s * dx
            dx, dy = lines[k, 1, 0] - x, lines[k, 1, 1] - y
            bx, by = c * dx + s * dy, c * dy - s * dx
            if ahead and ax < -0.01 and bx < -0.01:
                continue
            if (min(abs(ax), abs(bx)) > reach and ax * bx > 0) or (min(abs(ay), abs(by)) > reach and ay * by > 0):
                continue
            area = ax * by - ay * bx
            flipped = area < 0.0
            if flipped:
                ax, ay, bx, by, area = bx, by, ax, ay, -area
            ex, ey = bx - ax, by - ay
            length = np.sqrt(ex * ex + ey * ey)
            if area > reach * length or area <= 1e-9 * length:  # too far, or seen edge on
                continue
            first, last = np.arctan2(ay, ax), np.arctan2(by, bx)
            if last < first:
                last += turn
            for shift in range(-1, 2):
                i = np.searchsorted(bearings, first + shift * turn - 1e-12)
                while i < n_beams and bearings[i] <= last + shift * turn + 1e-12:
                    down = cos[i] * ey - sin[i] * ex
                    if down > 0.0 and ranges[n, i] > 0.0 and area < (ranges[n, i] + FAR) * down:
                        r = area / down
                        at = ((cos[i] * r - ax) * ex + (sin[i] * r - ay) * ey) / length
                        at = length - at if flipped else at
                        b = n * n_beams + i
                        if len(first_of) == 0:
                            _insert(b, number + k, r, at, line, distance, along)
                        elif r < distance[b, 0]:
                            gain = cost(line[b, 0] >= 0, distance[b, 0], ranges[n, i]) - cost(True, r, ranges[n, i])
                            worth[min(first_of[k] + int(max(at, 0.0) / size), first_of[k + 1] - 1)] += weight[n] * gain
                    i += 1


@inner
def _insert(b, k, r, at, line, distance, along):  # type: ignore[no-untyped-def]
    j = DEPTH - 1
    if r >= distance[b, j]:
        return
    while j > 0 and distance[b, j - 1] > r:
        line[b, j], distance[b, j], along[b, j] = line[b, j - 1], distance[b, j - 1], along[b, j - 1]
        j -= 1
    line[b, j], distance[b, j], along[b, j] = k, r, at


@kernel
def _forget(line, distance, along, there):  # type: ignore[no-untyped-def]
    """Take the lines that are gone from the beams."""
    for b in range(len(line)):
        left = 0
        for j in range(DEPTH):
            k = line[b, j]
            if k >= 0 and there[k]:
                line[b, left], distance[b, left], along[b, left] = k, distance[b, j], along[b, j]
                left += 1
        for j in range(left, DEPTH):
            line[b, j], distance[b, j] = -1, np.inf


def lost(off: np.ndarray) -> np.ndarray:
    """What is lost of readings that are predicted ``off`` [m]: 0 to 1; inf where nothing is predicted."""
    far, near = np.minimum(off / FAR, 1.0), np.minimum(off / NEAR, 1.0)
    return np.asarray((1.0 - _RIGHT) * far * far + _RIGHT * near * near)


@inner
def cost(hit, r, z):  # type: ignore[no-untyped-def]
    """What is lost of a reading z where r is predicted, or nothing: 0 to 1."""
    if not hit:
        return 1.0
    d = abs(r - z)
    far, near = min(d / FAR, 1.0), min(d / NEAR, 1.0)
    return (1.0 - _RIGHT) * far * far + _RIGHT * near * near


@inner
def _first_two(line, b, there):  # type: ignore[no-untyped-def]
    """The first two lines that are there among those that beam b meets, or -1."""
    one = -1
    for j in range(DEPTH):
        k = line[b, j]
        if k < 0:
            break
        if there[k]:
            if one >= 0:
                return one, j
            one = j
    return one, -1


@kernel
def _unexplained(line, distance, ranges, there):  # type: ignore[no-untyped-def]
    out = np.zeros(ranges.shape, np.bool_)
    for n in range(ranges.shape[0]):
        for i in range(ranges.shape[1]):
            b = n * ranges.shape[1] + i
            j, _ = _first_two(line, b, there)
            out[n, i] = ranges[n, i] > 0.0 and (j < 0 or distance[b, j] > ranges[n, i] + NEAR)
    return out


@inner
def beams_by_line(line, there):  # type: ignore[no-untyped-def]
    """The beams that meet each line that is there: those of k are ``beams[first[k]:first[k + 1]]``."""
    first = np.zeros(len(there) + 2, np.int64)
    for filling in range(2):  # count, then fill
        if filling:
            for k in range(len(there)):
                first[k + 2] += first[k + 1]
        beams = np.zeros(first[-1] if filling else 0, np.int64)
        for b in range(len(line)):
            for j in range(DEPTH):
                k = line[b, j]
                if k >= 0 and there[k]:
                    if filling:
                        beams[first[k + 1]] = b
                    first[k + 1 if filling else k + 2] += 1
    return first, beams


@kernel
def _keep(line, distance, ranges, weight, there, limits):  # type: ignore[no-untyped-def]
    price, most, highest = limits
    z, n_beams = ranges.ravel(), ranges.shape[1]
    count = len(there)
    worth, version, left = np.zeros(count), np.zeros(count, np.int64), 0
    first, beams = beams_by_line(line, there)
    for k in range(count):
        left += there[k]
    for b in range(len(z)):
        _give(line, distance, b, z[b], there, worth, weight[b // n_beams])
    heap = [(worth[k], k, 0) for k in range(count) if there[k]]
    heapq.heapify(heap)
    while len(heap) > 0:
        least, k, of = heapq.heappop(heap)
        if not there[k] or of != version[k]:
            continue
        if least >= price and (left <= most or least >= highest):
            break
        left -= 1
        others = {k}
        for e in range(first[k], first[k + 1]):
            b = beams[e]
            others.add(_give(line, distance, b, z[b], there, worth, -weight[b // n_beams]))
        there[k] = False
        for e in range(first[k], first[k + 1]):
            b = beams[e]
            others.add(_give(line, distance, b, z[b], there, worth, weight[b // n_beams]))
        for other in others:
            if other >= 0 and there[other]:
                version[other] += 1
                heapq.heappush(heap, (worth[other], other, version[other]))
    return there


@inner
def _give(line, distance, b, z, there, worth, weight):  # type: ignore[no-untyped-def]
    """Add what beam b gains, times its ``weight``, by the first line that it meets; that line, or -1."""
    one, two = _first_two(line, b, there)
    if one < 0:
        return -1
    worth[line[b, one]] += weight * (cost(two >= 0, distance[b, two], z) - cost(True, distance[b, one], z))
    return np.int64(line[b, one])


@kernel
def _stretches(line, distance, along, ranges, weight, first, limits, worth):  # type: ignore[no-untyped-def]
    """Cut the lines one by one, the least worth first: stretches (K, 2) [bins] that are left, and their lines."""
    size, price = limits
    z, n_beams, count = ranges.ravel(), ranges.shape[1], len(first) - 1
    there, gone = np.ones(count, np.bool_), np.zeros(line.shape, np.bool_)
    start, beams = beams_by_line(line, there)
    total = np.zeros(count)
    for b in range(len(z)):
        _give(line, distance, b, z[b], there, total, weight[b // n_beams])
    runs, of, n = np.zeros((len(worth), 2), np.int64), np.zeros(len(worth), np.int64), 0
    began, ended = np.zeros(len(worth), np.bool_), np.zeros(len(worth), np.bool_)
    for k in np.argsort(total):
        for e in range(start[k], start[k + 1]):
            b = beams[e]
            one, two = -1, -1
            for j in range(DEPTH):
                if line[b, j] < 0 or two >= 0:
                    break
                if not gone[b, j]:
                    one, two = (j, two) if one < 0 else (one, j)
            if one >= 0 and line[b, one] == k:
                at = min(first[k] + int(along[b, one] / size), first[k + 1] - 1)
                gain = cost(two >= 0, distance[b, two], z[b]) - cost(True, distance[b, one], z[b])
                worth[at] += weight[b // n_beams] * gain
        before = n
        n = _best_of(k, worth, first, price, began, ended, runs, of, n)
        for e in range(start[k], start[k + 1]):
            b = beams[e]
            for j in range(DEPTH):
                if line[b, j] == k:
                    at = min(int(along[b, j] / size), first[k + 1] - first[k] - 1)
                    gone[b, j] = True
                    for r in range(before, n):
                        if runs[r, 0] <= at < runs[r, 1]:
                            gone[b, j] = False
    return runs[:n], of[:n]


@kernel
def _best(worth, first, price):  # type: ignore[no-untyped-def]
    """Stretches (K, 2) [bins] that are worth most, less a price each, and their lines: by dynamic programming."""
    runs, of, n = np.zeros((len(worth), 2), np.int64), np.zeros(len(worth), np.int64), 0
    began, ended = np.zeros(len(worth), np.bool_), np.zeros(len(worth), np.bool_)
    for k in range(len(first) - 1):
        n = _best_of(k, worth, first, price, began, ended, runs, of, n)
    return runs[:n], of[:n]


@inner
def _best_of(k, worth, first, price, began, ended, runs, of, n):  # type: ignore[no-untyped-def]
    """Append the stretches of line k to the n in ``runs`` and ``of``; how many there are then."""
    out, within = 0.0, -np.inf  # the best up to here, if here nothing is there, or something
    for b in range(first[k], first[k + 1]):
        began[b], ended[b] = out - price > within, within > out
        out, within = max(out, within), max(out - price, within) + worth[b] + 1e-6  # what nobody saw stays
    there, fresh = within > out, True
    for b in range(first[k + 1] - 1, first[k] - 1, -1):
        if not there:
            there = ended[b]
            continue
        if fresh:
            of[n], runs[n, 1] = k, b + 1 - first[k]
            n += 1
        runs[n - 1, 0] = b - first[k]
        there = not began[b]
        fresh = not there
    return n
