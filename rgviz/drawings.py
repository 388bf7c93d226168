"""Drawings: what a layer or a tool shows, as plain arrays (no viser here), and the shapes that they are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rgcore.model.records import Box2, MapObject
from rgviz.theme import RGB


@dataclass(frozen=True)
class Strokes:
    """Straight strokes ``ends (N, 2, 3)`` [m] of one colour or one each ``(N, 3)`` (sRGB), ``width`` in pixels."""

    ends: np.ndarray
    color: RGB | np.ndarray
    width: float


@dataclass(frozen=True)
class Faces:
    """Triangles: ``vertices (V, 3)`` [m], ``faces (F, 3)`` counter-clockwise from outside; one colour.

    ``shaded``: each face has its own light; ``both_sides``: seen from behind, too, which costs more.
    """

    vertices: np.ndarray
    faces: np.ndarray
    color: RGB
    opacity: float = 1.0
    shaded: bool = False
    both_sides: bool = False


@dataclass(frozen=True)
class Dots:
    """Points (N, 3) [m] of one colour; ``size`` [m] is half of what they measure across."""

    points: np.ndarray
    color: RGB
    size: float
    shape: str = "circle"


Drawing = Strokes | Faces | Dots
Drawings = dict[str, Drawing]
"""A layer's drawings by the name of their node."""


_QUADS = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
BOX_FACES = np.concatenate([_QUADS[:, [0, 1, 2]], _QUADS[:, [0, 2, 3]]])
BOX_EDGES = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]])


def box_corners(box: Box2) -> np.ndarray:
    """(4, 2) [m], counter-clockwise."""
    c, s = np.cos(box.yaw), np.sin(box.yaw)
    half = np.array(box.size) / 2 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return half @ np.array([[c, s], [-s, c]]) + box.center


def object_corners(o: MapObject) -> np.ndarray:
    """(8, 3) [m]: the bottom counter-clockwise, then the top."""
    flat = box_corners(Box2(center=o.center[:2], size=o.size[:2], yaw=o.yaw))
    bottom, top = o.center[2] - o.size[2] / 2, o.center[2] + o.size[2] / 2
    return np.concatenate([at(flat, bottom), at(flat, top)])


def node_name(text: str) -> str:
    """A class name, which may hold anything, as the name of a node."""
    return "c" + "".join(ch if ch.isascii() and ch.isalnum() else f"_{ord(ch):x}_" for ch in text)


def bounds(points: np.ndarray) -> np.ndarray:
    """(2, 2) lower left and upper right [m]; ten metres around the origin where there is nothing."""
    ok = points[np.isfinite(points).all(1)]
    if not len(ok):
        return np.array([[-5.0, -5.0], [5.0, 5.0]])
    low, high = ok.min(0), ok.max(0)
    pad = np.maximum(0.5 - (high - low) / 2, 0)
    return np.array([low - pad, high + pad])


def ring(corners: np.ndarray | tuple[tuple[float, float], ...]) -> np.ndarray:
    """(N, 2) as the (N, 2, 2) strokes of the closed ring."""
    c = np.asarray(corners, float)
    return np.stack([c, np.concatenate([c[1:], c[:1]])], 1)


def joined(parts: list[np.ndarray], z: float) -> np.ndarray:
    """Strokes (N, 2, 2) of several things as one (M, 2, 3) at height z [m], float32."""
    return at(np.concatenate(parts) if parts else np.zeros((0, 2, 2)), z)


def at(points: np.ndarray, z: float) -> np.ndarray:
    """(..., 2) as (..., 3) at height z [m], float32."""
    out = np.full((*points.shape[:-1], 3), z, np.float32)
    out[..., :2] = points
    return out
