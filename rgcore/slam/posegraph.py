"""The pose graph: consistent poses from relative ones, sparse and robust.

Gauss-Newton on the manifold of planar poses with a sparse factorisation (Konolige et al., "Efficient sparse pose
adjustment for 2D mapping", IROS 2010), the links re-weighted by dynamic covariance scaling (Agarwal et al., ICRA 2013).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from rgcore.evidence import Evidence
from rgcore.geometry import se2


@dataclass(frozen=True, eq=False)
class Links(Evidence):
    """Relative poses that were measured (L links).

    a, b         (L,)       numbers of the two poses
    a_from_b     (L, 3)     what was measured
    information  (L, 3, 3)  its inverse covariance in the axes of a; may be singular where the scans do not see a direction
    scale        (L,)       chi squared above which dynamic covariance scaling takes weight off; inf for a link beyond doubt
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


def weights(poses: np.ndarray, links: Links) -> np.ndarray:
    """(L,) what dynamic covariance scaling leaves of each link's information, 0..1."""
    return np.minimum(1.0, 2.0 / (1.0 + chi_squared(poses, links) / links.scale)) ** 2


def optimise(poses: np.ndarray, links: Links, rounds: int = 10, enough: float = 1e-4) -> np.ndarray:
    """Poses (N, 3) that agree best with the links; pose 0 stays where it is.

    A pose that no link holds stays as well. Stops when no pose moves by more than ``enough`` [m or rad].
    """
    poses = np.array(poses, float)
    if len(poses) < 2 or not len(links):
        return poses
    for _ in range(rounds):
        step = _step(poses, links)
        poses += step
        if np.abs(step).max() < enough:
            break
    poses[:, 2] = se2.wrap(poses[:, 2])
    return poses


def _step(poses: np.ndarray, links: Links) -> np.ndarray:
    """One Gauss-Newton step (N, 3)."""
    n = len(poses)
    off, ja, jb = residuals(poses, links), *_jacobians(poses, links)
    info = weights(poses, links)[:, None, None] * links.information
    ta, tb = np.einsum("lki,lkj->lij", ja, info), np.einsum("lki,lkj->lij", jb, info)
    blocks = np.concatenate([ta @ ja, ta @ jb, tb @ ja, tb @ jb])
    a, b = links.a, links.b
    row, column = np.concatenate([a, a, b, b]), np.concatenate([a, b, a, b])
    three = np.arange(3)
    i = np.broadcast_to(3 * row[:, None, None] + three[:, None], blocks.shape)
    j = np.broadcast_to(3 * column[:, None, None] + three[None, :], blocks.shape)
    rhs = np.zeros((n, 3))
    np.add.at(rhs, a, -np.einsum("lij,lj->li", ta, off))
    np.add.at(rhs, b, -np.einsum("lij,lj->li", tb, off))
    h = csc_matrix((blocks.ravel(), (i.ravel(), j.ravel())), shape=(3 * n, 3 * n))
    keep = slice(3, None)  # pose 0 is the anchor
    h = h[keep, keep] + _damping(n - 1)
    step = splu(h, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve(
        rhs.ravel()[keep]
    )
    return np.concatenate([np.zeros((1, 3)), step.reshape(-1, 3)])


def _damping(n: int) -> csc_matrix:
    """What keeps a pose without links, or a direction that none of them sees, where it is: next to nothing."""
    diagonal = np.arange(3 * n)
    return csc_matrix((np.full(3 * n, 1e-6), (diagonal, diagonal)), shape=(3 * n, 3 * n))


def _jacobians(poses: np.ndarray, links: Links) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives (L, 3, 3) of the residuals by pose a and by pose b."""
    pa, pb = poses[links.a], poses[links.b]
    c, s = np.cos(pa[:, 2]), np.sin(pa[:, 2])
    dx, dy = (pb - pa)[:, 0], (pb - pa)[:, 1]
    ja, jb = np.zeros((len(pa), 3, 3)), np.zeros((len(pa), 3, 3))
    jb[:, 0, 0], jb[:, 0, 1], jb[:, 1, 0], jb[:, 1, 1], jb[:, 2, 2] = c, s, -s, c, 1
    ja[:, :2, :2] = -jb[:, :2, :2]
    ja[:, 0, 2], ja[:, 1, 2], ja[:, 2, 2] = -s * dx + c * dy, -c * dx - s * dy, -1
    return ja, jb
