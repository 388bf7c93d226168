"""Two lines made one where the scans are told nearly as well by it: a wall in two pieces, a bend that nobody needs.

Merging asks whether segments may be one line (paper, section IV-B); here the readings are asked whether two lines need
to be two. The one is laid through both; it is taken where what it loses is less than the price of a line.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from rgcore.geometry.compiled import inner, kernel
from rgcore.lines.worth import DEPTH, FAR, Sights, beams_by_line, cost

_GAP = 0.4  # m between the end of one and the start of the next
_ASIDE = 0.12  # m: no end lies farther off the one line
_LEAST_COS = 0.5  # of the turn from each of the two to the one
_ANY = -2  # the region of a line through scattered echoes, which is not known yet
_CROSSED = 0.5  # of a reading: what it costs besides to close what is open
_ROUNDS = 2  # the second joins what the first made


def joined(
    sights: Sights, lines: np.ndarray, of: np.ndarray, region: np.ndarray, price: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lines (K, 2, 2) with pairs made one where that is worth the ``price``; ``of`` (K,), what each is of, ascending.

    Last, by what it was of, what each is of now: of the lesser of the two. ``region`` of the first of these; lines of
    different regions stay two.
    """
    name = np.arange(max(of.max(initial=-1) + 1, len(region)))
    home = np.concatenate([region, np.full(len(name) - len(region), _ANY)])
    for _ in range(_ROUNDS):
        pairs, one = _candidates(lines)
        a, b = home[of[pairs]].T
        alike = (a == b) | (a == _ANY) | (b == _ANY)
        pairs, one = pairs[alike], one[alike]
        if len(pairs) == 0:
            break
        sights.clear()
        sights.add(lines)
        others = Sights(sights.poses, sights.bearings, sights.ranges, sights.weight)
        others.add(one)
        there, taken = np.ones(len(lines), bool), np.zeros(len(one), bool)
        old, new = (sights.line, sights.distance), (others.line, others.distance)
        _join(old, new, sights.ranges, sights.weight, pairs, price, there, taken)
        both = of[pairs[taken]]
        lines, of = np.concatenate([lines[there], one[taken]]), np.concatenate([of[there], both.min(1)])
        for names in both:
            k = name[names]
            name[name == k.max()] = k.min()
        of = name[of]
        order = np.argsort(of, kind="stable")
        lines, of = lines[order], of[order]
    return lines, of, name


def _candidates(lines: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (P, 2) of lines that may be one, and the lines (P, 2, 2) that they would be."""
    if len(lines) == 0:
        return np.zeros((0, 2), int), lines
    near = cKDTree(lines[:, 0]).query_ball_point(lines[:, 1], _GAP)
    pairs = np.array([(a, b) for a, found in enumerate(near) for b in sorted(found) if a != b], int).reshape(-1, 2)
    both = lines[pairs]  # (P, 2, 2, 2)
    d = both[:, :, 1] - both[:, :, 0]
    length = np.hypot(d[..., 0], d[..., 1])
    middle = (length[..., None] * both.mean(2)).sum(1) / length.sum(1)[:, None]
    off = both.mean(2) - middle[:, None]
    spread = np.einsum("pk,pki,pkj->pij", length, off, off) + np.einsum("pk,pki,pkj->pij", length, d, d) / 12.0
    u = np.linalg.eigh(spread)[1][..., 1]
    u *= np.where((u * d.sum(1)).sum(1) < 0, -1.0, 1.0)[:, None]
    rest = both.reshape(-1, 4, 2) - middle[:, None]
    along, aside = rest @ u[..., None], rest @ np.stack([-u[:, 1], u[:, 0]], 1)[..., None]
    alike = np.einsum("pki,pi->pk", d, u) > _LEAST_COS * length
    good = alike.all(1) & (np.abs(aside).max((1, 2)) < _ASIDE)
    reach = np.stack([along.min(1), along.max(1)], 1)
    return pairs[good], (middle[:, None] + reach * u[:, None])[good]


@kernel
def _join(old, new, ranges, weight, pairs, price, there, taken):  # type: ignore[no-untyped-def]
    """Takes the pairs that are worth it, the best first; beams ``old`` meet the lines, ``new`` what pairs would be."""
    z, n_beams = ranges.ravel(), ranges.shape[1]
    of_line, of_one = beams_by_line(old[0], there), beams_by_line(new[0], np.ones(len(pairs), np.bool_))
    stamp, gain = np.full(len(z), -1), np.zeros(len(pairs))
    for p in range(len(pairs)):
        gain[p] = price + _gain(p, p, old, new, z, n_beams, weight, pairs, there, taken, of_line, of_one, stamp)
    for p in np.argsort(-gain):
        if gain[p] <= 0.0:
            break
        if not (there[pairs[p, 0]] and there[pairs[p, 1]]):
            continue
        now = _gain(p, len(pairs) + p, old, new, z, n_beams, weight, pairs, there, taken, of_line, of_one, stamp)
        if price + now > 0.0:
            there[pairs[p, 0]] = there[pairs[p, 1]] = False
            taken[p] = True


@inner
def _gain(p, mark, old, new, z, n_beams, weight, pairs, there, taken, of_line, of_one, stamp):  # type: ignore[no-untyped-def]
    """What all readings gain where the one stands for its pair."""
    total = 0.0
    for part in range(3):
        first, beams = of_one if part == 2 else of_line
        own = p if part == 2 else pairs[p, part]
        for e in range(first[own], first[own + 1]):
            b = beams[e]
            if stamp[b] == mark:
                continue
            stamp[b] = mark
            before, after = np.inf, np.inf
            for j in range(DEPTH):
                k = old[0][b, j]
                if k < 0:
                    break
                if there[k]:
                    before = min(before, old[1][b, j])
                    if k != pairs[p, 0] and k != pairs[p, 1]:
                        after = old[1][b, j]
                        break
            for j in range(DEPTH):
                k = new[0][b, j]
                if k < 0:
                    break
                if taken[k]:
                    before, after = min(before, new[1][b, j]), min(after, new[1][b, j])
                if k == p:
                    after = min(after, new[1][b, j])
            total += weight[b // n_beams] * (_loss(before, z[b]) - _loss(after, z[b]))
    return total


@inner
def _loss(r, z):  # type: ignore[no-untyped-def]
    """What is lost of a reading; one that goes through a line is worse than one that nothing predicts."""
    return cost(r < np.inf, r, z) + (_CROSSED if r < z - FAR else 0.0)
