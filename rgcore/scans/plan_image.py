"""Floor plans as images: dark = wall, light = free, grey = outside or unknown. And rooms as label images."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from rgcore.errors import InputError
from rgcore.geometry.grid import Grid
from rgcore.scans.floor import FACE, Floor

LIGHT = 230
"""Grey value from which a pixel is free floor; map servers write 254 for free and 205 for unknown."""
DARK = 100
"""Grey value up to which a pixel is a wall."""


def is_image(path: str | Path) -> bool:
    """Whether a file begins as an image does. Raises InputError if it cannot be read."""
    try:
        with open(path, "rb") as f:
            return bool(cv2.haveImageReader(str(path))) and f.read(1) not in (b"{", b"[", b"")
    except OSError as e:
        raise InputError(path, f"cannot read the floor plan: {e.strerror}") from e


def read_floor_image(path: str | Path, resolution: float) -> Floor:
    """A floor from a png or pgm of ``resolution`` [m a pixel], lower left corner at 0, 0.

    The free floor is its largest connected light part; its outline becomes the walls, to within a pixel. An image knows no rooms: the
    floor is one. Raises InputError for a file that is no image or has no free floor.
    """
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise InputError(path, "not an image that can be read; write it as png or pgm")
    if not 0.001 <= resolution <= 1:
        raise InputError(path, f"resolution {resolution:g}: a pixel is between 0.001 and 1 m")
    light = (image[::-1] >= LIGHT).astype(np.uint8)
    _, parts, stats, _ = cv2.connectedComponentsWithStats(light, connectivity=4)
    if len(stats) < 2:
        raise InputError(path, f"no free floor: no pixel is lighter than {LIGHT}")
    free = (parts == 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())).astype(np.uint8)
    segments = _outline(free, image[::-1]) * resolution
    labels = Grid(np.pad(free, 1), np.full(2, -resolution), resolution)
    n = len(segments)
    return Floor(Path(path).stem, None, segments, np.full(n, FACE), np.ones(n, np.int64), labels)


def _outline(free: np.ndarray, image: np.ndarray) -> np.ndarray:
    """(S, 2, 2) outline of a mask in pixels, free to the left; sides towards grey are left out: there the laser sees nothing."""
    scale = 2  # doubled, contours run half a pixel inside of the outline: moved out below
    rings, _ = cv2.findContours(
        np.kron(np.pad(free, 1), np.ones((scale, scale), np.uint8)), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE
    )
    out = []
    for ring in rings:
        points = cv2.approxPolyDP(ring, 0.8 * scale, True)[:, 0].astype(float)
        if len(points) >= 2:
            points = (points + 0.5) / scale - 1
            out.append(np.stack([points, np.roll(points, -1, axis=0)], 1))
    edges = np.concatenate(out)
    along = edges[:, 1] - edges[:, 0]
    left = np.stack([-along[:, 1], along[:, 0]], 1) / np.maximum(np.linalg.norm(along, axis=1), 1e-9)[:, None]
    middle = edges.mean(1)
    inward = _value(free, middle + left) > _value(free, middle - left)
    edges = np.where(inward[:, None, None], edges, edges[:, ::-1])
    outward = np.where(inward[:, None], -left, left)
    return edges[_value(image, middle + outward, 0) <= DARK]


def _value(image: np.ndarray, points: np.ndarray, outside: int = 0) -> np.ndarray:
    x, y = np.floor(points).astype(int).T
    ok = (x >= 0) & (y >= 0) & (x < image.shape[1]) & (y < image.shape[0])
    out = np.full(len(points), outside, np.int64)
    out[ok] = image[y[ok], x[ok]]
    return out


def write_labels(labels: Grid, path: str | Path) -> None:
    """Write a raster of small numbers as a grey png, first row = largest y. Raises OSError."""
    ok, data = cv2.imencode(".png", labels.values[::-1].astype(np.uint8), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    if not ok:
        raise OSError(f"cannot encode {path}")
    Path(path).write_bytes(data.tobytes())
