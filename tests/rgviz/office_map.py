"""An office floor of any size as an RGMap, for tests and measurements of the view: corridors with rooms beside."""

from __future__ import annotations

import numpy as np

from rgcore.model.records import Box2, Gateway, Line, MapObject, Provenance, Region, RGMap, Source, Stats

ROOM_W, ROOM_D, HALL_D = 4.0, 5.0, 2.0
FLOOR_D = 2 * ROOM_D + HALL_D + 1.0
CLASSES = ("TOMA", "TOMA", "CC", "TOMA")


def office_map(rooms: int = 6, floors: int = 1, furniture: int = 1) -> RGMap:
    """``floors`` corridors, one above the other, with ``rooms`` rooms on each side, joined by a corridor on the left.

    Room i of corridor k, below (side 0) or above (side 1), is region ``r{1 + floors + (k * 2 + side) * rooms + i}``.
    """
    build = _Build()
    spine = build.region("spine", "ODMA", (-3.0, 0.0), (0.0, floors * FLOOR_D - 1.0))
    halls = [build.hall(k, rooms) for k in range(floors)]
    for k, hall in enumerate(halls):
        y = k * FLOOR_D + ROOM_D
        build.gateway("junction_T", (spine, hall), (0.0, y), (0.0, y + HALL_D), direction=0.0)
    for k, hall in enumerate(halls):
        for side in (0, 1):
            for i in range(rooms):
                build.room(k, side, i, hall, furniture)
    build.walls_of_spine(floors)
    return RGMap(
        source=Source(log="office.log", sha256="0" * 64, format="carmen"),
        stats=Stats(scans=1000, points=150_000, segments=20 * len(build.lines), accuracy=0.041, accuracy_penalty=1.0),
        lines=build.lines,
        regions=build.regions,
        gateways=build.gateways,
        objects=build.objects,
    )


def big_office(lines: int = 5000) -> RGMap:
    """An office of at least ``lines`` lines: 24 rooms a corridor side, as many corridors as it takes."""
    floors = 1
    while len((m := office_map(24, floors, furniture=3)).lines) < lines:
        floors += 1
    return m


def huge_office() -> RGMap:
    """1,030 regions, 103,000 lines: rooms full of furniture on 21 corridors."""
    return office_map(24, 21, furniture=24)


def points_of(map_: RGMap, step: float = 0.1) -> np.ndarray:
    """(K, 2) float32 echoes along the lines, with laser noise."""
    out = []
    for line in map_.lines.values():
        a, b = np.array(line.start), np.array(line.end)
        n = max(2, int(np.hypot(*(b - a)) / step))
        out.append(a + (b - a) * np.linspace(0, 1, n)[:, None])
    points = np.concatenate(out)
    return (points + np.random.default_rng(0).normal(0, 0.012, points.shape)).astype(np.float32)


class _Build:
    """The floor so far; ids count up as the pipeline's do."""

    def __init__(self) -> None:
        self.lines: dict[str, Line] = {}
        self.regions: dict[str, Region] = {}
        self.gateways: dict[str, Gateway] = {}
        self.objects: dict[str, MapObject] = {}

    def region(self, name: str, class_: str, low: tuple[float, float], high: tuple[float, float]) -> str:
        (x0, y0), (x1, y1) = low, high
        i = f"r{len(self.regions) + 1}"
        scores = {"CDMA": 0.05, "ODMA": 0.05, "TOMA": 0.05, "CC": 0.05, class_: 0.85}
        self.regions[i] = Region(
            id=i,
            name=name or i,
            class_=class_,
            class_scores=scores,
            boundary=((x0, y0), (x1, y0), (x1, y1), (x0, y1)),
            box=Box2(center=((x0 + x1) / 2, (y0 + y1) / 2), size=(x1 - x0 - 0.5, y1 - y0 - 0.5), yaw=0.0),
            axes=(0.0,) if class_ in ("CDMA", "ODMA") else (0.0, np.pi / 2),
            accuracy=0.035 + 0.001 * (len(self.regions) % 7),
            scans=10,
        )
        return i

    def hall(self, k: int, rooms: int) -> str:
        y = k * FLOOR_D + ROOM_D
        i = self.region("", "CDMA", (0.0, y), (rooms * ROOM_W, y + HALL_D))
        self.line((rooms * ROOM_W, y), (rooms * ROOM_W, y + HALL_D), i)
        return i

    def line(self, a: tuple[float, float], b: tuple[float, float], *regions: str) -> str:
        i = f"l{len(self.lines) + 1}"
        self.lines[i] = Line(id=i, start=a, end=b, regions=regions, support=25, residual=0.011)
        return i

    def gateway(
        self, class_: str, regions: tuple[str, str], a: tuple[float, float], b: tuple[float, float], direction: float
    ) -> None:
        mid, step = (np.array(a) + b) / 2, 0.5 * np.array([np.cos(direction), np.sin(direction)])
        i = f"g{len(self.gateways) + 1}"
        self.gateways[i] = Gateway(
            id=i,
            class_=class_,
            confidence=0.9,
            regions=regions,
            posts=(a, b),
            crossing_points=(_point(mid),),
            gateway_points=(_point(mid - step), _point(mid + step)),
            traversal_directions=(direction, direction - np.pi),
            passed=True,
        )

    def room(self, k: int, side: int, i: int, hall: str, furniture: int) -> None:
        """Walls, a door to the hall and boxes of lines against the back wall."""
        x0 = i * ROOM_W
        y0 = k * FLOOR_D + (ROOM_D + HALL_D if side else 0.0)
        x1, y1 = x0 + ROOM_W - 0.2, y0 + ROOM_D
        number = len(self.regions) + 1
        r = self.region(f"office {number}" if number % 3 == 0 else "", CLASSES[(i + side) % 4], (x0, y0), (x1, y1))
        near, back = (y0, y1) if side else (y1, y0)
        inward = 1.0 if side else -1.0
        self.line((x0, near), (x0, back), r)
        self.line((x1, near), (x1, back), r)
        self.line((x0, back), (x1, back), r)
        for a, b in (((x0, near), (x0 + 1.5, near)), ((x0 + 2.4, near), (x1, near))):
            self.line(a, b, r)  # each side of the wall is a line of its own
            self.line((b[0], b[1] - 0.1 * inward), (a[0], a[1] - 0.1 * inward), hall)
        self.gateway("narrow_passage", (hall, r), (x0 + 1.5, near), (x0 + 2.4, near), inward * np.pi / 2)
        for n in range(furniture):
            x, y = x0 + 0.3 + 1.2 * (n % 3), back - inward * (0.4 + 0.57 * (n // 3))
            self.cabinet(r, (x, y - inward * 0.5), (x + 0.9, y), n == 0)

    def cabinet(self, r: str, a: tuple[float, float], b: tuple[float, float], known: bool) -> None:
        (x0, x1), (y0, y1) = sorted((a[0], b[0])), sorted((a[1], b[1]))
        ring = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
        lines = tuple(self.line(ring[n], ring[n - 1], r) for n in range(4))
        if not known:
            return
        i = f"o{len(self.objects) + 1}"
        center = ((x0 + x1) / 2, (y0 + y1) / 2, 0.5)
        self.objects[i] = MapObject(
            id=i, label="cabinet", center=center, size=(x1 - x0, y1 - y0, 1.0), lines=lines, region=r, confidence=0.8,
            provenance=Provenance(),
        )  # fmt: skip

    def walls_of_spine(self, floors: int) -> None:
        top = floors * FLOOR_D - 1.0
        self.line((-3.0, top), (-3.0, 0.0), "r1")
        self.line((0.0, top), (-3.0, top), "r1")
        self.line((-3.0, 0.0), (0.0, 0.0), "r1")


def _point(p: np.ndarray) -> tuple[float, float]:
    return float(p[0]), float(p[1])
