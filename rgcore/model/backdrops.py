"""From the file of a floor plan to the edit that lays it under a map, and where a plan lies."""

from __future__ import annotations

import hashlib
import re

import numpy as np

from rgcore.model.edits_backdrops import AddBackdrop
from rgcore.model.fields import new_id
from rgcore.model.records import Backdrop, Point, RGMap, rounded
from rgcore.scans.backdrop import form_of, read_backdrop

EMPTY = 20.0
"""m: how long a plan lies under a map that holds nothing, if it does not say how large it is"""


def laid(map: RGMap, data: bytes, name: str) -> AddBackdrop:
    """The edit that lays a plan (the bytes of a png, jpg or DXF) in the middle of the map: as large as it says it is,
    else as long as the map. Raises InputError for a file that is no plan."""
    called = title(name)
    plan = read_backdrop(data, called)
    low, high = _extent(map)
    x, y = (low + high) / 2
    return AddBackdrop(
        id=new_id(map, "backdrops"),
        name=called,
        sha256=hashlib.sha256(data).hexdigest(),
        form=form_of(data, called),
        size=plan.size,
        center=(rounded(x), rounded(y)),
        yaw=0.0,
        length=max(plan.size) if plan.measured else float((high - low).max()),
    ).checked()


def title(name: str) -> str:
    """What a file is called on the page: the last part of a path, of plain letters, short."""
    last = re.split(r"[/\\]", name)[-1]
    return "".join(c for c in last if c.isprintable() and not "\ud800" <= c <= "\udfff").strip()[:80].strip() or "plan"


def corners(plan: Backdrop) -> np.ndarray:
    """(4, 2) m, where the lower left, lower right, upper right and upper left corner of a plan lie on the map."""
    return placed(plan, 0.5 * np.array(plan.size) * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]))


def placed(plan: Backdrop, points: np.ndarray) -> np.ndarray:
    """(..., 2) m, where points of a plan (its unit, about its middle, y up) lie on the map."""
    c, s = np.cos(plan.yaw), np.sin(plan.yaw)
    return np.asarray(plan.center + plan.scale * (points @ np.array([[c, s], [-s, c]])))


def _extent(map: RGMap) -> tuple[np.ndarray, np.ndarray]:
    points: list[Point] = [p for r in map.regions.values() for p in r.boundary]
    points = points or [p for v in map.lines.values() for p in (v.start, v.end)]
    if not points:
        return np.full(2, -EMPTY / 2), np.full(2, EMPTY / 2)
    return np.min(points, axis=0), np.max(points, axis=0)
