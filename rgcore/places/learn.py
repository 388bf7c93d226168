"""Classes of a person's own, from a few regions: which others are like them (paper, section II: "additional region
classes can be defined").

With two or three examples only little can be learned honestly: each feature is a Gaussian about the examples' mean,
whose spread is drawn towards half of that of all regions, against one over all regions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rgcore.places.classify import angle_histogram, measures
from rgcore.places.places import FoundRegion

FEWEST = 2
"""Examples: one does not tell which of its features make the class."""

PRIOR, SPREAD = 3.0, 0.35
"""So many examples the prior counts for; its spread within a class, over that of all regions."""

TOGETHER = 0.45
"""The features depend on each other, so that their evidence counts for less than its sum."""

FARTHEST = 3.0
"""No single feature says more for or against than this (log of the ratio)."""


@dataclass(frozen=True)
class Learned:
    """A class: mean and variance (D,) of its features, and of all regions; log odds of the class before any look."""

    mean: np.ndarray
    variance: np.ndarray
    middle: np.ndarray
    scale: np.ndarray
    odds: float

    def scores(self, features: np.ndarray) -> np.ndarray:
        """How likely each region of features (N, D) is of the class (N,)."""
        z = (features - self.middle) / self.scale
        ratio = 0.5 * (z**2 - (z - self.mean) ** 2 / self.variance - np.log(self.variance))
        score = TOGETHER * np.clip(ratio, -FARTHEST, FARTHEST).sum(1) + self.odds
        return np.asarray(1 / (1 + np.exp(-np.clip(score, -50, 50))))


def learn(examples: np.ndarray, others: np.ndarray) -> Learned:
    """A class from features of its examples (n, D) and of regions that are not known to be (N, D).

    Raises ValueError for fewer than ``FEWEST`` examples.
    """
    n = len(examples)
    if n < FEWEST:
        raise ValueError(f"a class is learned from at least {FEWEST} examples, not {n}")
    every = np.concatenate([examples, others])
    middle, spread = every.mean(0), every.std(0)
    scale = np.hypot(spread, LEAST)
    prior = ((SPREAD * spread) ** 2 + LEAST**2) / scale**2  # 1, and so no evidence, where all regions are alike
    z = (examples - middle) / scale
    mean = z.mean(0) * n / (n + 0.3)
    variance = (((z - mean) ** 2).sum(0) + PRIOR * prior) / (n + PRIOR) * (1 + 1 / n)
    return Learned(mean, variance, middle, scale, float(np.log(n / (len(others) + 1))))


LEAST = np.array([0.1, 0.1, 0.2, 0.03, 0.05, 0.1, 0.15, 0.1, 0.1, 0.15, 0.15, 0.1, 0.1])
"""Differences of the features that mean nothing, however alike all regions are."""


def features(
    region: FoundRegion,
    posts: Sequence[tuple[tuple[float, float], ...]],
    lines: np.ndarray,
    furniture: tuple[int, int],
    scores: tuple[float, float],
) -> np.ndarray:
    """(13,) what a region is compared by: its free-space measures, two figures of its line angle histogram, furniture,
    how hallway-like and how cluttered it is.

    ``posts``: of its gateways; ``lines`` (L, 2, 2): its own; ``furniture``: tables and other things in it; ``scores``:
    of the classes with one main axis, and of the cluttered class.
    """
    measured = measures(region, posts, lines)
    histogram, _ = angle_histogram(lines, 36) if len(lines) else (np.zeros(36), 0.0)
    across = float(np.roll(histogram, 18)[17:20].max()) if len(lines) else 0.0
    askew = float(np.sort(histogram)[: 36 - 6].mean())
    per = 10 / np.exp(measured[2])
    return np.array([*measured, across, askew, *(np.log1p(per * k) for k in furniture), *scores])
