"""Tracking: where the next scan is, seen from the last one; and when that cannot be told.

Registered from where odometry says, a scan that fits there is where it seems. Where it fits badly, or where odometry
says something new, there are other answers, and the likeliest counts: what the scan says of each and how surprising a
motion it is are weighed in one measure (the posterior of Olson, "Real-time correlative scan matching", ICRA 2009).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rgcore.config import Slam
from rgcore.slam.correlation import correlate, likelihood_field
from rgcore.slam.keyframes import Keyframes
from rgcore.slam.local import CELL, LocalMap, Match, likelihood, register, unmatched
from rgcore.slam.motion import STEADY, Motion, motion_deviation
from rgcore.slam.small import between, chain
from rgcore.slam.surface import Surface

FITS = 0.6
"""Share of points with a partner from which on a scan is where it seems."""
MATCHED = 3.0
"""So many points weigh as one unit of log likelihood: neighbouring points err together."""
UNUSUAL = 3.0
"""Deviations from what odometry says, or of that from a steady motion, that ask for another look."""
SEEN_THROUGH = 3.0
"""Such points speak against an answer; one weighs more than one on the map speaks for it."""
SLIP = 10.0
"""Log likelihood of a motion that odometry does not know of."""
WITNESSES = 3
"""Newest keyframes that a doubtful scan is compared with."""
DOUBT = 0.9
"""Scans agree less than this where somebody walks by, or where the registration failed: worth a search."""
LEAST_RESPONSE = 0.2
"""A scan after a turn shows mostly what is new: little of it lies on the local map. The scans' agreement decides, so
that the search may ask for less than a loop closure must.
"""


class Step(NamedTuple):
    """The motion to the next scan, before that is looked at: from ``last`` (3,), as ``told`` (3,) by odometry, with
    (3,) standard ``deviation``; and that before it, ``steady`` (3,). ``told`` is no evidence where nothing measured it.
    """

    last: np.ndarray
    told: np.ndarray
    deviation: np.ndarray
    steady: np.ndarray
    measured: bool = True


def track(
    frames: Keyframes, on: LocalMap, scan: Surface, ranges: np.ndarray, step: Step, motion: Motion, settings: Slam
) -> tuple[Match, bool]:
    """Registers a scan on the local map, after ``step``; and whether that can be believed.

    A scan that the newest keyframes contradict is sought on the whole local map, whichever way the robot turned.
    """
    s, guess = settings, chain(step.last, step.told)
    prior = np.diag(step.deviation**-2.0)
    match = register(scan, on, guess, prior, s.point_noise, min(s.reach, 0.5 * CELL + 4.0 * float(step.deviation[0])))
    if min(len(scan.points), len(on.points)) < s.least_points:
        return match, True
    new = step.measured and _unusual(step.steady, step.told, step.deviation)
    if match.share > FITS and not new and not _unusual(step.told, between(step.last, match.pose), step.deviation):
        return match, True
    rivals = [match, *(register(scan, on, guess, prior, s.point_noise, r) for r in (0.5 * CELL, s.reach))]
    if match.share <= FITS:
        rivals.append(unmatched(on, guess))  # a few points that pair by chance would turn the scan
    if new:
        wide = np.diag((motion_deviation(step.steady, s.odometry_noise) + STEADY) ** -2.0)
        rivals.append(register(scan, on, chain(step.last, step.steady), wide, s.point_noise, s.reach))
    judged = [_judge(frames, on, scan, ranges, step, motion, m) for m in rivals]
    best = max(judged, key=lambda j: j.evidence)
    if best.match.share > FITS:
        return best.match, True
    field = likelihood_field(on.points) if best.agreement < DOUBT else None
    for turn, rival, slip in ((0.8, 1.0, SLIP), (0.8, 1.0, 0.0), (np.pi, s.rival, 0.0)):
        if field is None or best.agreement >= (DOUBT if slip else _asked(best, step, motion, s)):
            break
        window = np.append(s.reach + 3.0 * step.deviation[:2], turn)
        cost = MATCHED / len(scan.points) * np.append(0.5 * step.deviation[1:] ** -2.0, slip)
        peak = correlate(scan.points, field, guess, window, LEAST_RESPONSE, rival, cost)
        if peak is not None:
            again = register(scan, on, peak.pose, np.linalg.inv(peak.covariance), s.point_noise, s.reach)
            best = max(best, _judge(frames, on, scan, ranges, step, motion, again), key=lambda j: j.evidence)
    return best.match, best.agreement >= _asked(best, step, motion, s)


def _asked(answer: _Judged, step: Step, motion: Motion, settings: Slam) -> float:
    """The agreement from which on an answer is believed: more where odometry does not know of such a motion, and none
    is enough where the scan says less for it than the motion says against it.
    """
    moved = between(step.last, answer.match.pose)
    if not step.measured or motion.surprise(moved, step.told, step.steady) <= SLIP:
        return settings.least_agreement
    return DOUBT if answer.evidence > 0.0 else np.inf


def _unusual(told: np.ndarray, moved: np.ndarray, deviation: np.ndarray) -> bool:
    """Whether a motion is none that one would expect who was ``told`` another, give or take a ``deviation`` (3,)."""
    off = between(told, moved) / deviation
    return bool(off @ off > UNUSUAL**2)


class _Judged(NamedTuple):
    """An answer, with the logarithm of its likelihood, and the share of what scans see of each other that agrees."""

    match: Match
    evidence: float
    agreement: float


def _judge(
    frames: Keyframes,
    on: LocalMap,
    scan: Surface,
    ranges: np.ndarray,
    step: Step,
    motion: Motion,
    match: Match,
) -> _Judged:
    """Weighs an answer: points on the map speak for it, those that see through walls against it; what is new says
    nothing; and the motion may be surprising.
    """
    newest = np.arange(max(frames.since, len(frames) - WITNESSES), len(frames))
    confirmed, contradicted, _ = frames.agree(scan, ranges, match.pose, newest)
    points = likelihood(scan.points, on, match.pose) * len(scan.points) - SEEN_THROUGH * contradicted / (
        2.0 * len(newest)
    )
    moved = between(step.last, match.pose)
    evidence = points / MATCHED - (motion.surprise(moved, step.told, step.steady) if step.measured else 0.0)
    agreed = float(confirmed / (confirmed + contradicted)) if confirmed + contradicted > 0 else 1.0
    return _Judged(match, float(evidence), agreed)
