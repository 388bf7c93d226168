"""Regions and the gateways between them as a graph (GraphML), and as tables (CSV)."""

from __future__ import annotations

import csv
import io
from itertools import combinations
from typing import Any

import networkx as nx

from rgcore.exports.flat import KINDS, Item, Value, flat, printable
from rgcore.exports.options import Exported, Options
from rgcore.geometry.polygons import label_place
from rgcore.model.base import natural
from rgcore.model.records import Region, RGMap
from rgcore.slam.trajectory import Trajectory

_LOST_GRAPH = ("lines, objects, notes and outlines: the graph holds regions and gateways",)

_SHAPES = {
    "line": ("x1", "y1", "x2", "y2"),
    "gateway": ("x1", "y1", "x2", "y2"),
    "region": ("x", "y"),
    "note": ("x", "y"),
}


def render_graphml(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """A node a region (``x``, ``y``: where its name stands), an edge for each two regions that a gateway joins."""
    graph = nx.MultiGraph(name=printable(options.stem))
    for id in sorted(map.regions, key=natural):
        x, y = _middle(map.regions[id])
        graph.add_node(id, x=x, y=y, **_clean(map.regions[id]))
    for id in sorted(map.gateways, key=natural):
        g = map.gateways[id]
        for a, b in combinations([r for r in dict.fromkeys(g.regions) if r in map.regions], 2):
            graph.add_edge(a, b, key=f"{id}:{a}-{b}", gateway=id, **_clean(g))
    out = io.BytesIO()
    nx.write_graphml(graph, out, encoding="utf-8", prettyprint=True, named_key_ids=True)
    dangling = sum(len(set(g.regions) & map.regions.keys()) < 2 for g in map.gateways.values())
    lost = (f"{dangling} gateways that lead to fewer than two regions",) if dangling else ()
    return Exported(out.getvalue(), lost=(*_LOST_GRAPH, *lost))


def _clean(item: Item) -> dict[str, Value]:
    """Without characters that XML cannot hold and tables break at."""
    return {printable(k): printable(v) if isinstance(v, str) else v for k, v in flat(item).items()}


def render_csv(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """The regions as a table; gateways, lines, objects and notes in tables beside it."""
    tables = {kind: _table(kind, getattr(map, f"{kind}s")) for kind in KINDS}
    beside = {f"-{kind}s.csv": table for kind, table in tables.items() if kind != "region"}
    return Exported(tables["region"], beside, ("outlines of regions: the place of a region is where its name stands",))


def _table(kind: str, items: dict[str, Any]) -> bytes:
    """A row an item, with the columns that any of them has."""
    rows = []
    for id in sorted(items, key=natural):
        rows.append(
            {"id": id, **dict(zip(_SHAPES.get(kind, ()), _place(kind, items[id]), strict=False)), **_clean(items[id])}
        )
    columns = list(dict.fromkeys(["id", *_SHAPES.get(kind, ()), *(name for row in rows for name in row)]))
    out = io.StringIO()
    writer = csv.DictWriter(out, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue().encode()


def _place(kind: str, item: Any) -> tuple[float, ...]:
    if kind == "line":
        return (*item.start, *item.end)
    if kind == "gateway":
        return (*item.posts[0], *item.posts[1])
    if kind == "note":
        return tuple(item.place)
    return _middle(item) if kind == "region" else ()


def _middle(r: Region) -> tuple[float, float]:
    (x, y), _ = label_place(r.boundary, r.holes)
    return round(float(x), 6), round(float(y), 6)
