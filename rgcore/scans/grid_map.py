"""Grid maps of ROS (``map.yaml`` and its image) as logs: scans of a virtual laser at poses that are known.

Many users have only a grid. A robot that is not there drives through its free cells and looks around, so that lines,
regions, gateways and classes are found by the same stages as in a log; only the poses need no estimate, and there is
no accuracy, since nothing was measured.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml

from rgcore.errors import InputError
from rgcore.geometry import se2
from rgcore.geometry.compiled import kernel
from rgcore.geometry.grid import Grid, components
from rgcore.scans.drive import Driving, drive
from rgcore.scans.floor import FACE, Floor
from rgcore.scans.image_size import image_size
from rgcore.scans.log import ScanLog
from rgcore.scans.plan_image import walls

FREE, OCCUPIED, UNKNOWN = 0, 100, -1

MODES = ("trinary", "scale", "raw")
BEAMS = 720
RANGE = 30.0
"""m, how far the virtual laser sees."""
SPECK = 3
"""Occupied cells that hang together in smaller numbers are noise of the mapper."""
LEAST_AREA = 1.0
"""m^2: smaller free parts are gaps between things, not places."""
VIRTUAL = Driving(radius=0.2, step=0.4, turn=1.6)
"""How the virtual robot drives: it is small, and sees all around."""

_MOST = 64_000_000  # cells: 400 x 400 m at 5 cm
_UNSEEN = 205  # grey of unknown cells, as map savers write it
_LOOSE = (0.196, 0.3)  # a free_thresh in here takes that grey for free: a known slip of map savers


@dataclass(frozen=True)
class GridMap:
    """``cells`` (int8 FREE, OCCUPIED, UNKNOWN) in a frame of their own; ``map_from_grid`` (3,) places it."""

    cells: Grid
    map_from_grid: np.ndarray
    notes: tuple[str, ...]
    sha256: str


def is_grid_map(path: Path) -> bool:
    """Whether a file is the YAML file of a grid map."""
    if path.suffix.lower() not in (".yaml", ".yml") or not path.is_file():
        return False
    with path.open("rb") as f:
        head = f.read(4096)
    return b"image:" in head and b"resolution:" in head


def read_grid(path: Path) -> GridMap:
    """The cells of a map as ROS's map server publishes them. Raises InputError that names the setting at fault."""
    about = _settings(path)
    image = path.parent / str(about["image"])
    pixels = _pixels(path, image)
    resolution = _number(path, about, "resolution", 0.001, 1.0)
    origin: Any = about.get("origin")
    try:
        x, y, yaw = (float(v) for v in origin)
    except (TypeError, ValueError):
        raise InputError(path, f"origin must be [x, y, yaw], not {origin}") from None
    if not np.isfinite([x, y, yaw]).all() or np.abs([x, y]).max() > 1e6:
        raise InputError(path, f"origin {origin} is not finite metres")
    mode = str(about.get("mode", "trinary"))
    if mode not in MODES:
        raise InputError(path, f"mode '{mode[:20]}' is not known; known are: {', '.join(MODES)}")
    values, notes = _values(path, about, pixels, mode)
    digest = hashlib.sha256(path.read_bytes() + image.read_bytes()).hexdigest()
    cells = Grid(values[::-1].copy(), np.zeros(2), resolution)
    return GridMap(cells, np.array([x, y, float(se2.wrap(yaw))]), notes, digest)


def read(path: Path) -> ScanLog:
    """The grid as a log whose odometry is exact (``surveyed``). Raises InputError for a grid without free cells."""
    grid = read_grid(path)
    solid = grid.cells.values == OCCUPIED
    parts, stats = components(solid, diagonal=True)
    specks = solid & (stats[:, cv2.CC_STAT_AREA] < SPECK)[parts]
    cells = grid.cells.like(np.where(specks, FREE, grid.cells.values).astype(np.int8))
    poses = _views(path, cells)
    bearings = np.linspace(-np.pi, np.pi, BEAMS, endpoint=False)
    ranges = _look(
        cells.values, poses / np.array([cells.resolution, cells.resolution, 1]), bearings, RANGE / cells.resolution
    )
    notes = [*grid.notes, "a grid map: scans are of a virtual laser, and there is no accuracy"]
    if specks.any():
        notes.append(f"{int(specks.sum())} occupied cells that stand alone are passed over")
    return ScanLog(
        stamps=np.arange(len(poses), dtype=float),
        ranges=ranges * cells.resolution,
        odom_from_base=se2.compose(grid.map_from_grid, poses),
        bearings=bearings,
        base_from_laser=np.zeros(3),
        max_range=RANGE,
        source=path.name,
        sha256=grid.sha256,
        format="grid",
        notes="\n".join(notes),
        surveyed=True,
    )


def _views(path: Path, cells: Grid) -> np.ndarray:
    """(N, 3) poses of the virtual robot [m, grid frame], part by part of the free floor, the largest first."""
    parts, stats = components(cells.values == FREE)
    areas = stats[:, cv2.CC_STAT_AREA] * cells.resolution**2
    out = []
    for part in np.argsort(-areas):
        free = parts == part
        if part == 0 or areas[part] < LEAST_AREA:
            continue
        floor = _floor(path, cells, free)
        if not len(floor.segments):
            continue  # nowhere in it is a wall to be seen
        try:
            out.append(drive(floor, VIRTUAL).poses)
        except InputError:
            continue  # nowhere in it does a robot fit
    if not out:
        raise InputError(
            path, "the grid has no free floor with walls that a robot fits in; check negate and the thresholds"
        )
    return np.concatenate(out)


def _floor(path: Path, cells: Grid, free: np.ndarray) -> Floor:
    mask = cells.like(free)
    outline = walls(mask, cells.values == OCCUPIED)
    n = len(outline)
    return Floor(
        str(path), path.stem, None, outline, np.full(n, FACE), np.ones(n, np.int64), mask.like(free.astype(np.uint8))
    )


@kernel
def _look(values: np.ndarray, poses: np.ndarray, bearings: np.ndarray, limit: float) -> np.ndarray:
    """(N, B) ranges [cells] by walking from cell to cell (Amanatides & Woo 1987).

    A beam ends at the middle of its chord through the first occupied cell: walls are where cells are, on the average.
    nan where it comes to an unknown cell or leaves the grid, inf where it meets nothing within ``limit``.
    """
    height, width = values.shape
    out = np.full((len(poses), len(bearings)), np.nan)
    for n in range(len(poses)):
        for b in range(len(bearings)):
            angle = poses[n, 2] + bearings[b]
            dx, dy = np.cos(angle), np.sin(angle)
            ix, iy = int(np.floor(poses[n, 0])), int(np.floor(poses[n, 1]))
            step_x, step_y = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
            per_x = 1.0 / abs(dx) if dx != 0 else np.inf
            per_y = 1.0 / abs(dy) if dy != 0 else np.inf
            next_x = ((ix + (1 if dx > 0 else 0)) - poses[n, 0]) / dx if dx != 0 else np.inf
            next_y = ((iy + (1 if dy > 0 else 0)) - poses[n, 1]) / dy if dy != 0 else np.inf
            entered = 0.0
            while True:
                if ix < 0 or iy < 0 or ix >= width or iy >= height or values[iy, ix] == -1:
                    break
                if values[iy, ix] == 100:
                    out[n, b] = entered
                    break
                entered = min(next_x, next_y)
                if entered > limit:
                    out[n, b] = np.inf
                    break
                if next_x < next_y:
                    ix += step_x
                    next_x += per_x
                else:
                    iy += step_y
                    next_y += per_y
    return out


def _values(path: Path, about: dict[str, Any], pixels: np.ndarray, mode: str) -> tuple[np.ndarray, tuple[str, ...]]:
    """(H, W) int8 cells of pixels (H, W, 2: shade and opacity in 0..1), by the rules of ROS's map server."""
    shade, opaque = pixels[..., 0], pixels[..., 1] >= 1
    taken = _number(path, about, "occupied_thresh", 0, 1, 0.65)
    free = _number(path, about, "free_thresh", 0, 1, 0.25)
    if free >= taken:
        raise InputError(path, f"free_thresh {free:g} must be below occupied_thresh {taken:g}")
    if mode == "raw":
        value = np.rint(shade * 255)
        known = value <= 100
        return _trinary(known & (value >= 100 * taken), known & (value <= 100 * free)), ()
    occupied = shade if about.get("negate") in (1, True) else 1 - shade
    notes: tuple[str, ...] = ()
    unseen = np.isclose(shade, _UNSEEN / 255, atol=1e-3)
    if about.get("negate") not in (1, True) and _LOOSE[0] < free <= _LOOSE[1] and unseen.any():
        free = _LOOSE[0]
        notes = (f"free_thresh {about.get('free_thresh', 0.25)} would take unknown cells for free; 0.196 is used",)
    seen = opaque if mode == "scale" else np.ones(shade.shape, bool)
    return _trinary(seen & (occupied > taken), seen & (occupied < free)), notes


def _trinary(occupied: np.ndarray, free: np.ndarray) -> np.ndarray:
    return np.where(occupied, OCCUPIED, np.where(free, FREE, UNKNOWN)).astype(np.int8)


def _settings(path: Path) -> dict[str, Any]:
    try:
        about = yaml.safe_load(path.read_bytes()[: 1 << 20])
    except (yaml.YAMLError, ValueError, RecursionError) as e:
        raise InputError(path, f"not YAML: {(str(e).splitlines() or ['damaged'])[0]}") from e
    if not isinstance(about, dict) or "image" not in about:
        raise InputError(path, "no grid map: it must name image, resolution and origin")
    return about


def _number(path: Path, about: dict[str, Any], name: str, low: float, high: float, usual: float | None = None) -> float:
    try:
        value = float(about[name] if usual is None else about.get(name, usual))
    except (KeyError, TypeError, ValueError):
        raise InputError(path, f"{name} must be a number, not {about.get(name)!r}") from None
    if not low <= value <= high:
        raise InputError(path, f"{name} {value:g} must lie between {low:g} and {high:g}")
    return value


def _pixels(path: Path, image: Path) -> np.ndarray:
    """(H, W, 2) shade and opacity in 0..1 of the image of a map."""
    if not image.is_file():
        raise InputError(path, f"its image {image.name} is not there; put it beside the file")
    raw = image.read_bytes()
    width, height = image_size(raw)
    try:
        data = (
            None
            if not 0 < width * height <= _MOST
            else cv2.imdecode(np.frombuffer(raw, np.uint8), cv2.IMREAD_UNCHANGED)
        )
        height, width = (height, width) if data is None else data.shape[:2]
    except cv2.error:
        data = None
    if width * height > _MOST:
        raise InputError(image, f"an image of {width} x {height} pixels is too large; give it larger cells")
    if data is None or not data.size:
        raise InputError(image, "not an image that can be read; write it as pgm or png")
    full = 255.0 if data.dtype == np.uint8 else 65535.0 if data.dtype == np.uint16 else 1.0
    planes = data.reshape(*data.shape[:2], -1).astype(np.float32) / full
    colours = planes[..., :3] if planes.shape[2] >= 3 else planes[..., :1]
    alpha = planes[..., -1] if planes.shape[2] in (2, 4) else np.ones(data.shape[:2], np.float32)
    return np.stack([colours.mean(-1), alpha], -1)
