"""What lies under the pointer: the map on the screen as arrays, and a click answered in NumPy.

viser cannot click single lines of a batch, and a node a line would be far too slow; so a click comes as a ray, the map
is projected with the camera of the browser that clicked, and distances are measured in its pixels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from rgcore.model.records import MapObject, RGMap

Kind = Literal["region", "gateway", "line", "object"]

LINE_REACH, GATEWAY_REACH = 7.0, 9.0
"""px at which a line or a gateway still counts as hit"""


@dataclass(frozen=True, order=True)
class Item:
    """A thing of the map, named by its kind and id."""

    kind: Kind
    id: str


class Camera(Protocol):
    """What is used of a viser camera."""

    @property
    def wxyz(self) -> np.ndarray: ...
    @property
    def position(self) -> np.ndarray: ...
    @property
    def fov(self) -> float: ...
    @property
    def image_width(self) -> int: ...
    @property
    def image_height(self) -> int: ...


class Projector:
    """World (..., 3) [m] to screen (..., 2) [px], as the browser with this camera draws it; nan behind the camera."""

    def __init__(self, camera: Camera) -> None:
        w, x, y, z = np.asarray(camera.wxyz, float) / np.linalg.norm(camera.wxyz)
        self.axes = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        self.eye = np.asarray(camera.position, float)
        self.focal = 0.5 * camera.image_height / np.tan(camera.fov / 2)
        self.middle = np.array([camera.image_width, camera.image_height]) / 2

    def __call__(self, points: np.ndarray) -> np.ndarray:
        p = (np.asarray(points, float) - self.eye) @ self.axes
        with np.errstate(divide="ignore", invalid="ignore"):
            out = p[..., :2] / p[..., 2:] * self.focal + self.middle
        out[p[..., 2] <= 1e-6] = np.nan
        return out


class Picker:
    """The arrays of one map, ready for clicks."""

    def __init__(self, map_: RGMap) -> None:
        self.map = map_
        self.lines = list(map_.lines)
        self.line_ends = _flat([[v.start, v.end] for v in map_.lines.values()])
        self.gateways = list(map_.gateways)
        self.gateway_ends = _flat([v.posts for v in map_.gateways.values()])

    def at(
        self,
        camera: Camera,
        screen: tuple[float, float],
        ray: tuple[np.ndarray, np.ndarray],
        lines_first: bool = False,
    ) -> Item | None:
        """The item under the pointer: object before gateway before line before region; or a line before all.

        ``screen``: the pointer on the picture, (0, 0) top left to (1, 1); ``ray``: its origin and direction in the map.
        """
        origin, direction = (np.asarray(v, float) for v in ray)
        project = Projector(camera)
        pixel = np.asarray(screen) * project.middle * 2
        line = _nearest(project(self.line_ends), pixel, LINE_REACH) if self.lines else None
        if lines_first and line is not None:
            return Item("line", self.lines[line])
        if (hit := _first_box(self.map.objects, origin, direction)) is not None:
            return Item("object", hit)
        gateway = _nearest(project(self.gateway_ends), pixel, GATEWAY_REACH) if self.gateways else None
        if gateway is not None:
            return Item("gateway", self.gateways[gateway])
        if line is not None:
            return Item("line", self.lines[line])
        ground = floor_point(origin, direction)
        inside = region_at(self.map, ground) if ground is not None else None
        return Item("region", inside) if inside is not None else None


def floor_point(origin: np.ndarray, direction: np.ndarray) -> np.ndarray | None:
    """(2,) [m] where a ray meets the floor; None if it does not."""
    if abs(direction[2]) < 1e-12:
        return None
    t = -origin[2] / direction[2]
    return None if t < 0 else (origin + t * direction)[:2]


def region_at(map_: RGMap, point: np.ndarray) -> str | None:
    """The region whose floor holds the point, the smallest where several do; None outside of all."""
    found = [
        (r.box.size[0] * r.box.size[1], i)
        for i, r in map_.regions.items()
        if _inside(r.boundary, point) and not any(_inside(h, point) for h in r.holes)
    ]
    return min(found)[1] if found else None


def _inside(ring: tuple[tuple[float, float], ...], point: np.ndarray) -> bool:
    """Even-odd rule."""
    a = np.asarray(ring, float)
    if (point < a.min(0)).any() or (point > a.max(0)).any():
        return False
    b = np.roll(a, -1, 0)
    across = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
    p, q = a[across], b[across]
    x = p[:, 0] + (point[1] - p[:, 1]) * (q[:, 0] - p[:, 0]) / (q[:, 1] - p[:, 1])
    return bool((x > point[0]).sum() % 2)


def _nearest(ends: np.ndarray, pixel: np.ndarray, reach: float) -> int | None:
    """Index of the segment (N, 2, 2) [px] nearest to a pixel, if within ``reach`` [px]."""
    a, d = ends[:, 0], ends[:, 1] - ends[:, 0]
    t = np.clip(((pixel - a) * d).sum(1) / np.maximum((d * d).sum(1), 1e-12), 0, 1)
    distance = np.linalg.norm(a + t[:, None] * d - pixel, axis=1)
    distance = np.where(np.isnan(distance), np.inf, distance)
    best = int(np.argmin(distance))
    return best if distance[best] <= reach else None


def _first_box(objects: dict[str, MapObject], origin: np.ndarray, direction: np.ndarray) -> str | None:
    """The object whose box the ray enters first."""
    hits = [(t, i) for i, o in objects.items() if (t := _enter(o, origin, direction)) is not None]
    return min(hits)[1] if hits else None


def _enter(box: MapObject, origin: np.ndarray, direction: np.ndarray) -> float | None:
    """Distance along a ray to where it enters a box (slabs in the box's own axes); None if it misses."""
    c, s = np.cos(box.yaw), np.sin(box.yaw)
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    o, d = turn @ (origin - np.asarray(box.center)), turn @ direction
    half = np.asarray(box.size) / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.stack([(-half - o) / d, (half - o) / d])
    t = np.where(np.isnan(t), np.array([[-np.inf], [np.inf]]), t)
    near, far = t.min(0).max(), t.max(0).min()
    return float(near) if near <= far and far >= 0 else None


def _flat(ends: list) -> np.ndarray:
    """(N, 2, 2) as (N, 2, 3) on the floor."""
    out = np.zeros((len(ends), 2, 3))
    if ends:
        out[..., :2] = ends
    return out
