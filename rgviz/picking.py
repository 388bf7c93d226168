"""What lies under the pointer: the map on the screen as arrays, and a click answered in NumPy.

viser cannot click single lines of a batch, and a node a line would be far too slow; so a click comes as a ray, the map
is projected with the camera of the browser that clicked, and distances are measured in its pixels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from rgcore.model.records import RGMap
from rgcore.model.rows import line_ends
from rgviz.drawings import at

Kind = Literal["region", "gateway", "line", "object", "note"]
KINDS: dict[Kind, str] = {
    "region": "regions",
    "gateway": "gateways",
    "line": "lines",
    "object": "objects",
    "note": "notes",
}
"""The table of the map that holds each kind."""

LINE_REACH, GATEWAY_REACH, NOTE_REACH = 7.0, 9.0, 11.0
"""px at which a line, a gateway or a note still counts as hit"""


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
        self.line_ends = at(line_ends(map_.lines), 0.0)
        self.gateways = list(map_.gateways)
        self.gateway_ends = _on_floor([v.posts for v in map_.gateways.values()])
        self.objects = list(map_.objects)
        self.boxes = np.array([(*o.center, *o.size, o.yaw) for o in map_.objects.values()]).reshape(-1, 7)
        self.notes = list(map_.notes)
        self.note_places = _on_floor([(v.place, v.place) for v in map_.notes.values()])

    def at(
        self, camera: Camera, screen: tuple[float, float], ray: tuple[np.ndarray, np.ndarray], want: Kind | None = None
    ) -> Item | None:
        """The item under the pointer: note, object, gateway, line or region, whichever comes first.

        ``screen``: the pointer on the picture, (0, 0) top left to (1, 1); ``ray``: its origin and direction in the map;
        ``want``: only this kind counts.
        """
        origin, direction = (np.asarray(v, float) for v in ray)
        project = Projector(camera)
        pixel = np.asarray(screen) * project.middle * 2
        finders: dict[Kind, Callable[[], str | None]] = {
            "note": lambda: _nearest_of(self.notes, project(self.note_places), pixel, NOTE_REACH),
            "object": lambda: _first_box(self.objects, self.boxes, origin, direction),
            "gateway": lambda: _nearest_of(self.gateways, project(self.gateway_ends), pixel, GATEWAY_REACH),
            "line": lambda: _nearest_of(self.lines, project(self.line_ends), pixel, LINE_REACH),
            "region": lambda: self._region_under(origin, direction),
        }
        for kind, find in finders.items():
            if want in (None, kind) and (id_ := find()) is not None:
                return Item(kind, id_)
        return None

    def _region_under(self, origin: np.ndarray, direction: np.ndarray) -> str | None:
        ground = floor_point(origin, direction)
        return region_at(self.map, ground) if ground is not None else None

    def within(self, camera: Camera, low: tuple[float, float], high: tuple[float, float]) -> tuple[Item, ...]:
        """The items that lie wholly in a rectangle of the picture, kind by kind: lines first, regions last."""
        project = Projector(camera)
        scale = project.middle * 2
        box = np.sort(np.array([low, high]) * scale, axis=0)
        lying: list[tuple[Kind, list[str], np.ndarray]] = [
            ("line", self.lines, self.line_ends),
            ("gateway", self.gateways, self.gateway_ends),
            ("object", self.objects, self.boxes[:, None, :3]),
            ("note", self.notes, self.note_places),
        ]
        found = [
            Item(kind, id_)
            for kind, ids, points in lying
            for id_, yes in zip(ids, _inside_box(project(points), box), strict=True)
            if yes
        ]
        for r in self.map.regions.values():
            ring = np.zeros((1, len(r.boundary), 3))
            ring[0, :, :2] = r.boundary
            if _inside_box(project(ring), box)[0]:
                found.append(Item("region", r.id))
        return tuple(found)


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
    for v, along in zip(point, zip(*ring, strict=True), strict=True):  # most rings lie elsewhere: no array for those
        if not min(along) <= v <= max(along):
            return False
    a = np.asarray(ring, float)
    b = np.roll(a, -1, 0)
    across = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
    p, q = a[across], b[across]
    x = p[:, 0] + (point[1] - p[:, 1]) * (q[:, 0] - p[:, 0]) / (q[:, 1] - p[:, 1])
    return bool((x > point[0]).sum() % 2)


def line_near(map_: RGMap, point: tuple[float, float], reach: float) -> str | None:
    """The line nearest to a place of the floor, if within ``reach`` [m]."""
    return _nearest_of(list(map_.lines), line_ends(map_.lines), np.asarray(point, float), reach)


def _inside_box(points: np.ndarray, box: np.ndarray) -> np.ndarray:
    """(N,) whether all points (N, K, 2) [px] of each lie in the box; what is behind the camera does not."""
    return ((points >= box[0]) & (points <= box[1])).all((1, 2))


def _nearest_of(ids: list[str], ends: np.ndarray, pixel: np.ndarray, reach: float) -> str | None:
    index = _nearest(ends, pixel, reach) if ids else None
    return None if index is None else ids[index]


def _nearest(ends: np.ndarray, pixel: np.ndarray, reach: float) -> int | None:
    """Index of the segment (N, 2, 2) [px] nearest to a pixel, if within ``reach`` [px]."""
    a, d = ends[:, 0], ends[:, 1] - ends[:, 0]
    t = np.clip(((pixel - a) * d).sum(1) / np.maximum((d * d).sum(1), 1e-12), 0, 1)
    distance = np.linalg.norm(a + t[:, None] * d - pixel, axis=1)
    distance = np.where(np.isnan(distance), np.inf, distance)
    best = int(np.argmin(distance))
    return best if distance[best] <= reach else None


def _first_box(ids: list[str], boxes: np.ndarray, origin: np.ndarray, direction: np.ndarray) -> str | None:
    """The object whose box the ray enters first (slabs in the boxes' own axes).

    ``boxes`` (N, 7): centre and size [m], yaw [rad].
    """
    if not ids:
        return None
    c, s, half = np.cos(boxes[:, 6]), np.sin(boxes[:, 6]), boxes[:, 3:6] / 2
    o, d = (
        np.stack([c * v[:, 0] + s * v[:, 1], c * v[:, 1] - s * v[:, 0], v[:, 2]], 1)
        for v in (origin - boxes[:, :3], np.broadcast_to(direction, (len(ids), 3)))
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.stack([(-half - o) / d, (half - o) / d])
    t = np.where(np.isnan(t), np.array([-np.inf, np.inf])[:, None, None], t)
    near, far = t.min(0).max(1), t.max(0).min(1)
    near = np.where((near <= far) & (far >= 0), near, np.inf)
    first = int(np.argmin(near))
    return ids[first] if np.isfinite(near[first]) else None


def _on_floor(ends: list) -> np.ndarray:
    """(N, 2, 2) as (N, 2, 3)."""
    return at(np.array(ends, float).reshape(-1, 2, 2), 0.0)
