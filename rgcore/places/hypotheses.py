"""Hypotheses: which chords may be gateways, by a small trained network (paper, section IV-D)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from rgcore.config import Places as Settings
from rgcore.evidence import Evidence
from rgcore.places.chords import Chords
from rgcore.places.network import Network

KINDS = ("none", "door", "opening", "junction")
"""What the network tells apart: no transition, a gap in a wall, a hallway's mouth into a room, an arm of a junction."""

WEIGHTS = Path(__file__).with_name("gateways.npz")
"""Made by ``python -m rgcore.places.train_gateways``."""

AHEAD = 1.2
"""m: a space that opens behind a chord stays open for at least this."""

NARROW = (0.5, 2.6)
"""m: where the least width before and behind a chord is looked for."""

PROBES = (0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0, 1.4, 1.8, 2.4, 3.2)
"""m: distances before and behind a chord at which the network sees the width of the free space."""


@dataclass(frozen=True, eq=False)
class Hypotheses(Evidence):
    """Chords that may be gateways, the best first (K), in cells.

    posts (K, 2, 2), score (K,), kind (K,) in ``KINDS``, weak (K,): not sure enough to stand alone
    """

    posts: np.ndarray
    score: np.ndarray
    kind: np.ndarray
    weak: np.ndarray


@lru_cache(maxsize=1)
def network() -> Network:
    """The shipped network."""
    return Network.load(WEIGHTS)


def features(chords: Chords, resolution: float) -> np.ndarray:
    """(K, F) what the network sees of each chord; the side that opens first counts as the first side."""
    width = chords.width * resolution
    half = (width / 2)[:, None, None]
    profile = chords.profile * resolution - half
    middle, step = len(chords.offsets) // 2, (chords.offsets[1] - chords.offsets[0]) * resolution
    ways = profile[:, middle:], profile[:, middle::-1]
    depth = np.stack([_depth(w.sum(2), width, step) for w in ways], 1)
    rest = np.stack([_stays(w.sum(2), width, step, depth[:, i]) for i, w in enumerate(ways)], 1)
    reach = np.minimum(chords.reach * resolution, 6.0)
    at = np.round(np.array(PROBES) / step).astype(int)
    swap = (depth[:, 1] < depth[:, 0]) | ((depth[:, 1] == depth[:, 0]) & (reach[:, 1] > reach[:, 0]))
    columns = [np.log(width)[:, None], np.sort(chords.runs, 1) * resolution, np.sort(chords.thick, 1) * resolution]
    narrow = np.stack([_narrows(w.sum(2), width, step) for w in ways], 1)
    for values in (depth, rest, reach, narrow):
        columns.append(np.where(swap[:, None], values[:, ::-1], values))
    for first, second in ((0, 1), (1, 0)):
        w = np.where(swap[:, None, None], ways[second][:, at], ways[first][:, at])
        w = np.clip(np.sort(w, axis=2), -1, 3)
        columns += [w[:, :, 0], w[:, :, 1]]
    return np.concatenate(columns, 1)


def _depth(extra: np.ndarray, width: np.ndarray, step: float) -> np.ndarray:
    """(K,) m until the free space is wider than the chord by a quarter, at least 0.3 m; 2 if it never is."""
    wide = extra >= np.maximum(0.25 * width, 0.3)[:, None]
    return np.where(wide.any(1), wide.argmax(1) * step, 2.0)


def _stays(extra: np.ndarray, width: np.ndarray, step: float, depth: np.ndarray) -> np.ndarray:
    """(K,) share of the next ``AHEAD`` metres over which it stays that wide."""
    wide = extra >= np.maximum(0.25 * width, 0.3)[:, None]
    at = np.arange(extra.shape[1]) * step
    after = (at >= depth[:, None]) & (at < depth[:, None] + AHEAD)
    return (wide & after).sum(1) / (AHEAD / step)


def _narrows(extra: np.ndarray, width: np.ndarray, step: float) -> np.ndarray:
    """(K,) least width of the free space from ``NARROW`` on as long as the way is free, over the chord's: a hallway
    that only widens at its side doors comes back to one."""
    first, last = (round(d / step) for d in NARROW)
    total = extra[:, first:last] + width[:, None]
    free = np.logical_and.accumulate(extra[:, first:last] > -width[:, None] + 1e-9, axis=1)
    least = np.where(free, total, np.inf).min(1)
    return np.minimum(np.where(np.isinf(least), 0.0, least) / width, 4.0)


def judge(chords: Chords, resolution: float, settings: Settings) -> Hypotheses:
    """Score the chords by the network and keep the best of those that are near each other."""
    chance = network().probabilities(features(chords, resolution))
    if not settings.split_hallways:
        chance = chance[:, : KINDS.index("junction")]
    kind = 1 + chance[:, 1:].argmax(1)
    score = chance[:, 1:].sum(1)
    width = chords.width * resolution
    kept = np.nonzero(score >= settings.weak_confidence)[0]
    order = kept[np.argsort(-(score - 0.1 * width)[kept], kind="stable")]
    chosen: list[int] = []
    for k in order:
        if all(not _clash(chords, k, j, 0.5 / resolution) for j in chosen):
            chosen.append(k)
    pick = np.array(chosen, int)
    needed = settings.min_confidence + np.clip(0.05 * (width - 1.5), 0, 0.4)
    return Hypotheses(chords.posts[pick], score[pick], kind[pick], (score < needed)[pick])


def _clash(chords: Chords, a: int, b: int, near: float) -> bool:
    """Whether two chords are the same transition: their middles are near, or one crosses the other."""
    turned = abs(chords.along[a] @ chords.along[b]) < 0.8
    if np.hypot(*(chords.middle[a] - chords.middle[b])) < near * (1.0 if turned else 1.5):
        return True
    (p, q), (r, s) = chords.posts[a].astype(float), chords.posts[b].astype(float)

    def side(o: np.ndarray, t: np.ndarray, x: np.ndarray) -> float:
        return float((t[0] - o[0]) * (x[1] - o[1]) - (t[1] - o[1]) * (x[0] - o[0]))

    return side(p, q, r) * side(p, q, s) < 0 and side(r, s, p) * side(r, s, q) < 0
