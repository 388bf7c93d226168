"""A small floor to ask about: two hallways, rooms, a narrow door, an island, a door to nowhere, a room without door.

      6   7        13 14 16 16.1      22
12                    ┌──┐ ┌───────────┐
                      │r4│ │  r5  ┌─┐  │
8   ┌────┐ ┌────────┐ │  g4 0.9   │ │  │     r6: off to the right, no gateway
    │ r2 │ │ r3     │ │  │ │      └─┘  │
2.1 └g1──┘ └───g2───┘ └g3┘ └───────────┘
2   ┌─ 1.0 ── 0.62 ── 2.0 ─────────┐
0   └ r1 ──────────── g5 ──────────┘
"""

from __future__ import annotations

from rgcore.model.records import Box2, Gateway, Line, MapObject, Point, Region, RGMap

ISLAND = ((18.0, 8.0), (18.0, 10.0), (20.0, 10.0), (20.0, 8.0))


def rectangle(low: Point, high: Point) -> tuple[Point, ...]:
    return (low, (high[0], low[1]), high, (low[0], high[1]))


def region(id: str, name: str, low: Point, high: Point, *holes: tuple[Point, ...]) -> Region:
    middle = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2)
    size = (high[0] - low[0], high[1] - low[1])
    box = Box2(center=middle, size=size, yaw=0.0)
    return Region(id=id, name=name, class_="TOMA", boundary=rectangle(low, high), holes=holes, box=box)


def door(
    id: str, regions: tuple[str, ...], at: Point, width: float, upright: bool = False, passed: bool = True
) -> Gateway:
    """In a wall along x, its first region below; upright: in one along y, its first region to the left."""
    x, y = at
    along, across = ((0.0, 1.0), (0.5, 0.0)) if upright else ((1.0, 0.0), (0.0, 0.5))
    w = width / 2
    return Gateway(
        id=id,
        class_="narrow_passage",
        regions=regions,
        posts=((x - w * along[0], y - w * along[1]), (x + w * along[0], y + w * along[1])),
        crossing_points=(at,),
        gateway_points=((x - across[0], y - across[1]), (x + across[0], y + across[1]))[: len(regions)],
        passed=passed,
    )


def asked_map() -> RGMap:
    regions = [
        region("r1", "Hallway 1", (0.0, 0.0), (22.0, 2.0)),
        region("r2", "Office", (0.0, 2.1), (6.0, 8.0)),
        region("r3", "Store", (7.0, 2.1), (13.0, 8.0)),
        region("r4", "Hallway 2", (14.0, 2.1), (16.0, 12.0)),
        region("r5", "Lab", (16.1, 2.1), (22.0, 12.0), ISLAND),
        region("r6", "Vault", (23.0, 0.0), (26.0, 3.0)),
    ]
    gateways = [
        door("g1", ("r1", "r2"), (3.0, 2.05), 1.0),
        door("g2", ("r1", "r3"), (10.0, 2.05), 0.62, passed=False),
        door("g3", ("r1", "r4"), (15.0, 2.05), 2.0),
        door("g4", ("r4", "r5"), (16.05, 9.0), 0.9, upright=True),
        door("g5", ("r1",), (12.0, 0.0), 0.8, passed=False),
    ]
    south = Line(id="l1", start=(0.0, 0.0), end=(22.0, 0.0), regions=("r1",))
    east = Line(id="l2", start=(22.0, 0.0), end=(22.0, 2.0), regions=("r1",))
    bench = MapObject(id="o1", label="bench", center=(19.0, 9.0, 0.5), size=(2.0, 2.0, 1.0), region="r5")
    return RGMap(
        lines={v.id: v for v in (south, east)},
        regions={v.id: v for v in regions},
        gateways={v.id: v for v in gateways},
        objects={"o1": bench},
    )
