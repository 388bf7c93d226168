"""A random floor as scans from random places in it see it, to train on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rgcore.config import Places as Settings
from rgcore.geometry.grid import fill_polygons, reach
from rgcore.places.floors import RASTER, Floor, corners
from rgcore.places.freespace import FreeSpace, free_space
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory


def scanned(floor: Floor, rng: np.random.Generator, settings: Settings) -> FreeSpace:
    """The free space that scans from random positions see; turns the gateways of the floor into the map frame."""
    truth, place = raster(floor)
    floor.gateways[:] = [(place(a), place(b), kind) for a, b, kind in floor.gateways]
    floor.gateways += [(place(a), place(b), "door") for a, b in floor.spans]
    spots = []
    for x0, y0, x1, y1 in floor.rooms:
        if rng.random() < 0.1:
            continue
        n = 2 + rng.poisson((x1 - x0) * (y1 - y0) / 4)
        spots += [place(np.array([rng.uniform(x0, x1), rng.uniform(y0, y1)])) for _ in range(n)]
    for space in floor.spaces:
        part = rng.dirichlet(np.ones(len(space)), 4)
        spots += list(place(part @ space))
    spots += [(a + b) / 2 for a, b, kind in floor.gateways if kind == "door" and rng.random() < 0.8]
    position = np.array(spots)
    cells = np.floor(position / RASTER).astype(int)
    position = position[truth[cells[:, 1], cells[:, 0]]]
    bearings = np.radians(np.arange(-180, 180, 1.0))
    heading = rng.uniform(-np.pi, np.pi, len(position))
    angle = heading[:, None] + bearings
    direction = np.stack([np.cos(angle), np.sin(angle)], -1).reshape(-1, 2)
    far = 20.0 / RASTER
    r = reach(truth, np.repeat(position / RASTER, len(bearings), axis=0), direction, far) * RASTER
    echo = np.repeat(position, len(bearings), axis=0) + r[:, None] * direction
    for x, y, radius in floor.glass:
        inside = np.hypot(*(echo - place(np.array([x, y]))).T) < radius
        r[inside & (rng.random(len(r)) < 0.7)] = np.nan
    r = np.where(r >= 20.0, np.inf, r + rng.normal(0, 0.012, len(r))).reshape(angle.shape)
    poses = np.c_[position + rng.normal(0, rng.uniform(0, 0.02), position.shape), heading]
    zero = np.zeros(3)
    log = ScanLog(np.arange(len(r)), r, poses, bearings, zero, 30.0)
    return free_space(log, Trajectory(log.stamps, poses, zero), settings)


def raster(floor: Floor) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """The floor drawn as a mask of free cells, turned by its angle, and the function from plan to map [m]."""
    c, s = np.cos(floor.turn), np.sin(floor.turn)
    turn = np.array([[c, s], [-s, c]])
    rects = [*(corners(r) for r in [*floor.rooms, *floor.doors]), *floor.spaces]
    low = np.concatenate([r @ turn for r in rects]).min(0) - 1.0
    size = np.ceil((np.concatenate([r @ turn for r in rects]).max(0) + 1.0 - low) / RASTER).astype(int)

    def place(points: np.ndarray) -> np.ndarray:
        return points @ turn - low

    mask = np.zeros((size[1], size[0]), bool)
    for value, shapes in ((True, rects), (False, floor.blocked)):
        mask = fill_polygons(mask, [place(r) / RASTER for r in shapes], value)
    return mask, place
