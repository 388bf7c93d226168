"""What is drawn while a log is played: the robot, what it sees, its way, and the map as it was then."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from rgcore.geometry.polygons import label_place
from rgcore.model.records import Box2, Gateway, Region, RGMap
from rgcore.online import RegionSoFar
from rgcore.robot.query import Query
from rgviz import theme
from rgviz.drawings import Dots, Drawings, Strokes
from rgviz.play.child import Picture
from rgviz.play.tape import Tape
from rgviz.scene import Canvas, Scene

ECHO: theme.RGB = (206, 46, 62)
RIM: theme.RGB = (255, 255, 255)
SMALLEST, SHARE = 0.3, 0.015
"""radius of the robot's mark: so many metres at least, and so much of what is seen at once, so that it is found"""
Z_ROBOT = 0.09
"""m, above all layers; the parts of the mark lie a little higher each"""
HERE_WIDTH = 3.0
"""pixels, of the outline of the region that the robot is in"""


class Stage:
    """The picture of one moment, in the scene that all browsers share."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        scene.server.scene.add_frame("/play", show_axes=False)
        self._canvas = Canvas(scene.server.scene, "/play")
        self._robot: Any = None
        self._radius = 0.0

    def show(self, tape: Tape, scan: int, picture: Picture | None, width: float) -> None:
        """Robot, echoes, way and region of a scan; ``picture`` is the one that is on show, not later than it.

        ``width`` [m] of what browsers see at once as long as nobody zooms.
        """
        pose = tape.pose(scan)
        with self.scene.server.atomic():
            self._canvas.draw(_drawings(tape, scan, picture))
            self._mark(max(SMALLEST, SHARE * width))
            self._robot.position = (pose[0], pose[1], Z_ROBOT)
            self._robot.wxyz = (np.cos(pose[2] / 2), 0.0, 0.0, np.sin(pose[2] / 2))

    def clear(self) -> None:
        self._canvas.clear()
        self._unmark()

    def _mark(self, radius: float) -> None:
        """A disc with an arrow ahead. Made once, then only moved, but for a map that has grown much."""
        if self._robot is not None and 0.75 < radius / self._radius < 1.33:
            return
        self._unmark()
        scene = self.scene.server.scene
        self._robot, self._radius = scene.add_frame("/play/robot", show_axes=False), radius
        for n, (name, color, corners) in enumerate(_mark(radius)):
            faces = np.array([[0, k, k + 1] for k in range(1, len(corners) - 1)], np.uint32)
            corners = np.column_stack([corners, np.full(len(corners), 0.01 * n)]).astype(np.float32)
            scene.add_mesh_simple(
                f"/play/robot/{name}", corners, faces, color=color, cast_shadow=False, receive_shadow=False
            )

    def _unmark(self) -> None:
        if self._robot is not None:
            self._robot.remove()
            self._robot = None


def _mark(radius: float) -> list[tuple[str, theme.RGB, np.ndarray]]:
    """(K, 2) corners [m] of the parts, the lowest first; convex, counter-clockwise."""
    turn = 2 * np.pi * np.arange(24) / 24
    disc = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    nose = radius * np.array([[0.78, 0.0], [-0.42, 0.52], [-0.42, -0.52]])
    return [("rim", RIM, 1.22 * disc), ("body", theme.BRAND, disc), ("nose", RIM, nose)]


def _drawings(tape: Tape, scan: int, picture: Picture | None) -> Drawings:
    way = tape.way(0 if picture is None else picture.scan, scan)
    region = tape.place(scan)[1]
    here = next((r for r in (picture.regions or () if picture else ()) if r.id == region), None)
    out: Drawings = {
        "echoes": Dots(_at(tape.echoes(scan), theme.Z_SELECTION), ECHO, 0.07),
        "tail": Strokes(_polyline(way), theme.BRAND, theme.THIN_WIDTH),
    }
    if picture is not None:
        out["way"] = Strokes(_polyline(picture.path), theme.BRAND, theme.THIN_WIDTH)
    if here is not None:
        ring = np.array([*here.boundary, here.boundary[0]])
        out["here"] = Strokes(_polyline(ring), theme.BRAND, HERE_WIDTH)
    return out


def map_so_far(picture: Picture, names: dict[str, str]) -> RGMap:
    """The regions and gateways of a picture, as the layers draw them; ``names`` of regions that have one."""
    regions = {r.id: _region(r, names.get(r.id, r.id)) for r in picture.regions or ()}
    gateways = {
        g.id: Gateway(id=g.id, class_="gateway", regions=g.regions, posts=g.posts, passed=g.passed)
        for g in picture.gateways or ()
    }
    return RGMap(regions=regions, gateways=gateways)


def names_in(picture: Picture, map_: RGMap) -> dict[str, str]:
    """What people called the regions of a picture in a finished map of the same log, by the id in the picture."""
    regions = picture.regions or ()
    named = list(map_.regions.values())
    if not regions or all(r.name == r.id for r in named):
        return {}
    middles = np.array([label_place(r.boundary, r.holes)[0] for r in regions])
    found = zip(regions, Query(map_).region_of(middles).tolist(), strict=True)
    return {r.id: named[n].name for r, n in found if n >= 0 and named[n].name != named[n].id}


def _region(r: RegionSoFar, name: str) -> Region:
    x, y = zip(*r.boundary, strict=True)
    size = (max(x) - min(x), max(y) - min(y))
    box = Box2(center=(min(x) + size[0] / 2, min(y) + size[1] / 2), size=size, yaw=0.0)
    class_ = sys.intern(r.class_ or "")  # layers ask whether it is the same object
    return Region(id=r.id, name=name, class_=class_, boundary=r.boundary, holes=r.holes, box=box)


def _polyline(points: np.ndarray) -> np.ndarray:
    """(N, 2) as (N - 1, 2, 3) strokes."""
    at = _at(points, theme.Z_MARK)
    return np.stack([at[:-1], at[1:]], 1)


def _at(points: np.ndarray, z: float) -> np.ndarray:
    return np.column_stack([points, np.full(len(points), z)]).astype(np.float32)
