"""Adaptation: each region gets the parameters of merging that predict its scans best with the fewest lines.

The paper (section IV-C) measures a parameterisation by projecting its map back into the scans, chooses it by "several
heuristics" and leaves a general way open. Ours is a price: a line is kept for ``price`` [scans] of prediction error,

    cost(settings of all regions) = sum over scans of acc(s)^2 / p^2  +  price * number of lines,

so the lines go where they explain most, with as many of them as the scans can justify. First the best single setting
for all regions is found. Then the cost of each region's setting is measured with all other regions' lines as that one
makes them: each region is searched alone. What is tried is a ladder of tolerances (distance, gamma and rho); every rung
is merged once, for all regions. The least length and support (mu, min_support) only drop lines at the end, so all their
pairs are measured in one back-projection.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import msgspec
import numpy as np

from rgcore.config import Accuracy as AccuracySettings
from rgcore.config import Adapt as Settings
from rgcore.config import Lines as LineSettings
from rgcore.geometry import segments as geometry
from rgcore.geometry.compiled import kernel
from rgcore.geometry.raycast import cast, facing
from rgcore.lines.adaptation import PARAMETERS, Adaptation, Curve
from rgcore.lines.merge import Lines, merge_lines
from rgcore.scans.extract import Segments
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

LADDER = ((1.0, 1.0, 1.0), (0.6, 0.5, 0.4), (1.5, 1.0, 0.4), (1.5, 2.0, 1.6), (2.0, 4.0, 1.6))
"""Factors on distance, gamma and rho, the configured settings first. Poses that are off widen all three, clean ones
narrow them; of the 48 combinations of four, four and three factors these five reach within 1 % of the cost of all."""
LENGTHS, SUPPORTS = (1.0, 1.5, 2.0, 3.0), (1.0, 1.5, 2.5)
"""Factors on mu and min_support, upwards: what was seen once too often explains only the scan that saw it."""
FEW = 20
"""Scans: regions that fewer saw take the setting that is best for the whole map."""
_BEAMS = 181
"""Beams of a scan that are projected, about: neighbours tell the same."""
FACTORS = 2.0 ** np.linspace(-3.0, 3.0, 25)
"""On the price, tried until the regions' choice is better than the single setting in lines and in accuracy."""
_WHOLE = 600
"""Scans that judge settings for the whole map."""
_NONE = np.zeros((0, 2, 2))


def adapt(
    log: ScanLog,
    segments: Segments,
    trajectory: Trajectory,
    region_of_segment: np.ndarray,
    regions: int,
    lines: LineSettings,
    accuracy: AccuracySettings,
    settings: Settings,
) -> Adaptation | None:
    """Choose the parameters of merging of each of ``regions`` regions; None if that is switched off. Deterministic.

    ``region_of_segment`` (M,) names the region whose free space a segment bounds, -1 = none. ``lines`` are the
    configured settings, around which the search is made.
    """
    if not settings.on or len(segments) == 0:
        return None
    rungs = []
    for s in _ladder(lines):
        found, _ = merge_lines(segments, trajectory, region_of_segment, lines, (s,) * (regions + 1))
        rungs.append(_rung(found, s, regions))
    tried = [s for rung in rungs for s in rung.cuts]
    whole = _view(log, trajectory, np.arange(len(log)), _NONE, accuracy, _WHOLE)
    error = np.concatenate([_errors_of(rung, whole, accuracy) for rung in rungs])
    count = np.concatenate([rung.keep.sum(0) for rung in rungs])
    best = int((error / accuracy.penalty**2 + settings.price * count).argmin())

    single = np.full(regions + 1, best)
    home = np.where(region_of_segment < 0, regions, region_of_segment)
    views, counts, errors = [], [], []
    for r in range(regions + 1):
        scans = np.unique(segments.scan[home == r])
        views.append(_view(log, trajectory, scans, _lines_of(rungs, single, without=r), accuracy, settings.sample))
        here = [rung.of(r) for rung in rungs]
        errors.append(np.concatenate([_errors_of(rung, views[r], accuracy) for rung in here]))
        counts.append(np.concatenate([rung.keep.sum(0) for rung in here]))
    parts, penalty = _Parts(np.stack(counts, 1), np.stack(errors, 1)), accuracy.penalty
    judged = np.array([v.scans >= FEW for v in views])
    chosen = _choose(parts, best, judged, settings.price * penalty**2, lambda c: _outcome(rungs, c, whole, accuracy))
    return Adaptation(
        tried=tuple({k: getattr(t, k) for k in PARAMETERS} for t in tried),
        map=_curve(count, error, whole.scans, best),
        regions=tuple(_curve(counts[r], errors[r], v.scans, int(chosen[r])) for r, v in enumerate(views)),
        price=settings.price,
    )


class _Parts(NamedTuple):
    """Lines and error (T, R) that each of T settings gives each of R regions."""

    lines: np.ndarray
    error: np.ndarray


def _choose(
    parts: _Parts,
    single: int,
    judged: np.ndarray,
    price: float,
    outcome: Callable[[np.ndarray], float],
) -> np.ndarray:
    """The setting of each region (R,); that of regions not ``judged`` is the ``single`` one.

    ``outcome`` gives the error of the whole map. The choice has neither more lines nor more error than the
    single setting: where the price [m2] alone would trade one for the other, it is moved until that holds.
    """
    found, regions = np.full(len(judged), single), np.arange(len(judged))
    most_lines, most_error = parts.lines[found, regions].sum(), outcome(found)
    least = most_error + price * most_lines
    picks = [np.where(judged, (parts.error + f * price * parts.lines).argmin(0), single) for f in FACTORS]
    for pick in np.unique(picks, axis=0):
        lines = parts.lines[pick, regions].sum()
        error = outcome(pick) if lines <= most_lines else np.inf
        if error <= most_error and error + price * lines < least:
            found, least = pick, error + price * lines
    return found


def _outcome(rungs: list[_Rung], chosen: np.ndarray, whole: _View, accuracy: AccuracySettings) -> float:
    """Sum of acc(s)^2 [m2] over all scans, of the map with a setting for each region."""
    lines = _lines_of(rungs, chosen)
    one = _Rung(lines, np.zeros(len(lines), np.int64), np.ones((len(lines), 1), bool), [])
    return float(_errors_of(one, whole, accuracy)[0])


def _ladder(lines: LineSettings) -> list[LineSettings]:
    return [_scaled(lines, {"distance": d, "gap": g, "ratio": r}) for d, g, r in LADDER]


def _scaled(lines: LineSettings, factors: dict[str, float]) -> LineSettings:
    """The settings times factors, within reason: never beyond what a setting allows."""
    values = {k: getattr(lines, k) * f for k, f in factors.items()}
    values = {k: min(v, _MOST[k]) for k, v in values.items()}
    rounded = {k: round(v) if k == "min_support" else round(v, 6) for k, v in values.items()}
    return msgspec.structs.replace(lines, **rounded)


_MOST = {"distance": 1.0, "gap": 5.0, "ratio": 2.0, "min_length": 5.0, "min_support": 1000}


@dataclass(frozen=True)
class _Rung:
    """Lines (L, 2, 2) of one setting, the region of each, and which stay (L, C) at each of the cuts (C,)."""

    lines: np.ndarray
    home: np.ndarray
    keep: np.ndarray
    cuts: list[LineSettings]

    def of(self, region: int) -> _Rung:
        here = self.home == region
        return _Rung(self.lines[here], self.home[here], self.keep[here], self.cuts)


def _rung(found: Lines, settings: LineSettings, regions: int) -> _Rung:
    cuts = [_scaled(settings, {"min_length": f, "min_support": g}) for f, g in product(LENGTHS, SUPPORTS)]
    length = geometry.lengths(found.ends)
    keep = np.stack([(length >= c.min_length) & (found.support >= c.min_support) for c in cuts], 1)
    return _Rung(found.ends, np.where(found.region < 0, regions, found.region), keep, cuts)


def _lines_of(rungs: list[_Rung], setting: np.ndarray, without: int = -1) -> np.ndarray:
    """(L, 2, 2) the lines that a setting for each region (R,) gives, those of one region left out."""
    out = [_NONE]
    for number, rung in enumerate(rungs):
        cut = setting[rung.home] - number * len(rung.cuts)
        mine = np.flatnonzero((cut >= 0) & (cut < len(rung.cuts)) & (rung.home != without))
        out.append(rung.lines[mine[rung.keep[mine, cut[mine]]]])
    return np.concatenate(out)


@dataclass(frozen=True)
class _View:
    """A sample of the scans that see a region, and what they would see without its lines (``others``)."""

    scans: int
    poses: np.ndarray
    bearings: np.ndarray
    ranges: np.ndarray
    others: np.ndarray
    weight: np.ndarray


def _view(
    log: ScanLog,
    trajectory: Trajectory,
    scans: np.ndarray,
    others: np.ndarray,
    accuracy: AccuracySettings,
    sample: int,
) -> _View:
    """``others`` (L, 2, 2): lines of all other regions. A reading weighs 1 / readings of its scan, as in acc(s)."""
    some = scans[:: max(1, -(-len(scans) // sample))]
    beams = slice(None, None, max(1, round(len(log.bearings) / _BEAMS)))
    ranges, poses, bearings = log.ranges[some][:, beams], trajectory.map_from_laser[some], log.bearings[beams]
    usable = log[some].usable(accuracy.max_range)[:, beams]
    weight = usable * (len(scans) / max(len(some), 1) / np.maximum(usable.sum(1), 1))[:, None]
    before = cast(others, poses, bearings, accuracy.max_range + accuracy.penalty)[0]
    return _View(len(scans), poses, bearings, ranges, before, weight)


def _errors_of(rung: _Rung, view: _View, accuracy: AccuracySettings) -> np.ndarray:
    """(C,) sum of acc(s)^2 [m2] over the scans of the view, at each of the cuts."""
    reach, p = accuracy.max_range + accuracy.penalty, accuracy.penalty
    v = view
    return _errors(rung.lines, rung.keep, v.poses, v.bearings, v.ranges, v.others, v.weight, reach, p)


@kernel
def _errors(lines, keep, poses, bearings, ranges, others, weight, reach, penalty):  # type: ignore[no-untyped-def]
    """(C,) weighted squares of the differences, none above the penalty, for C choices ``keep`` (L, C) of the lines."""
    cos, sin, turn = np.cos(bearings), np.sin(bearings), 2 * np.pi
    choices = keep.shape[1]
    total, near = np.zeros(choices), np.zeros((len(bearings), choices))
    for n in range(len(poses)):
        for i in range(len(bearings)):
            near[i] = others[n, i]
        for k in range(len(lines)):
            first, last, ex, ey, area = facing(
                lines[k, 0, 0], lines[k, 0, 1], lines[k, 1, 0], lines[k, 1, 1], poses[n], reach
            )
            if area <= 0.0:
                continue
            for shift in (-turn, 0.0, turn):
                i = np.searchsorted(bearings, first + shift - 1e-12)
                while i < len(bearings) and bearings[i] <= last + shift + 1e-12:
                    down = cos[i] * ey - sin[i] * ex
                    if down > 0.0:
                        for c in range(choices):
                            if keep[k, c]:
                                near[i, c] = min(near[i, c], area / down)
                    i += 1
        for i in range(len(bearings)):
            if weight[n, i] > 0.0:
                for c in range(choices):
                    total[c] += weight[n, i] * min(abs(ranges[n, i] - near[i, c]), penalty) ** 2
    return total


def _curve(count: np.ndarray, error: np.ndarray, scans: int, chosen: int) -> Curve:
    accuracy = np.sqrt(np.maximum(error, 0.0) / max(scans, 1)).round(5)
    return Curve(lines=tuple(count.tolist()), accuracy=tuple(accuracy.tolist()), scans=scans, chosen=chosen)
