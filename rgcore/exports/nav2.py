"""The map for Nav2's map server: ``.yaml`` and ``.pgm`` of the corrected lines, and masks for its costmap filters.

The origin has no yaw (many readers ignore one). Beside the map stand a keepout mask (regions of the classes in
``KEEPOUT``) and a speed mask (percent of the top speed by class, in gateways that are narrow too); both in mode
``raw``, whose pixels are the values of the cells.
"""

from __future__ import annotations

import cv2
import numpy as np
import yaml

from rgcore.exports.cells import FREE, OCCUPIED, inside, occupancy
from rgcore.exports.options import Exported, Options
from rgcore.geometry.grid import Grid
from rgcore.model.records import RGMap
from rgcore.slam.trajectory import Trajectory

KEEPOUT = ("keepout", "forbidden", "private", "no entry")
"""Classes of regions that a robot keeps out of; people make them by that name."""

SPEED = {"CC": 50, "TOMA": 70}
"""Percent of the top speed by class of region; others are not limited."""

NARROW = 1.2
"""m; in gateways narrower than this a robot drives at ``NARROW_SPEED`` percent."""
NARROW_SPEED = 50
AROUND = 0.6
"""m about a narrow gateway's middle where that holds, beyond half its width."""

_GREY = {OCCUPIED: 0, FREE: 254}
_UNKNOWN = 205
_FREE_BELOW = 0.196  # 205 is 0.19608 occupied: with the usual 0.25 all that is unknown would be read as free
_LOST = (
    "names, classes, gateways and accuracy: the grid is free, occupied or unknown",
    "lines marked as clutter, and everything thinner than a cell",
)


def render(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """The YAML file; beside it the grid and the two masks with theirs."""
    cells = occupancy(map, options.resolution)
    grey = np.full(cells.shape, _UNKNOWN, np.uint8)
    for value, shade in _GREY.items():
        grey[cells.values == value] = shade
    stem = options.stem
    beside = {".pgm": _pgm(grey)}
    for name, mask in (("keepout", keepout(map, cells)), ("speed", speed(map, cells))):
        beside[f"-{name}.pgm"] = _pgm(mask)
        beside[f"-{name}.yaml"] = _yaml(f"{stem}-{name}.pgm", cells, "raw")
    return Exported(_yaml(f"{stem}.pgm", cells, "trinary"), beside, _LOST)


def keepout(map: RGMap, cells: Grid) -> np.ndarray:
    """(H, W) uint8: 100 where a robot keeps out, 0 elsewhere."""
    mask = np.zeros(cells.shape, np.uint8)
    for r in map.regions.values():
        if r.class_.casefold() in KEEPOUT:
            mask[inside(cells, r)] = 100
    return mask


def speed(map: RGMap, cells: Grid) -> np.ndarray:
    """(H, W) uint8: percent of the top speed, 0 where there is no limit."""
    mask = np.zeros(cells.shape, np.uint8)
    for r in map.regions.values():
        if r.class_ in SPEED:
            mask[inside(cells, r)] = SPEED[r.class_]
    y, x = np.mgrid[: cells.shape[0], : cells.shape[1]]
    for g in map.gateways.values():
        if g.width < NARROW:
            ix, iy = cells.cells(np.mean(g.posts, axis=0)[None])[0]
            reach = (g.width / 2 + AROUND) / cells.resolution
            near = (x - ix) ** 2 + (y - iy) ** 2 <= reach**2
            mask[near & ((mask == 0) | (mask > NARROW_SPEED))] = NARROW_SPEED
    return mask


def _pgm(grey: np.ndarray) -> bytes:
    """First row = largest y."""
    ok, data = cv2.imencode(".pgm", np.ascontiguousarray(grey[::-1]))
    assert ok
    return bytes(data.tobytes())


def _yaml(image: str, cells: Grid, mode: str) -> bytes:
    x, y = (round(float(v), 6) for v in cells.origin)
    about = {
        "image": image,
        "mode": mode,
        "resolution": cells.resolution,
        "origin": [x, y, 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": _FREE_BELOW,
    }
    return yaml.safe_dump(about, sort_keys=False, allow_unicode=True).encode()
