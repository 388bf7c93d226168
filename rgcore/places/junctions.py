"""Arms of T, L and X junctions: chords across a hallway where others leave it (paper, sections II and IV-D).

A door is a narrow place in a wall, an arm of a junction is as wide as all of its hallway. So junctions have features
and a network of their own: all lengths are in widths of the chord, and what counts is which ways leave the square that
lies next to it.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np

from rgcore.places.chords import Chords
from rgcore.places.network import Network

KINDS = ("none", "junction_T", "junction_L", "junction_X")
"""What the network tells apart."""

WEIGHTS = Path(__file__).with_name("junctions.npz")
"""Made by ``python -m rgcore.places.train_junctions``."""

PROBES = (-0.2, 0.0, 0.15, 0.3, 0.5, 0.7, 0.85, 1.0, 1.2, 1.5, 2.0, 2.5)
"""Widths before and behind a chord at which the ways to the left and to the right are measured."""

FAR, AWAY = 3.0, 1.0
"""Widths: what is farther is far; and how long a way beside the chord's hallway must be to be an arm."""


@lru_cache(maxsize=1)
def network() -> Network:
    """The shipped network."""
    return Network.load(WEIGHTS)


def features(chords: Chords, resolution: float, turned: bool = False, mirrored: bool = False) -> np.ndarray:
    """(K, F) what the network sees of each chord; ``turned``: from the other side, ``mirrored``: in a mirror."""
    width = np.maximum(chords.width, 1.0)
    order, ends = slice(None, None, -1 if turned else 1), slice(None, None, -1 if mirrored else 1)
    aside = (chords.profile - width[:, None, None] / 2)[:, order, ends] / width[:, None, None]
    middle, step = len(chords.offsets) // 2, chords.offsets[1] - chords.offsets[0]
    onward = np.minimum(chords.reach[:, order] / width[:, None], FAR)
    walls = np.concatenate([chords.runs[:, ends], chords.thick[:, ends]], 1) * resolution
    columns = [np.log(width * resolution)[:, None], walls]
    rows = np.arange(len(width))[:, None]
    for i, sign in enumerate((1, -1)):
        at = middle + np.round(sign * np.array(PROBES) * width[:, None] / step).astype(int)
        ways = np.where(
            ((at >= 0) & (at < aside.shape[1]))[..., None], aside[rows, np.clip(at, 0, aside.shape[1] - 1)], -0.5
        )
        side = aside[:, middle:] if sign > 0 else aside[:, middle::-1]
        arm = np.minimum((side > AWAY).sum(1) * step / width[:, None], FAR)
        columns += [onward[:, i : i + 1], np.clip(ways, -0.5, FAR).reshape(len(width), -1), arm]
    return np.concatenate(columns, 1)


def chances(chords: Chords, resolution: float) -> np.ndarray:
    """(K, 4) chance of each kind: the mean over the four ways to look."""
    views = [features(chords, resolution, t, m) for t in (False, True) for m in (False, True)]
    return np.asarray(sum(network().probabilities(v) for v in views) / 4)
