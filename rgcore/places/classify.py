"""Region classes from the line angle histogram and free-space measures (paper, section IV-D)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from rgcore.config import Classes as Settings
from rgcore.evidence import Evidence
from rgcore.geometry import polygons
from rgcore.lines.merge import Lines
from rgcore.places.freespace import FreeSpace
from rgcore.places.network import Network
from rgcore.places.places import FoundRegion, Places

CLASSES = ("CDMA", "ODMA", "TOMA", "CC")
"""Order of the scores: closed and open with one distinct main axis, two orthogonal main axes, cluttered."""

WEIGHTS = Path(__file__).with_name("classes.npz")
"""Made by ``python -m rgcore.places.train_classes``."""

DOOR = 1.5
"""m: wider gaps stand open; narrower ones have a door, which closes them."""

SHORT = 0.6
"""m: lines up to this are legs and edges rather than walls."""


@dataclass(frozen=True, eq=False)
class Classes(Evidence):
    """What kind of place each region is (R regions).

    scores     (R, 4)    probability of each of ``CLASSES``
    axes       (R, 2)    main axes, rad in [0, pi), the stronger first; nan where a region has only one
    histogram  (R, bins) line angle histogram: maximum 1, shifted to the centre
    measures   (R, 7)    free-space measures, see :func:`measures`
    """

    scores: np.ndarray
    axes: np.ndarray
    histogram: np.ndarray
    measures: np.ndarray

    @property
    def best(self) -> list[str]:
        """The likeliest class of each region."""
        return [CLASSES[i] for i in self.scores.argmax(1)]


def classify(lines: Lines, places: Places, free: FreeSpace, settings: Settings) -> Classes:
    """Score the classes of every region by a small network on its histogram and free-space measures."""
    n, bins = len(places.regions), settings.histogram_bins
    histogram, axes, measured = np.zeros((n, bins)), np.full((n, 2), np.nan), np.zeros((n, 7))
    for i, region in enumerate(places.regions):
        own = lines.ends[lines.region == i]
        ends = own if len(own) else outline_lines(region)
        histogram[i], peak = angle_histogram(ends, bins)
        measured[i] = measures(region, [g.posts for g in places.gateways if i in g.regions], own)
        axes[i] = main_axes(ends, histogram[i], peak)
    if n == 0:
        return Classes(np.zeros((0, len(CLASSES))), axes, histogram, measured)
    inputs = np.concatenate([np.stack([resample(h) for h in histogram]), measured], 1)
    return Classes(network().probabilities(inputs), axes, histogram, measured)


@lru_cache(maxsize=1)
def network() -> Network:
    """The shipped network."""
    return Network.load(WEIGHTS)


def angle_histogram(ends: np.ndarray, bins: int) -> tuple[np.ndarray, float]:
    """Summed length of lines (L, 2, 2) by slope over [0, pi): maximum 1 and in the middle; and the slope [rad] there.

    Each length is shared between the two nearest bins, so that a slope between two bins makes one peak and not two.
    """
    d = ends[:, 1] - ends[:, 0]
    length = np.hypot(*d.T)
    at = (np.arctan2(d[:, 1], d[:, 0]) % np.pi) / np.pi * bins
    low = np.floor(at).astype(int)
    share = at - low
    total = np.bincount(low % bins, length * (1 - share), bins) + np.bincount((low + 1) % bins, length * share, bins)
    if total.max() <= 0:
        return np.zeros(bins), 0.0
    top = int(total.argmax())
    return np.roll(total / total.max(), bins // 2 - top), top * np.pi / bins


def resample(histogram: np.ndarray, bins: int = 36) -> np.ndarray:
    """The histogram as the network was trained on it: ``bins`` bins."""
    if len(histogram) == bins:
        return histogram
    n = len(histogram)
    at = (np.arange(bins) - bins // 2) * n / bins + n // 2
    value = np.interp(at, np.arange(-1, n + 1), np.concatenate([histogram[-1:], histogram, histogram[:1]]))
    return value / max(value.max(), 1e-9)


def main_axes(ends: np.ndarray, histogram: np.ndarray, peak: float) -> tuple[float, float]:
    """The strongest slope, and the one across it if lines stand there too; refined on the lines themselves."""
    bins = len(histogram)
    first = _mean_slope(ends, peak)
    across = histogram[(bins // 2 + bins // 2 + np.arange(-1, 2)) % bins].max()
    second = _mean_slope(ends, (first + np.pi / 2) % np.pi) if across >= 0.1 else np.nan
    return round(first, 4), round(second, 4)


def _mean_slope(ends: np.ndarray, near: float, window: float = np.radians(8)) -> float:
    """Length-weighted mean slope [0, pi) of the lines within ``window`` of a slope."""
    d = ends[:, 1] - ends[:, 0]
    off = (np.arctan2(d[:, 1], d[:, 0]) - near + np.pi / 2) % np.pi - np.pi / 2
    weight = np.hypot(*d.T) * (np.abs(off) < window)
    return float((near + (weight * off).sum() / max(weight.sum(), 1e-9)) % np.pi)


def outline_lines(region: FoundRegion) -> np.ndarray:
    """(L, 2, 2) edges of a region's outline: what there is to go by where no line was assigned to it."""
    ring = np.array(region.boundary)
    return np.stack([ring, np.roll(ring, -1, axis=0)], 1)


def measures(region: FoundRegion, posts: Sequence[tuple[tuple[float, float], ...]], lines: np.ndarray) -> np.ndarray:
    """Free-space measures of one region.

    log elongation of the box of possible robot positions with its rim; log width [m] as area over length;
    log area [m2]; share of the outline that is open, doors not counted; share of the rectangle that is
    free; short lines a m2; log of one plus the number of gateways.
    """
    shape = polygons.polygon(region.boundary, region.holes)
    area, around = max(shape.area, 0.1), max(shape.length, 0.1)
    (long, short), rim = region.box_size, 0.5
    gaps = np.array([np.hypot(a[0] - b[0], a[1] - b[1]) for a, b in posts])
    length = np.hypot(*(lines[:, 1] - lines[:, 0]).T)
    return np.array(
        [
            np.log((long + rim) / (short + rim)),
            np.log(2 * area / around),
            np.log(area),
            min(gaps[gaps > DOOR].sum() / around, 1.0),
            min(area / ((long + rim) * (short + rim)), 1.5),
            min((length < SHORT).sum() / area, 4.0),
            np.log1p(len(posts)),
        ]
    )
