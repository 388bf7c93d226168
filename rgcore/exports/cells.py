"""The corrected map as cells of a raster: for formats that know no lines."""

from __future__ import annotations

import numpy as np

from rgcore.errors import RgError
from rgcore.geometry.grid import Grid, draw_lines, fill_polygons
from rgcore.model.records import MapObject, Region, RGMap

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
"""Values of a cell, as in an occupancy grid of ROS."""

MARGIN = 1.0
"""m of unknown cells around everything."""

WALL = 0.2
"""m to both sides of a gateway's posts that are free: the wall it is in."""

MOST_CELLS = 100_000_000
"""A raster of more cells is a setting gone wrong: 500 x 500 m at 5 cm."""


def occupancy(map: RGMap, resolution: float) -> Grid:
    """(H, W) int8 FREE inside of regions, OCCUPIED on lines (clutter left out) and objects, UNKNOWN elsewhere.

    The raster's lower left corner lies on a whole number of cells. Raises RgError for a map of too many cells.
    """
    grid = _frame(map, resolution)
    free = np.zeros(grid.shape, bool)
    for r in map.regions.values():
        free |= inside(grid, r)
    sills = [_in_cells(grid, _sill(np.array(g.posts))) for g in map.gateways.values()]
    free = fill_polygons(free, sills, True)
    solid = np.zeros(grid.shape, bool)
    solid = fill_polygons(solid, [_in_cells(grid, footprint(o)) for o in map.objects.values()], True)
    ends = np.array([(v.start, v.end) for v in map.lines.values() if not v.clutter], float).reshape(-1, 2, 2)
    solid |= draw_lines(grid.shape, grid.cells(ends[:, 0]), grid.cells(ends[:, 1]))
    return grid.like(np.where(solid, OCCUPIED, np.where(free, FREE, UNKNOWN)).astype(np.int8))


def inside(grid: Grid, region: Region) -> np.ndarray:
    """(H, W) mask of the cells of a region, without its holes."""
    mask = fill_polygons(np.zeros(grid.shape, bool), [_in_cells(grid, np.array(region.boundary))], True)
    return fill_polygons(mask, [_in_cells(grid, np.array(h)) for h in region.holes], False)


def footprint(o: MapObject) -> np.ndarray:
    """(4, 2) m, the corners of an object on the floor, counter-clockwise."""
    along = 0.5 * o.size[0] * np.array([np.cos(o.yaw), np.sin(o.yaw)])
    across = 0.5 * o.size[1] * np.array([-np.sin(o.yaw), np.cos(o.yaw)])
    return np.array(o.center[:2]) + np.array([-along - across, along - across, along + across, across - along])


def _sill(posts: np.ndarray) -> np.ndarray:
    """(4, 2) m, the floor of a gateway: regions may end at either face of the wall that it is in."""
    along = (posts[1] - posts[0]) / max(float(np.hypot(*(posts[1] - posts[0]))), 1e-9)
    normal = WALL * np.array([-along[1], along[0]])
    return np.array([posts[0] - normal, posts[1] - normal, posts[1] + normal, posts[0] + normal])


def _frame(map: RGMap, resolution: float) -> Grid:
    points = [p for v in map.lines.values() for p in (v.start, v.end)]
    points += [p for r in map.regions.values() for p in r.boundary]
    points += [tuple(p) for o in map.objects.values() for p in footprint(o)]
    if not points:
        raise RgError("the map is empty: there is nothing to make a raster of")
    corners = np.array(points, float)
    low = np.floor((corners.min(0) - MARGIN) / resolution)
    width, height = (np.ceil((corners.max(0) + MARGIN) / resolution) - low).astype(int)
    if int(width) * int(height) > MOST_CELLS:
        raise RgError(f"a raster of {width} x {height} cells of {resolution:g} m is too large; take larger cells")
    return Grid(np.zeros((height, width), bool), low * resolution, resolution)


def _in_cells(grid: Grid, points: np.ndarray) -> np.ndarray:
    return np.asarray((points - grid.origin) / grid.resolution)
