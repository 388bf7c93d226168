"""Tracking: where the next scan is, seen from the last one; and when that cannot be told."""

from __future__ import annotations

import numpy as np

from rgcore.config import Slam
from rgcore.slam.correlation import correlate, likelihood_field
from rgcore.slam.keyframes import Keyframes
from rgcore.slam.local import CELL, LocalMap, Match, likelihood, register
from rgcore.slam.small import between
from rgcore.slam.surface import Surface

FAR = 0.12
"""A scan that fits this far [m] from where it was expected is registered once more, narrowly."""
MATCHED = 3.0
"""So many points weigh as one unit of log likelihood: neighbouring points err together."""
SURPRISE = 4.0
"""Chi squared beyond which a motion is no less likely: odometry that slips is wrong by any amount."""
WITNESSES = 3
"""Newest keyframes that a doubtful scan is compared with."""
DOUBT = 0.9
"""Scans agree less than this where somebody walks by, or where the registration failed: worth a search."""
LEAST_RESPONSE = 0.2
"""A scan after a turn shows mostly what is new: little of it lies on the local map. The scans' agreement decides, so
that the search may ask for less than a loop closure must.
"""


def motion_deviation(moved: np.ndarray, noise: float) -> np.ndarray:
    """(3,) standard deviations [m, m, rad] of odometry that tells of a motion ``moved`` (3,)."""
    way, turn = np.hypot(moved[0], moved[1]), abs(moved[2])
    return np.array([0.02 + noise * way, 0.02 + noise * way, 0.01 + noise * (turn + 0.2 * way)])


def track(
    frames: Keyframes,
    on: LocalMap,
    scan: Surface,
    ranges: np.ndarray,
    guess: np.ndarray,
    deviation: np.ndarray,
    settings: Slam,
    measured: bool = True,
) -> tuple[Match, bool]:
    """Registers a scan on the local map, from ``guess`` (3,) +- ``deviation`` (3,); and whether that can be believed.

    ``measured`` if odometry made the guess: then it is evidence, and the scan must say better where it is not.

    A scan that the newest keyframes contradict is sought on the whole local map, whichever way the robot turned.
    """
    s = settings
    reach = min(s.reach, 0.5 * CELL + 4.0 * float(deviation[0]))
    match = register(scan, on, guess, np.diag(deviation**-2.0), s.point_noise, reach)
    if measured and np.hypot(*(match.pose - guess)[:2]) > FAR:
        match = _likelier(scan, on, guess, deviation, s, match)
    if match.share > 0.6 or min(len(scan.points), len(on.points)) < s.least_points:
        return match, True
    belief = _believed(frames, scan, ranges, match.pose)
    field = likelihood_field(on.points) if belief < DOUBT else None
    for turn, rival in ((0.8, 1.0), (np.pi, s.rival)):
        if field is None or belief >= DOUBT:
            break
        window = np.append(s.reach + 3.0 * deviation[:2], turn)
        peak = correlate(scan.points, field, guess, window, LEAST_RESPONSE, rival)
        if peak is not None:
            again = register(scan, on, peak.pose, np.linalg.inv(peak.covariance), s.point_noise, s.reach)
            better = _believed(frames, scan, ranges, again.pose)
            if better > belief + 0.05:
                match, belief = again, better
    return match, belief >= s.least_agreement


def _likelier(
    scan: Surface, on: LocalMap, guess: np.ndarray, deviation: np.ndarray, settings: Slam, far: Match
) -> Match:
    """``far``, or what fits near the ``guess`` if that explains the scan and the motion better.

    In a corridor few points tell the way along it, and paired over the whole reach they may tell it wrong.
    """
    near = register(scan, on, guess, np.diag(deviation**-2.0), settings.point_noise, 0.5 * CELL)

    def evidence(m: Match) -> float:
        off = between(guess, m.pose) / deviation
        return float(likelihood(scan.points, on, m.pose) * len(scan.points) / MATCHED - 0.5 * min(SURPRISE, off @ off))

    return near if evidence(near) > evidence(far) else far


def _believed(frames: Keyframes, scan: Surface, ranges: np.ndarray, pose: np.ndarray) -> float:
    """Share of what scan and newest keyframes see of each other that they agree about; 1 if they see nothing."""
    newest = np.arange(max(frames.since, len(frames) - WITNESSES), len(frames))
    confirmed, contradicted, _ = frames.agree(scan, ranges, pose, newest)
    return float(confirmed / (confirmed + contradicted)) if confirmed + contradicted > 0 else 1.0
