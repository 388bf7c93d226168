"""Two rooms on a hallway, as a map and as the run that made it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from rgcore.config import Config
from rgcore.model.records import Box2, Gateway, Line, MapObject, Region, RGMap, Source, Stats
from rgcore.scans.log import ScanLog
from rgcore.slam.trajectory import Trajectory


def rectangle(id: str, name: str, class_: str, low: tuple[float, float], high: tuple[float, float]) -> Region:
    (x0, y0), (x1, y1) = low, high
    return Region(
        id=id,
        name=name,
        class_=class_,
        boundary=((x0, y0), (x1, y0), (x1, y1), (x0, y1)),
        box=Box2(center=((x0 + x1) / 2, (y0 + y1) / 2), size=(x1 - x0 - 0.6, y1 - y0 - 0.6), yaw=0.0),
        axes=(0.0, 1.570796),
    )


def door(id: str, rooms: tuple[str, str], x: float, y: float) -> Gateway:
    return Gateway(
        id=id,
        class_="narrow_passage",
        confidence=0.9,
        regions=rooms,
        posts=((x - 0.5, y), (x + 0.5, y)),
        crossing_points=((x, y),),
        gateway_points=((x, y - 0.5), (x, y + 0.5)),
        traversal_directions=(1.570796, -1.570796),
        passed=True,
    )


def line(id: str, start: tuple[float, float], end: tuple[float, float], *regions: str) -> Line:
    return Line(id=id, start=start, end=end, regions=regions, support=12, residual=0.011)


def two_rooms() -> RGMap:
    """A hallway r1 along x, rooms r2 and r3 above it, doors g1 and g2, a cabinet l6 l7 l8 in r2, an object o1."""
    lines = [
        line("l1", (0.0, 0.0), (8.0, 0.0), "r1"),
        line("l2", (8.0, 2.0), (0.0, 2.0), "r1", "r2"),
        line("l3", (0.0, 2.1), (4.0, 2.1), "r2"),
        line("l4", (4.1, 2.1), (8.0, 2.1), "r3"),
        line("l5", (4.0, 2.1), (4.0, 6.0), "r2"),
        line("l6", (1.0, 5.6), (2.2, 5.6), "r2"),
        line("l7", (1.0, 6.0), (1.0, 5.6), "r2"),
        line("l8", (2.2, 5.6), (2.2, 6.0), "r2"),
        line("l12", (8.0, 6.0), (4.1, 6.0), "r3"),
    ]
    regions = [
        rectangle("r1", "Hallway 1", "CDMA", (0.0, 0.0), (8.0, 2.0)),
        rectangle("r2", "Room 1", "TOMA", (0.0, 2.1), (4.0, 6.0)),
        rectangle("r3", "Room 2", "TOMA", (4.1, 2.1), (8.0, 6.0)),
    ]
    gateways = [door("g1", ("r1", "r2"), 2.0, 2.05), door("g2", ("r1", "r3"), 6.0, 2.05)]
    cabinet = MapObject(
        id="o1", center=(7.5, 5.0, 0.5), size=(1.0, 0.4, 1.0), yaw=1.570796, lines=("l12",), region="r3"
    )
    return RGMap(
        source=Source(
            log="office.log", sha256="ab" * 32, format="carmen", settings={"lines.gap": 0.3}, software="rgviz"
        ),
        stats=Stats(scans=40, points=7000, segments=180, accuracy=0.04, accuracy_penalty=1.0),
        lines={v.id: v for v in lines},
        regions={v.id: v for v in regions},
        gateways={v.id: v for v in gateways},
        objects={"o1": cabinet},
    )


def make_run(map: RGMap, scans: int = 40, moved: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> SimpleNamespace:
    """What a project takes of a run: ``map`` and a drive along the hallway (shifted by ``moved``)."""
    stamps = np.arange(scans) / 2.0
    log = ScanLog(
        stamps,
        np.full((scans, 31), 1.5),
        np.zeros((scans, 3)),
        np.linspace(-1.5, 1.5, 31),
        np.zeros(3),
        80.0,
        source="office.log",
        sha256="ab" * 32,
        format="carmen",
        notes="2 lines of unknown kinds",
    )
    x = np.linspace(0.5, 7.5, scans)
    poses = np.stack([x, np.ones(scans), np.zeros(scans)], 1) + np.array(moved)
    return SimpleNamespace(
        log=log,
        config=Config(),
        trajectory=Trajectory(stamps, poses, np.zeros(3)),
        map=map,
        adaptation=None,
        segments=None,
        seconds={"extract": 0.1, "slam": 1.23456},
    )
