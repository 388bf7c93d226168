"""How one map lies in the frame of another that shares no scan with it: the turn and shift that bring most of the walls
of one onto those of the other. Walls have a free side, so a turn by half is told from none.

Turns are found where the directions of walls agree (correlation of their histograms), shifts by correlating rasters of
the walls by direction in the frequency domain; the best are refined on the walls themselves (iterative closest points,
Besl & McKay 1992, distances across the walls only, what lies far off left out).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from scipy import fft
from scipy.spatial import cKDTree

from rgcore.geometry import se2
from rgcore.model.records import Line, RGMap

STEP = 0.2
"""m between two points of a wall"""
CELL = 0.25
"""m of the raster for shifts"""
BINS = 180
"""of 2 degrees for directions"""
TURNS = 8
"""turns that are tried"""
ON = 0.2
"""m: a wall that lies so near to another one lies on it"""
AS_WELL = 0.02
"""Frames with a score so little lower fit as well."""
_FACING = 0.5  # m that a radian between directions counts for


class Alignment(NamedTuple):
    """``new_from_old`` (3,); ``share``: length of the old walls that lies on new ones then, of the shorter of both;
    ``score``: the same, what lies farther off counting less."""

    new_from_old: np.ndarray
    share: float
    score: float


def align(old: RGMap, new: RGMap) -> Alignment | None:
    """How ``old`` lies in ``new``; None if either has no wall. The frames as they are win where they fit as well."""
    a, b = _walls(old.lines.values()), _walls(new.lines.values())
    if not len(a) or not len(b):
        return None
    tree = cKDTree(_features(b))
    still = _refined(np.zeros(3), a, b, tree)
    tried = [_refined(start, a, b, tree) for start in _starts(a, b)]
    best = max([still, *tried], key=lambda t: t.score)
    as_it_is = _judged(np.zeros(3), a, b, tree)
    return next(t for t in (as_it_is, still, best) if t.score >= best.score - AS_WELL)


def _walls(lines: Iterable[Line]) -> np.ndarray:
    """(K, 3) points of walls, every 0.2 m, and the direction there."""
    out = [np.zeros((0, 3))]
    for v in lines:
        if not v.clutter:
            a, b = np.array(v.start), np.array(v.end)
            s = (np.arange(max(1, round(math.dist(a, b) / STEP))) + 0.5) / max(1, round(math.dist(a, b) / STEP))
            p = a + s[:, None] * (b - a)
            out.append(np.column_stack([p, np.full(len(p), math.atan2(b[1] - a[1], b[0] - a[0]))]))
    return np.concatenate(out)


def _features(walls: np.ndarray) -> np.ndarray:
    return np.column_stack([walls[:, :2], _FACING * np.cos(walls[:, 2]), _FACING * np.sin(walls[:, 2])])


def _moved(pose: np.ndarray, walls: np.ndarray) -> np.ndarray:
    return np.column_stack([se2.transform(pose, walls[:, :2]), walls[:, 2] + pose[2]])


def _starts(a: np.ndarray, b: np.ndarray) -> list[np.ndarray]:
    out = []
    for turn in _turns(a[:, 2], b[:, 2]):
        turned = _moved(np.array([0.0, 0.0, turn]), a)
        out.append(np.array([*_shift(turned, b), turn]))
    return out


def _turns(a: np.ndarray, b: np.ndarray) -> list[float]:
    """The turns under which the directions of walls agree best."""
    h, g = (np.bincount((np.floor(x / (2 * np.pi) * BINS).astype(int)) % BINS, minlength=BINS) for x in (a, b))
    score = fft.irfft(np.conj(fft.rfft(_smooth(h))) * fft.rfft(_smooth(g)), BINS)
    peaks = np.flatnonzero((score >= np.roll(score, 1)) & (score > np.roll(score, -1)))
    best = peaks[np.argsort(-score[peaks], kind="stable")][:TURNS]
    return [float(se2.wrap(2 * np.pi * k / BINS)) for k in best]


def _smooth(h: np.ndarray) -> np.ndarray:
    return 0.5 * h + 0.25 * np.roll(h, 1) + 0.25 * np.roll(h, -1)


def _shift(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The shift (2,) [m] that brings most walls onto walls of their direction."""
    extent = np.ptp(a[:, :2], axis=0) + np.ptp(b[:, :2], axis=0)
    shape = tuple(fft.next_fast_len(int(n / CELL) + 8, real=True) for n in extent)
    score = np.zeros(shape)
    for quarter in range(4):
        rasters = []
        for walls in (a, b):
            mine = walls[np.floor((walls[:, 2] + np.pi / 4) / (np.pi / 2)).astype(int) % 4 == quarter]
            cell = np.floor((mine[:, :2] - walls[:, :2].min(0)) / CELL).astype(int) + 1
            r = np.zeros(shape)
            np.add.at(r, (cell[:, 0], cell[:, 1]), 1.0)
            r = np.minimum(r, 2.0)
            rasters.append(sum(np.roll(r, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)))
        score += fft.irfft2(np.conj(fft.rfft2(rasters[0])) * fft.rfft2(rasters[1]), s=shape)
    best = np.array(np.unravel_index(int(score.argmax()), shape))
    best = np.where(best > np.array(shape) // 2, best - np.array(shape), best)
    return best * CELL + b[:, :2].min(0) - a[:, :2].min(0)


def _refined(pose: np.ndarray, a: np.ndarray, b: np.ndarray, tree: cKDTree) -> Alignment:
    for reach in (1.0, 0.7, 0.5, 0.35, 0.25, 0.2, 0.2, 0.2):
        at = _moved(pose, a)
        far, near = tree.query(_features(at), distance_upper_bound=reach)
        on = np.isfinite(far)
        if on.sum() < 10:
            break
        q, n = b[near[on], :2], np.column_stack([-np.sin(b[near[on], 2]), np.cos(b[near[on], 2])])
        p = at[on, :2]
        middle = p.mean(0)
        lever = (p - middle) @ np.array([[0.0, 1.0], [-1.0, 0.0]])  # turned left: how a point moves when the map turns
        rows = np.column_stack([n, (lever * n).sum(1)])
        by = np.linalg.lstsq(rows.T @ rows + 1e-6 * np.eye(3), rows.T @ ((q - p) * n).sum(1), rcond=None)[0]
        turn = np.array([0.0, 0.0, by[2]])
        back = middle + by[:2] - se2.transform(turn, middle)
        pose = se2.compose(np.array([*back, by[2]]), pose)
    return _judged(pose, a, b, tree)


def _judged(pose: np.ndarray, a: np.ndarray, b: np.ndarray, tree: cKDTree) -> Alignment:
    at = _moved(pose, a)
    far, near = tree.query(_features(at), distance_upper_bound=ON)
    on = np.isfinite(far)
    closeness = np.clip(1 - (_across(at[on], b[near[on]]) / ON) ** 2, 0, 1)
    count = min(len(a), len(b))
    return Alignment(pose, min(1.0, float(on.sum() / count)), min(1.0, float(closeness.sum() / count)))


def _across(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(K,) [m] by which points of walls lie beside those of others."""
    d = a[:, :2] - b[:, :2]
    return d[:, 1] * np.cos(b[:, 2]) - d[:, 0] * np.sin(b[:, 2])
