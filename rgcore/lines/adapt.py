"""Adaptation: each region gets the parameters of merging that serve the finished map best at the price of its lines.

The paper (section IV-C) measures a parameterisation by projecting its map back into the scans, chooses it by "several
heuristics" and leaves a general way open. Ours has one knob, the price of a line in readings (``lines.price``), and

    cost = sum over readings of what is lost of each (:mod:`rgcore.lines.worth`)  +  price * number of lines.

What is tried is a ladder of tolerances (distance, gamma and rho). For each of them the map is finished for all regions
alike, on a sample of the scans: merged, completed, its lines judged one by one. How long and how often seen a line must
be (mu, support) is not asked here: that judgement settles it. A reading tells about the region in which its echo lies
and a line costs the region that it bounds, so the cost falls apart into those of the regions, and each takes what suits
it: regions hardly hide one another's walls, and the map that they make together costs what they promise.

Then the price itself: where acc(R) exceeds the ``goal``, readings of the scans taken there count more, as much as it
takes; nothing is paid for a goal that no number of lines comes near to. That is the multiplier of Lagrange for that
bound.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import msgspec
import numpy as np

from rgcore.config import Accuracy as AccuracySettings
from rgcore.config import Adapt as Settings
from rgcore.config import Lines as LineSettings
from rgcore.lines.adaptation import PARAMETERS, Adaptation, Curve
from rgcore.lines.complete import finished, regions_before, sights_of
from rgcore.lines.merge import merge_lines
from rgcore.lines.worth import Sights, lost
from rgcore.scans.extract import Segments
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory

LADDER = ((1.0, 1.0, 1.0), (0.6, 1.0, 1.0), (0.6, 0.5, 0.4), (0.4, 0.5, 0.4), (1.5, 2.0, 1.6))
"""Factors on distance, gamma and rho, the configured settings first: poses that are off widen, clean ones narrow."""
PRICES = (0.5, 0.25, 0.125)
"""Factors on the price, tried with the best rung for all regions alike: what regions pay that miss the goal."""
NEARLY = 1.1
"""Times the goal, on the sample: regions that no price brings there are people and glass, which no line mends."""
FEW = 20
"""Scans: regions that fewer saw take the setting that is best for the whole map."""
FACTORS = 2.0 ** np.linspace(-2.0, 2.0, 33)
"""On the price of lines, until the regions' choice is better than the single setting in lines and in accuracy."""
_SEGMENTS = 20_000  # of longer logs every second, third, ... scan is merged for the trial
_SURE = 0.995  # of the lines and of the error of the single setting: what is less is less on all scans, too
_CLEAR = 0.03  # of its cost a region must gain to leave the single setting: less is chance
_BEFORE = 0.15  # m before an echo: there lies the region that it is of
_MOST = {"distance": 1.0, "gap": 5.0, "ratio": 2.0}  # what the settings allow


def adapt(
    log: ScanLog,
    segments: Segments,
    trajectory: Trajectory,
    region_of_segment: np.ndarray,
    regions: int,
    region_at: Callable[[np.ndarray], np.ndarray],
    lines: LineSettings,
    accuracy: AccuracySettings,
    settings: Settings,
) -> Adaptation | None:
    """Choose the parameters of merging of each of ``regions`` regions; None if that is switched off. Deterministic.

    ``region_of_segment`` (M,) names the region whose free space a segment bounds, -1 = none; ``region_at`` gives the
    regions (K,) of points (K, 2) in the map frame. ``lines`` are the configured settings, around which is searched.
    """
    if not settings.on or len(segments) == 0:
        return None
    trial = _Trial(log, segments, trajectory, region_of_segment, regions, region_at, accuracy, settings)
    tried = [_scaled(lines, dict(zip(("distance", "gap", "ratio"), f, strict=True))) for f in LADDER]
    rungs = [trial.outcome(s) for s in tried]
    best = int(np.argmin([r.cost.sum() + lines.price * r.lines.sum() for r in rungs]))
    tried += [msgspec.structs.replace(tried[best], price=f * lines.price) for f in PRICES]
    found = _Outcome(*(np.stack(c) for c in zip(*rungs, *map(trial.outcome, tried[len(rungs) :]), strict=True)))

    home = np.where(region_of_segment < 0, regions, region_of_segment)
    scans = np.array([len(np.unique(segments.scan[home == r])) for r in range(regions + 1)])
    chosen = _choose(_Outcome(*(c[: len(rungs)] for c in found)), best, scans >= FEW, lines.price)
    chosen = _paid(found.accuracy, [t.price for t in tried], chosen, trial.taken >= FEW, settings.goal)
    error = np.sqrt(found.squares / np.maximum(trial.readings, 1)).round(5)
    count = found.lines.astype(int)
    whole = np.sqrt((found.squares.sum(1)) / max(trial.readings.sum(), 1)).round(5)
    return Adaptation(
        tried=tuple({k: getattr(t, k) for k in PARAMETERS} for t in tried),
        map=Curve(lines=_list(count.sum(1)), accuracy=_list(whole), scans=len(log), chosen=best),
        regions=tuple(
            Curve(lines=_list(count[:, r]), accuracy=_list(error[:, r]), scans=int(scans[r]), chosen=int(chosen[r]))
            for r in range(regions + 1)
        ),
        price=lines.price,
        goal=settings.goal,
    )


def _list(values: np.ndarray) -> tuple:
    return tuple(values.tolist())


def _scaled(lines: LineSettings, factors: dict[str, float]) -> LineSettings:
    """The settings times factors, within what they allow."""
    values = {k: round(min(getattr(lines, k) * f, _MOST[k]), 6) for k, f in factors.items()}
    return msgspec.structs.replace(lines, **values)


class _Outcome(NamedTuple):
    """What a setting gives in each of the regions (R + 1,), the last for what lies in none.

    lines     number of lines
    cost      readings lost
    squares   m2, of the differences of the readings of things in the region, none above the penalty
    accuracy  m, acc(R) over the scans taken in the region; 0 without such scans
    """

    lines: np.ndarray
    cost: np.ndarray
    squares: np.ndarray
    accuracy: np.ndarray


class _Trial:
    """A sample of segments and of readings, on which the map is finished with one setting after the other."""

    def __init__(
        self,
        log: ScanLog,
        segments: Segments,
        trajectory: Trajectory,
        region: np.ndarray,
        regions: int,
        region_at: Callable[[np.ndarray], np.ndarray],
        accuracy: AccuracySettings,
        settings: Settings,
    ) -> None:
        self.trajectory, self.regions, self.region_at, self.penalty = trajectory, regions, region_at, accuracy.penalty
        some = segments.scan % max(1, -(-len(segments) // _SEGMENTS)) == 0
        self.segments, self.region, self.all = segments[some], region[some], len(segments)
        self.sights, scans, self.step = sights_of(log, trajectory, accuracy.max_range, settings.sample)
        ranges = self.sights.ranges
        self.usable = ranges > 0
        turn = self.sights.poses[:, 2:] + self.sights.bearings
        beams = np.stack([np.cos(turn), np.sin(turn)], -1)
        before = self.sights.poses[:, None, :2] + (ranges - _BEFORE)[..., None] * beams
        self.home = self._named(region_at(before[self.usable]))
        self.scan_region = self._named(region_at(trajectory.map_from_base[scans, :2]))
        every = self._named(region_at(trajectory.map_from_base[:, :2]))
        self.taken = np.bincount(every, minlength=regions + 1)
        self.readings = np.bincount(self.home, minlength=regions + 1)

    def _named(self, region: np.ndarray) -> np.ndarray:
        return np.where(region < 0, self.regions, region)

    def outcome(self, s: LineSettings) -> _Outcome:
        """The map that one setting for all regions gives."""
        merged, _ = merge_lines(self.segments, self.trajectory, self.region, s)
        most = int(self.all / s.reduction)
        ends, of, _ = finished(self.sights, merged.ends, merged.region, s.price / self.step, most, s.corner)
        self.sights.clear()
        self.sights.add(ends)
        own = np.append(merged.region, -1)[np.minimum(of, len(merged))]
        own[of >= len(merged)] = regions_before(ends[of >= len(merged)], self.region_at)
        return self._measured(self.sights, self._named(own))

    def _measured(self, sights: Sights, own: np.ndarray) -> _Outcome:
        off = np.abs(sights.distance[:, 0].reshape(sights.ranges.shape) - sights.ranges)
        count, usable = self.regions + 1, self.usable
        cost = self.step * np.bincount(self.home, lost(off[usable]), count)
        squares = np.where(usable, np.minimum(off, self.penalty), 0.0) ** 2
        acc = squares.sum(1) / np.maximum(usable.sum(1), 1)
        seen = usable.any(1)
        here = np.bincount(self.scan_region[seen], minlength=count)
        accuracy = np.sqrt(np.bincount(self.scan_region[seen], acc[seen], count) / np.maximum(here, 1))
        return _Outcome(
            np.bincount(own, minlength=count), cost, np.bincount(self.home, squares[usable], count), accuracy
        )


def _choose(rungs: _Outcome, single: int, judged: np.ndarray, price: float) -> np.ndarray:
    """The rung of each region (R,); that of regions not ``judged`` is the ``single`` one.

    The choice has neither more lines nor more error than the single setting, with a margin for what a sample cannot
    tell: where the price alone would trade one for the other, it is moved until that holds.
    """
    r, best, least = np.arange(len(judged)), np.full(len(judged), single), np.inf
    lines, squares = (_SURE * c[single].sum() for c in (rungs.lines, rungs.squares))
    for factor in FACTORS:
        total = rungs.cost + factor * price * rungs.lines
        clear = total.min(0) < (1.0 - _CLEAR) * total[single]
        pick = np.where(judged & clear, total.argmin(0), single)
        count, cost = rungs.lines[pick, r].sum(), rungs.cost[pick, r].sum()
        if count <= lines and rungs.squares[pick, r].sum() <= squares and cost + price * count < least:
            best, least = pick, cost + price * count
    return best


def _paid(accuracy: np.ndarray, prices: list[float], chosen: np.ndarray, judged: np.ndarray, goal: float) -> np.ndarray:
    """The choice, where regions over the ``goal`` [m] take the highest price that brings them there.

    If none does, the lowest, unless that misses it clearly: nothing is paid for what no line mends.
    """
    out, dear = chosen.copy(), np.array(prices)
    for r in np.flatnonzero(judged & (accuracy[chosen, np.arange(len(chosen))] > goal)):
        lower = np.flatnonzero(dear < dear[chosen[r]])
        enough = lower[accuracy[lower, r] <= max(goal, min(NEARLY * goal, accuracy[lower, r].min(initial=np.inf)))]
        if len(enough):
            out[r] = enough[dear[enough].argmax()]
    return out
