"""The pose graph: consistent poses from relative ones, sparse and robust.

Gauss-Newton on the manifold of planar poses with a sparse factorisation (Konolige et al., "Efficient sparse pose
adjustment for 2D mapping", IROS 2010), the links re-weighted by dynamic covariance scaling (Agarwal et al., ICRA 2013).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import bsr_matrix, csc_matrix, csr_matrix, eye
from scipy.sparse.linalg import LinearOperator, SuperLU, cg, splu

from rgcore.evidence import Evidence
from rgcore.geometry import se2
from rgcore.geometry.compiled import kernel
from rgcore.slam.small import between, times, wrapped

MOST_GRADIENTS = 12
"""Conjugate gradients after which a new factorisation is the better way."""
_SYMMETRIC: dict[str, Any] = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}


@dataclass(frozen=True, eq=False)
class Links(Evidence):
    """Relative poses that were measured (L links).

    a, b         (L,)       numbers of the two poses
    a_from_b     (L, 3)     what was measured
    information  (L, 3, 3)  its inverse covariance, axes of a; singular where scans do not see a direction
    scale        (L,)       chi squared above which scaling takes weight off; inf for a link beyond doubt
    """

    a: np.ndarray
    b: np.ndarray
    a_from_b: np.ndarray
    information: np.ndarray
    scale: np.ndarray

    @classmethod
    def none(cls) -> Links:
        """No links."""
        return cls(np.zeros(0, int), np.zeros(0, int), np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros(0))

    def plus(self, *others: Links) -> Links:
        """These and the others in one."""
        every = (self, *others)
        return Links(
            np.concatenate([k.a for k in every]),
            np.concatenate([k.b for k in every]),
            np.concatenate([k.a_from_b for k in every]),
            np.concatenate([k.information for k in every]),
            np.concatenate([k.scale for k in every]),
        )


def residuals(poses: np.ndarray, links: Links) -> np.ndarray:
    """(L, 3) by how much the poses (N, 3) differ from the links, in the axes of ``a``."""
    off = se2.relative(poses[links.a], poses[links.b]) - links.a_from_b
    off[:, 2] = se2.wrap(off[:, 2])
    return off


def chi_squared(poses: np.ndarray, links: Links) -> np.ndarray:
    """(L,) squared residuals in units of their deviation."""
    off = residuals(poses, links)
    return np.einsum("li,lij,lj->l", off, links.information, off)


def tension(poses: np.ndarray, links: Links) -> float:
    """Sum of the chi squared of all links; one that may be wrong counts for no more than its scale."""
    return float(np.minimum(chi_squared(poses, links), links.scale).sum())


def optimise(poses: np.ndarray, links: Links, rounds: int = 10, enough: float = 1e-3) -> np.ndarray:
    """Poses (N, 3) that agree best with the links; pose 0 stays where it is.

    A pose that no link holds stays as well. Stops when no pose moves by more than ``enough`` [m or rad].
    """
    if len(poses) < 2 or not len(links):
        return np.array(poses, float)
    order = _order(len(poses), links)
    rank = np.argsort(order)
    poses, links = poses[order], replace(links, a=rank[links.a], b=rank[links.b])
    pattern, slots = _pattern(len(poses), links)
    solve = _Solver(pattern)
    for _ in range(rounds):
        blocks, rhs = np.zeros((len(pattern.indices), 3, 3)), np.zeros((len(poses), 3))
        _assemble(poses, links.a, links.b, links.a_from_b, links.information, links.scale, slots, rank[0], blocks, rhs)
        step = solve(blocks, rhs.ravel())
        poses += step.reshape(-1, 3)
        if np.abs(step).max() < enough:
            break
    poses[:, 2] = se2.wrap(poses[:, 2])
    return poses[rank]


def _order(n: int, links: Links) -> np.ndarray:
    """(n,) the poses in an order that keeps the factors sparse; asked of poses, not of numbers, it takes little."""
    ends = np.concatenate([links.a, links.b]), np.concatenate([links.b, links.a])
    graph = csc_matrix((np.ones(len(ends[0])), ends), (n, n)) + n * len(links) * eye(n, format="csc")
    return np.argsort(splu(graph, "MMD_AT_PLUS_A", **_SYMMETRIC).perm_c)


class _Solver:
    """Solves the normal equations of the rounds: the first are factorised; that makes the next ones, which differ
    little, a matter of a few conjugate gradients.
    """

    def __init__(self, pattern: csr_matrix) -> None:
        self.pattern = pattern
        self._factor: SuperLU | None = None

    def __call__(self, blocks: np.ndarray, rhs: np.ndarray) -> np.ndarray:
        h = bsr_matrix((blocks, self.pattern.indices, self.pattern.indptr))
        if self._factor is not None:
            near = LinearOperator(h.shape, self._factor.solve, dtype=float)
            step, failed = cg(h, rhs, rtol=1e-8, maxiter=MOST_GRADIENTS, M=near)
            if not failed:
                return np.asarray(step)
        h = h.tocsr()
        h = csc_matrix((h.data, h.indices, h.indptr), shape=h.shape)  # it is symmetric
        self._factor = splu(h, "NATURAL", relax=20, **_SYMMETRIC)
        return np.asarray(self._factor.solve(rhs))


def _pattern(n: int, links: Links) -> tuple[csr_matrix, np.ndarray]:
    """Which 3 x 3 blocks there are, and where they are: those aa, ab, ba, bb of each link (4 L), then the diagonal
    (n).
    """
    a, b, own = links.a, links.b, np.arange(n)
    keys = np.stack([a * n + a, a * n + b, b * n + a, b * n + b], 1)
    blocks, slots = np.unique(np.concatenate([own * n + own, keys.ravel()]), return_inverse=True)
    indptr = np.searchsorted(blocks // n, np.arange(n + 1))
    pattern = csr_matrix((np.ones(len(blocks)), blocks % n, indptr), shape=(n, n))
    return pattern, np.concatenate([slots[n:].reshape(-1), slots[:n]])


@kernel
def _assemble(poses, a, b, measured, information, scale, slots, anchor, blocks, rhs):  # type: ignore[no-untyped-def]
    """Adds the normal equations of all links into ``blocks`` (S, 3, 3) and ``rhs`` (N, 3)."""
    n = len(a)
    j = np.zeros((2, 3, 3))  # derivatives of the residual by pose a and by pose b
    t = np.zeros((2, 3, 3))  # the same, times the information
    j[0, 2, 2], j[1, 2, 2] = -1.0, 1.0
    ends = np.zeros(2, np.int64)
    for k in range(n):
        ends[0], ends[1] = a[k], b[k]
        p, q = poses[a[k]], poses[b[k]]
        off = between(p, q)
        c, s, x, y = np.cos(p[2]), np.sin(p[2]), off[0], off[1]
        for i in range(3):
            off[i] -= measured[k, i]
        off[2] = wrapped(off[2])
        pull = times(information[k], off)
        chi = off[0] * pull[0] + off[1] * pull[1] + off[2] * pull[2]
        w = min(1.0, 2.0 / (1.0 + chi / scale[k])) ** 2
        j[1, 0, 0], j[1, 0, 1], j[1, 1, 0], j[1, 1, 1] = c, s, -s, c
        j[0, 0, 0], j[0, 0, 1], j[0, 1, 0], j[0, 1, 1] = -c, -s, s, -c
        j[0, 0, 2], j[0, 1, 2] = y, -x
        for e in range(2):
            for u in range(3):
                total = 0.0
                for v in range(3):
                    total += j[e, v, u] * pull[v]
                    t[e, u, v] = 0.0
                    for m in range(3):
                        t[e, u, v] += w * j[e, m, u] * information[k, m, v]
                rhs[ends[e], u] -= w * total
        for e in range(2):
            for f in range(2):
                slot = slots[4 * k + 2 * e + f]
                for u in range(3):
                    for v in range(3):
                        for m in range(3):
                            blocks[slot, u, v] += t[e, u, m] * j[f, m, v]
    for i in range(len(poses)):  # what holds a pose without links; and the anchor
        for u in range(3):
            blocks[slots[4 * n + i], u, u] += 1e12 if i == anchor else 1e-6
