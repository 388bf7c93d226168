"""Hypotheses: which chords may be gateways, by a small trained network (paper, section IV-D)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from rgcore.config import Places as Settings
from rgcore.evidence import Evidence
from rgcore.places import junctions
from rgcore.places.chords import Chords
from rgcore.places.network import Network

KINDS = ("none", "door", "opening", "junction")
"""What the network tells apart: no transition, a gap in a wall, a hallway's mouth into a room, an arm of a junction."""

TRANSITIONS = (*KINDS[:3], *junctions.KINDS[1:])
"""What a hypothesis may be: junctions by their letter, of which a network of its own tells."""

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

    posts (K, 2, 2), score (K,), kind (K,) in ``TRANSITIONS``, weak (K,): not sure enough to stand alone
    """

    posts: np.ndarray
    score: np.ndarray
    kind: np.ndarray
    weak: np.ndarray


@lru_cache(maxsize=1)
def network() -> Network:
    """The shipped network."""
    return Network.load(WEIGHTS)


def features(chords: Chords, resolution: float, turned: bool = False, mirrored: bool = False) -> np.ndarray:
    """(K, F) what the network sees of each chord; ``turned``: from the other side, ``mirrored``: in a mirror."""
    width = chords.width * resolution
    half = (width / 2)[:, None, None]
    order = slice(None, None, -1 if turned else 1)
    ends = slice(None, None, -1 if mirrored else 1)
    profile = (chords.profile * resolution - half)[:, order, ends]
    middle, step = len(chords.offsets) // 2, (chords.offsets[1] - chords.offsets[0]) * resolution
    ways = profile[:, middle:], profile[:, middle::-1]
    at = np.round(np.array(PROBES) / step).astype(int)
    columns = [np.log(width)[:, None], chords.runs[:, ends] * resolution, chords.thick[:, ends] * resolution]
    reach = np.minimum(chords.reach * resolution, 6.0)[:, order]
    for i, way in enumerate(ways):
        extra = way.sum(2)
        depth = _depth(extra, width, step)
        columns += [v[:, None] for v in (depth, _stays(extra, width, step, depth), reach[:, i])]
        columns += [_narrows(extra, width, step)[:, None], *np.clip(way[:, at], -1, 3).transpose(2, 0, 1)]
    fan, disc = chords.fan[:, order, ends] * resolution, chords.disc[:, order] * resolution
    for i in range(2):
        columns += [np.log(fan[:, i] + 0.1), np.log(disc[:, i] + 0.1), np.minimum(2 * disc[:, i] / width[:, None], 4)]
    return np.concatenate(columns, 1)


def chances(chords: Chords, resolution: float) -> np.ndarray:
    """(K, 4) chance of each kind: the mean over the four ways to look, where the first leaves a doubt."""
    out = network().probabilities(features(chords, resolution))
    open_ = out[:, 0] < 0.98
    rest = chords[open_]
    if len(rest):
        views = [features(rest, resolution, t, m) for t, m in ((True, False), (False, True), (True, True))]
        out[open_] = (out[open_] + sum(network().probabilities(v) for v in views)) / 4
    return out


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
    chance = chances(chords, resolution)[:, : KINDS.index("junction")]
    kind = 1 + chance[:, 1:].argmax(1)
    score = chance[:, 1:].sum(1)
    if settings.split_hallways:
        arm = junctions.chances(chords, resolution)
        is_arm = arm[:, 1:].sum(1) > score
        kind = np.where(is_arm, len(KINDS) - 1 + arm[:, 1:].argmax(1), kind)
        score = np.where(is_arm, arm[:, 1:].sum(1), score)
    width = chords.width * resolution
    kept = np.nonzero(score >= settings.weak_confidence)[0]
    order = kept[np.argsort(-(score - 0.1 * width)[kept], kind="stable")]
    pick = np.zeros(0, int)
    for k in order:
        if not _clashes(chords, k, pick, 0.5 / resolution).any():
            pick = np.append(pick, k)
    needed = settings.min_confidence + np.clip(0.05 * (width - 1.5), 0, 0.4)
    return Hypotheses(chords.posts[pick], score[pick], kind[pick], (score < needed)[pick])


def _clashes(chords: Chords, one: int, others: np.ndarray, near: float) -> np.ndarray:
    """Whether a chord is the same transition as each of others: their middles are near, or one crosses the other."""
    if not len(others):
        return np.zeros(0, bool)
    turned = np.abs(chords.along[others] @ chords.along[one]) < 0.8
    apart = np.hypot(*(chords.middle[others] - chords.middle[one]).T)
    p, q = chords.posts[one].astype(float)
    r, s = chords.posts[others, 0].astype(float), chords.posts[others, 1].astype(float)

    def side(o: np.ndarray, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        return (t[..., 0] - o[..., 0]) * (x[..., 1] - o[..., 1]) - (t[..., 1] - o[..., 1]) * (x[..., 0] - o[..., 0])

    crossing = (side(p, q, r) * side(p, q, s) < 0) & (side(r, s, p) * side(r, s, q) < 0)
    return (apart < near * np.where(turned, 1.0, 1.5)) | crossing
