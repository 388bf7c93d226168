"""Floor plans as images: light = free floor, dark = wall, grey = outside or unknown. And rooms as label images."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from rgcore.errors import InputError
from rgcore.geometry import polygons
from rgcore.geometry.grid import Grid, components
from rgcore.scans.floor import FACE, Floor
from rgcore.scans.image_size import image_size
from rgcore.scans.rings import edges

LIGHT = 230
"""Grey value from which a pixel is free floor; map servers write 254 for free and 205 for unknown."""
DARK = 100
"""Grey value up to which a pixel is a wall."""
MOST_PIXELS = 64_000_000
"""of a plan: 400 x 400 m at 5 cm"""


def is_image(path: str | Path) -> bool:
    """Whether a file begins as an image does. Raises InputError if it cannot be read."""
    try:
        with open(path, "rb"):
            return bool(cv2.haveImageReader(str(path)))
    except OSError as e:
        raise InputError(path, f"cannot read the floor plan: {e.strerror}") from e


def read_floor_image(path: str | Path, resolution: float) -> Floor:
    """A floor from a png or pgm of ``resolution`` [m a pixel]; the image's lower left corner is at 0, 0.

    The free floor is its largest connected light part, and its outline the walls, to within a pixel. An image knows no
    rooms: the floor is one. Raises InputError for a file that is no image or has no free floor.
    """
    image = _grey(path)
    if not 0.001 <= resolution <= 1:
        raise InputError(path, f"a pixel of {resolution:g} m; it must be between 0.001 and 1")
    grey = np.pad(image[::-1], 1, constant_values=205)
    parts, stats = components(grey >= LIGHT)
    if len(stats) < 2:
        raise InputError(path, f"no free floor: no pixel is as light as {LIGHT} of 255")
    free = Grid(parts == 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax()), np.full(2, -resolution), resolution)
    segments = walls(free, grey <= DARK)
    n = len(segments)
    labels = free.like(free.values.astype(np.uint8))
    return Floor(str(path), Path(path).stem, None, segments, np.full(n, FACE), np.ones(n, np.int64), labels)


def _grey(path: str | Path) -> np.ndarray:
    """(H, W) uint8. Raises InputError for what is no image, or one of more pixels than a building has."""
    try:
        data = Path(path).read_bytes()
    except OSError as e:
        raise InputError(path, f"cannot read the floor plan: {e.strerror}") from e
    width, height = image_size(data)
    if width * height > MOST_PIXELS:
        raise InputError(path, f"{width} x {height} pixels; at most {MOST_PIXELS // 10**6} million: save it smaller")
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE) if width and height else None
    except cv2.error:
        image = None
    if image is None:
        raise InputError(path, "not an image that can be read; write it as png or pgm")
    return np.asarray(image)


def walls(free: Grid, solid: np.ndarray) -> np.ndarray:
    """(S, 2, 2) outline of the free floor, free to the left, where it borders on ``solid`` (H, W) and not on grey.

    Nothing is known of what is neither. ``free`` holds one connected part.
    """
    hard = free.like(solid)
    shape = polygons.simplify(polygons.from_mask(free)[0], 0.8 * free.resolution)
    outline, holes = polygons.rings(shape)
    sides = np.concatenate([edges(np.array(ring)) for ring in (outline, *holes)])
    along = sides[:, 1] - sides[:, 0]
    right = np.stack([along[:, 1], -along[:, 0]], 1) / np.linalg.norm(along, axis=1, keepdims=True)
    out = []
    for (start, end), away in zip(sides, right, strict=True):
        n = int(np.ceil(np.hypot(*(end - start)) / free.resolution))
        points = start + np.linspace(0, 1, n + 1)[:, None] * (end - start)
        behind = (points[:-1] + points[1:]) / 2 + 1.5 * free.resolution * away
        there = np.concatenate([[False], hard.at(behind, outside=False), [False]])
        first, last = np.flatnonzero(~there[:-1] & there[1:]), np.flatnonzero(there[:-1] & ~there[1:])
        out.append(np.stack([points[first], points[last]], 1))
    return np.concatenate(out)


def write_labels(labels: Grid, path: str | Path) -> None:
    """Write a raster of small numbers as a grey png, first row = largest y. Raises OSError."""
    ok, data = cv2.imencode(".png", labels.values[::-1].astype(np.uint8), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    if not ok:
        raise OSError(f"cannot encode {path}")
    Path(path).write_bytes(data.tobytes())
