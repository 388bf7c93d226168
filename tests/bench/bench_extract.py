"""Extraction beside published extractors, on one core: ``python tests/bench/bench_extract.py [LOG ...]``.

    ours          rgcore.scans.extract
    split+merge   iterative end point fit (Duda & Hart 1973), then merging of collinear neighbours
    incremental   line tracking (Siadat et al. 1997; Nguyen et al. 2007): a line takes the next echo while it fits
    polyline      maximum likelihood polylines (Schaefer et al., IROS 2018): all echoes are vertices; the one goes whose
                  removal costs least along the beams, while that is cheap. Lines are then fitted between the vertices,
                  in place of the moving of vertices by which the paper ends

All have the same limits and tolerances and are compiled; CPU time without compiling. Residuals are measured along the
beams, as the polyline paper does: predicted minus measured range, each echo by the best line among whose beams it is.
An echo counts as explained within 3 deviations of the log's range noise.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numba import njit
from rich.console import Console
from rich.table import Table

from rgcore.config import Extract
from rgcore.scans.extract import adapted, extract
from rgcore.scans.log import ScanLog
from rgcore.scans.read import read_log

LOGS = Path(__file__).parents[2] / "../shared/data/logs"
Found = tuple[np.ndarray, np.ndarray]
"""Lines by beams: (M, 3) scan, first and last beam; (M, 4) a point of each and its unit direction, laser frame."""


@njit(cache=True)
def _fit(x, y, i, j):  # type: ignore[no-untyped-def]
    """Total least squares line of echoes i..j: centre, direction, largest distance."""
    n = j - i + 1
    cx, cy = x[i : j + 1].mean(), y[i : j + 1].mean()
    xx, yy, xy = 0.0, 0.0, 0.0
    for q in range(i, j + 1):
        xx += (x[q] - cx) ** 2
        yy += (y[q] - cy) ** 2
        xy += (x[q] - cx) * (y[q] - cy)
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    ux, uy = np.cos(angle), np.sin(angle)
    worst = 0.0
    for q in range(i, j + 1):
        worst = max(worst, abs((y[q] - cy) * ux - (x[q] - cx) * uy))
    return cx, cy, ux, uy, worst, n


@njit(cache=True)
def _split_merge(x, y, i, j, tolerance, cuts):  # type: ignore[no-untyped-def]
    """Last echoes of the pieces of cluster i..j; their number."""
    stack = [(i, j)]
    n = 0
    while len(stack) > 0:
        a, b = stack.pop()
        dx, dy = x[b] - x[a], y[b] - y[a]
        length = max(np.hypot(dx, dy), 1e-9)
        worst, at = 0.0, a
        for q in range(a + 1, b):
            d = abs((y[q] - y[a]) * dx - (x[q] - x[a]) * dy) / length
            if d > worst:
                worst, at = d, q
        if worst > tolerance:
            stack.append((at + 1, b))
            stack.append((a, at))
        else:
            cuts[n] = b
            n += 1
    start, p = i, 0
    while p < n - 1:
        if _fit(x, y, start, cuts[p + 1])[4] <= tolerance:
            for q in range(p, n - 1):
                cuts[q] = cuts[q + 1]
            n -= 1
        else:
            start = cuts[p] + 1
            p += 1
    return n


@njit(cache=True)
def _incremental(x, y, i, j, tolerance, cuts):  # type: ignore[no-untyped-def]
    n, start = 0, i
    for q in range(i + 2, j + 1):
        if q - start >= 2 and _fit(x, y, start, q)[4] > tolerance:
            cuts[n] = q - 1
            n += 1
            start = q
    cuts[n] = j
    return n + 1


@njit(cache=True)
def _range_error(x, y, a, b):  # type: ignore[no-untyped-def]
    """Sum of squared errors along the beams of the echoes between a and b, if the line runs from echo to echo."""
    dx, dy = x[b] - x[a], y[b] - y[a]
    cross = x[a] * dy - y[a] * dx
    total = 0.0
    for q in range(a + 1, b):
        r = np.hypot(x[q], y[q])
        across = (x[q] * dy - y[q] * dx) / r
        total += (cross / across - r) ** 2 if abs(across) > 1e-9 else 1.0
    return total


@njit(cache=True)
def _polyline(x, y, i, j, limit, cuts):  # type: ignore[no-untyped-def]
    """Greedy removal of vertices until each further one costs more than ``limit`` [m2]."""
    n = j - i + 1
    before, after = np.arange(i - 1, j), np.arange(i + 1, j + 2)
    cost, kept = np.full(n, np.inf), np.zeros(n)
    for q in range(i + 1, j):
        cost[q - i] = _range_error(x, y, q - 1, q + 1)
    while n > 2:
        k = int(np.argmin(cost))
        if cost[k] > limit:
            break
        a, b = before[k], after[k]
        kept[a - i] = _range_error(x, y, a, b)
        after[a - i], before[b - i] = b, a
        cost[k] = np.inf
        for v in (a, b):
            if i < v < j:
                left, right = before[v - i], after[v - i]
                cost[v - i] = _range_error(x, y, left, right) - kept[left - i] - kept[v - i]
    m, v = 0, after[0]
    while v < j:
        cuts[m] = v
        m, v = m + 1, after[v - i]
    cuts[m] = j
    return m + 1


@njit(cache=True)
def _all(ranges, bearings, method, tolerance, noise, max_range, gap, min_points, min_length):  # type: ignore[no-untyped-def]
    n_scans, n_beams = ranges.shape
    found, lines = np.zeros((n_scans * n_beams, 3), np.int64), np.zeros((n_scans * n_beams, 4))
    x, y, beam = np.zeros(n_beams), np.zeros(n_beams), np.zeros(n_beams, np.int64)
    cuts = np.zeros(n_beams, np.int64)
    cos, sin = np.cos(bearings), np.sin(bearings)
    m = 0
    for s in range(n_scans):
        k = 0
        for b in range(n_beams):
            if 0 < ranges[s, b] < max_range:
                x[k], y[k], beam[k] = ranges[s, b] * cos[b], ranges[s, b] * sin[b], b
                k += 1
        start = 0
        for q in range(1, k + 1):
            if q < k and np.hypot(x[q] - x[q - 1], y[q] - y[q - 1]) <= gap:
                continue
            if method == 0:
                n = _split_merge(x, y, start, q - 1, tolerance, cuts)
            elif method == 1:
                n = _incremental(x, y, start, q - 1, tolerance, cuts)
            else:
                n = _polyline(x, y, start, q - 1, (3.0 * noise) ** 2, cuts)
            i = start
            for c in range(n):
                j = cuts[c]
                if j - i + 1 >= min_points and np.hypot(x[j] - x[i], y[j] - y[i]) >= min_length:
                    cx, cy, ux, uy, _, _ = _fit(x, y, i, j)
                    found[m, 0], found[m, 1], found[m, 2] = s, beam[i], beam[j]
                    lines[m, 0], lines[m, 1], lines[m, 2], lines[m, 3] = cx, cy, ux, uy
                    m += 1
                i = j + 1
            start = q
    return found[:m], lines[:m]


def ours(log: ScanLog, _: Extract) -> Found:
    s = extract(log, Extract())
    d = s.ends[:, 1] - s.ends[:, 0]
    return np.column_stack([s.scan, s.beams]), np.column_stack([s.ends[:, 0], d / np.hypot(*d.T)[:, None]])


def published(method: int) -> Callable[[ScanLog, Extract], Found]:
    def run(log: ScanLog, s: Extract) -> Found:
        tolerance = max(s.point_line_distance, 4 * s.noise)
        limits = (s.max_range, s.cluster_distance, s.min_points, s.min_length)
        return _all(log.ranges, log.bearings, method, tolerance, s.noise, *limits)

    return run


METHODS = {"ours": ours, "split+merge": published(0), "incremental": published(1), "polyline": published(2)}


def residuals(log: ScanLog, found: Found, max_range: float) -> np.ndarray:
    """(N, B) least absolute error along its beam of each echo within the beams of a line of its scan; nan for none."""
    (rows, lines), n_beams = found, log.ranges.shape[1]
    out = np.full(log.ranges.shape, np.inf)
    count = (rows[:, 2] - rows[:, 1]) % n_beams + 1
    of = np.repeat(np.arange(len(rows)), count)
    beam = (rows[of, 1] + np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)) % n_beams
    cos, sin = np.cos(log.bearings[beam]), np.sin(log.bearings[beam])
    px, py, ux, uy = lines[of].T
    across = cos * uy - sin * ux
    error = np.abs((px * uy - py * ux) / np.where(np.abs(across) < 1e-6, 1e-6, across) - log.ranges[rows[of, 0], beam])
    np.minimum.at(out, (rows[of, 0], beam), np.where(np.isfinite(error), error, np.inf))
    return np.where(log.usable(max_range) & np.isfinite(out), out, np.nan)


def main(paths: list[str]) -> None:
    for path in paths or [str(LOGS / f"{name}.log.gz") for name in ("intel", "fr079", "aces")]:
        log = read_log(path)
        settings = adapted(log, Extract())
        echoes = log.usable(settings.max_range).sum()
        table = Table(
            title=f"{Path(path).name}: {len(log)} scans, noise {1e3 * settings.noise:.0f} mm", title_justify="left"
        )
        for head in ("method", "lines/scan", "rms mm", "median mm", "within 3 sigma %", "within 10 cm %", "scans/s"):
            table.add_column(head, justify="left" if head == "method" else "right")
        for name, method in METHODS.items():
            found = method(log, settings)  # compiles
            began = time.process_time()
            method(log, settings)
            seconds = time.process_time() - began
            off = residuals(log, found, settings.max_range)
            near = off[off < 0.1]  # beyond it: a door post or a leg within the beams of the line behind
            figures = (
                f"{len(found[0]) / len(log):.2f}",
                f"{1e3 * np.sqrt((near**2).mean()):.1f}",
                f"{1e3 * np.nanmedian(off):.1f}",
                f"{100 * (off < 3 * settings.noise).sum() / echoes:.1f}",
                f"{100 * len(near) / echoes:.1f}",
                f"{len(log) / seconds:,.0f}",
            )
            table.add_row(name, *figures)
        Console().print(table)


if __name__ == "__main__":
    main(sys.argv[1:])
