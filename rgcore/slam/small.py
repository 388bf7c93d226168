"""Small sums inside compiled loops: single poses (3,) and symmetric 3 x 3 matrices, element by element.

For arrays of poses there is ``geometry.se2``; here its overhead, and the time to compile array expressions, would
count.
"""

from __future__ import annotations

import numpy as np

from rgcore.geometry.compiled import inner, kernel


@inner
def wrapped(angle: float) -> float:
    """The angle in (-pi, pi]."""
    return -((np.pi - angle) % (2.0 * np.pi) - np.pi)


@kernel
def chain(a_from_b: np.ndarray, b_from_c: np.ndarray) -> np.ndarray:
    """``a_from_c``."""
    c, s = np.cos(a_from_b[2]), np.sin(a_from_b[2])
    out = np.empty(3)
    out[0] = a_from_b[0] + c * b_from_c[0] - s * b_from_c[1]
    out[1] = a_from_b[1] + s * b_from_c[0] + c * b_from_c[1]
    out[2] = wrapped(a_from_b[2] + b_from_c[2])
    return out


@kernel
def between(a_from_b: np.ndarray, a_from_c: np.ndarray) -> np.ndarray:
    """``b_from_c``: where c is, seen from b."""
    c, s = np.cos(a_from_b[2]), np.sin(a_from_b[2])
    x, y = a_from_c[0] - a_from_b[0], a_from_c[1] - a_from_b[1]
    out = np.empty(3)
    out[0], out[1], out[2] = c * x + s * y, -s * x + c * y, wrapped(a_from_c[2] - a_from_b[2])
    return out


@inner
def inverse(m: np.ndarray) -> np.ndarray:
    """Inverse (3, 3) of a symmetric matrix; 1e-3 on its diagonal keeps directions without information."""
    xx, yy, tt, xy, xt, yt = m[0, 0] + 1e-3, m[1, 1] + 1e-3, m[2, 2] + 1e-3, m[0, 1], m[0, 2], m[1, 2]
    a, b, c = yy * tt - yt * yt, xt * yt - xy * tt, xy * yt - xt * yy
    det = xx * a + xy * b + xt * c
    out = np.empty((3, 3))
    out[0, 0], out[0, 1], out[0, 2] = a / det, b / det, c / det
    out[1, 0], out[1, 1], out[1, 2] = b / det, (xx * tt - xt * xt) / det, (xt * xy - xx * yt) / det
    out[2, 0], out[2, 1], out[2, 2] = c / det, out[1, 2], (xx * yy - xy * xy) / det
    return out


@inner
def times(m: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Matrix (3, 3) times vector (3,)."""
    out = np.empty(3)
    for i in range(3):
        out[i] = m[i, 0] * v[0] + m[i, 1] * v[1] + m[i, 2] * v[2]
    return out
