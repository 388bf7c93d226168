"""Formats whose readers are others' programs: read by them where they install, else by the rules that they read by."""

from __future__ import annotations

import json
import re
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import osmium
import pyogrio
import pyogrio.raw
import pytest
import shapely
import yaml
from export_maps import ROOMS, any_map
from hypothesis import HealthCheck, given, settings

from rgcore.exports.earth import to_map
from rgcore.exports.formats import export, exported, render
from rgcore.exports.options import Georeference
from rgcore.model.records import RGMap, replace

BREMEN = Georeference(53.1069, 8.8531, 0.5)
SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large]


# ---- JSON-FG: GDAL's own driver ----------------------------------------------------------------------


def by_gdal(path: Path, layer: str, **options: Any) -> dict[str, shapely.Geometry]:
    meta, _, geometry, fields = pyogrio.raw.read(path, layer=layer, **options)
    ids = fields[meta["fields"].tolist().index("id")]
    return dict(zip(ids, shapely.from_wkb(geometry), strict=True))


def test_gdal_takes_it_for_json_fg_in_metres_of_a_local_frame(tmp_path: Path) -> None:
    export(tmp_path / "a.fg.json", ROOMS)
    about = pyogrio.read_info(tmp_path / "a.fg.json", layer="rg:region")
    assert about["driver"] == "JSONFG"
    assert "LOCAL_CS" in about["crs"]
    assert "metre" in about["crs"]
    assert dict(pyogrio.list_layers(tmp_path / "a.fg.json")) == {
        "rg:gateway": "LineString",
        "rg:line": "LineString",
        "rg:object": "Polygon",
        "rg:region": "Polygon",
    }
    regions = by_gdal(tmp_path / "a.fg.json", "rg:region")
    assert set(regions) == set(ROOMS.regions)
    for id, r in ROOMS.regions.items():
        assert regions[id].equals(shapely.Polygon(r.boundary, r.holes))
    lines = by_gdal(tmp_path / "a.fg.json", "rg:line")
    assert {id: tuple(v.coords) for id, v in lines.items()} == {k: (v.start, v.end) for k, v in ROOMS.lines.items()}


def test_gdal_finds_both_the_metres_and_the_degrees(tmp_path: Path) -> None:
    export(tmp_path / "a.fg.json", ROOMS, georeference=BREMEN)
    place = by_gdal(tmp_path / "a.fg.json", "rg:line", GEOMETRY_ELEMENT="PLACE")
    earth = by_gdal(tmp_path / "a.fg.json", "rg:line", GEOMETRY_ELEMENT="GEOMETRY")
    for id, v in ROOMS.lines.items():
        assert tuple(place[id].coords) == (v.start, v.end)
        np.testing.assert_allclose(to_map(BREMEN, np.array(earth[id].coords)), [v.start, v.end], atol=1e-3)


def test_json_fg_has_the_members_that_its_schema_asks_for() -> None:
    """OGC 21-045r1: of a document conformsTo, of a feature type, time, place, geometry, properties; an own frame has a
    type that is not Reference."""
    for options in ({}, {"georeference": BREMEN}):
        tree = json.loads(render(".fg.json", ROOMS, **options))
        assert tree["type"] == "FeatureCollection"
        assert "http://www.opengis.net/spec/json-fg-1/1.0/conf/core" in tree["conformsTo"]
        assert tree["coordRefSys"]["type"] == "PROJJSON"
        for f in tree["features"]:
            assert {"type", "time", "place", "geometry", "properties"} <= set(f)
            assert f["geometry"] != f["place"]  # place is for what WGS 84 cannot say


# ---- OSM: libosmium ------------------------------------------------------------------------------------


class Found(osmium.SimpleHandler):
    """What libosmium makes of a file, areas put together from their rings."""

    def __init__(self) -> None:
        super().__init__()
        self.kinds: Counter[str] = Counter()
        self.areas: dict[str, tuple[int, int]] = {}
        self.ends: dict[str, list[tuple[float, float]]] = {}

    def node(self, _: Any) -> None:
        self.kinds["node"] += 1

    def way(self, w: Any) -> None:
        self.kinds["way"] += 1
        if w.tags.get("indoor") == "wall":
            self.ends[w.tags["rg:id"]] = [(n.lon, n.lat) for n in w.nodes]

    def area(self, a: Any) -> None:
        if "rg:id" in a.tags:
            outer = list(a.outer_rings())
            self.areas[a.tags["rg:id"]] = len(outer), sum(len(list(a.inner_rings(ring))) for ring in outer)


def test_libosmium_puts_rooms_with_their_holes_and_walls_together(tmp_path: Path) -> None:
    data = render(".osm", ROOMS, georeference=BREMEN)
    uploaded = re.sub(rb'(id|ref)="-(\d+)"', rb'\1="\2"', data)  # it finds no places of nodes that have no number yet
    (tmp_path / "a.osm").write_bytes(uploaded)
    found = Found()
    found.apply_file(str(tmp_path / "a.osm"), locations=True)
    assert found.areas == {"r1": (1, 1), "r2": (1, 0), **dict.fromkeys(ROOMS.objects, (1, 0))}
    assert set(found.ends) == set(ROOMS.lines)
    for id, degrees in found.ends.items():
        v = ROOMS.lines[id]
        np.testing.assert_allclose(to_map(BREMEN, np.array(degrees)), [v.start, v.end], atol=0.02)  # 7 digits


def test_gdal_reads_the_same_areas(tmp_path: Path) -> None:
    export(tmp_path / "a.osm", ROOMS, georeference=BREMEN)
    meta, _, geometry, fields = pyogrio.raw.read(tmp_path / "a.osm", layer="multipolygons", USE_CUSTOM_INDEXING="NO")
    assert len(geometry) == len(ROOMS.regions) + len(ROOMS.objects)
    tags = fields[meta["fields"].tolist().index("other_tags")]
    assert all('"rg:id"=>' in t for t in tags)


# ---- Nav2's route server: the rules of its GeoJSON loader ---------------------------------------------------


def primitive(value: Any) -> bool:
    return isinstance(value, bool | int | float | str)


def metadata(table: dict[str, Any]) -> None:
    """Objects in objects, lists of plain values, plain values: the loader throws at anything else, such as null."""
    for value in table.values():
        if isinstance(value, dict):
            metadata(value)
        elif isinstance(value, list):
            assert all(primitive(v) for v in value)
        else:
            assert primitive(value)


def as_nav2(data: bytes) -> nx.DiGraph:
    graph, edges = nx.DiGraph(), []
    for f in json.loads(data)["features"]:
        p, kind = f["properties"], f["geometry"]["type"]
        assert isinstance(p["id"], int)
        assert 0 < p["id"] < 2**32
        metadata(p.get("metadata", {}))
        for operation in p.get("operations", {}).values():
            assert isinstance(operation["type"], str)
            assert operation["trigger"] in ("NODE", "ON_ENTER", "ON_EXIT")
            metadata(operation.get("metadata", {}))
        if kind == "Point":
            assert all(isinstance(c, float) for c in f["geometry"]["coordinates"])
            assert isinstance(p["frame"], str)
            graph.add_node(p["id"])
        else:
            assert kind in ("LineString", "MultiLineString")
            edges.append(p)
    for p in edges:  # the loader adds nodes first
        assert p["startid"] in graph
        assert p["endid"] in graph
        assert isinstance(p["cost"], float)
        assert isinstance(p["overridable"], bool)
        if "speed_limit" in p.get("metadata", {}):
            assert isinstance(p["metadata"]["speed_limit"], float)  # AdjustSpeedLimit takes floats alone
        graph.add_edge(p["startid"], p["endid"])
    return graph


def test_the_route_graph_keeps_to_the_rules_of_the_loader() -> None:
    graph = as_nav2(render(".route.geojson", ROOMS))
    assert graph.number_of_edges()
    assert all(graph.has_edge(b, a) for a, b in graph.edges)


@settings(max_examples=25, deadline=None, suppress_health_check=SLOW)
@given(any_map)
def test_so_does_the_graph_of_any_map_and_one_without_ways_says_that_it_is_refused(map_: RGMap) -> None:
    out = exported(".route.geojson", map_)
    graph = as_nav2(out.data)
    assert bool(graph.number_of_edges()) != any("refuses a graph without" in what for what in out.lost)


# ---- Open-RMF: the rules of rmf_building_map_tools, which installs with ROS alone ------------------------------

TYPES: dict[int, type | tuple[type, ...]] = {1: str, 2: int, 3: (int, float), 4: bool}


def parameters(table: dict[str, Any]) -> dict[str, Any]:
    for kind, value in table.values():
        assert isinstance(value, TYPES[kind])
    return {name: value for name, (_, value) in table.items()}


def as_rmf(data: bytes) -> dict[str, Any]:
    """Its level: vertices, and all that names them by number."""
    tree = yaml.safe_load(data)
    assert tree["coordinate_system"] == "cartesian_meters"  # y is not turned over then
    assert isinstance(tree["name"], str)
    assert tree["lifts"] == {}
    (level,) = tree["levels"].values()
    vertices = [(float(x), float(y)) for x, y, z, name in level["vertices"] if z == 0 and isinstance(name, str)]
    assert len(vertices) == len(level["vertices"])
    named = [v[3] for v in level["vertices"] if v[3]]
    assert len(set(named)) == len(named), "the fleet adapter refuses two waypoints of one name"
    edges = {}
    for kind in ("walls", "doors", "lanes", "measurements"):
        edges[kind] = [(vertices[a], vertices[b], parameters(p)) for a, b, p in level[kind]]
    for door in edges["doors"]:
        assert door[2]["type"] in ("hinged", "sliding", "double_hinged", "double_sliding")
        assert door[2]["motion_axis"] in ("start", "end")
    assert len({d[2]["name"] for d in edges["doors"]}) == len(edges["doors"])
    assert all(lane[2]["graph_idx"] == 0 for lane in edges["lanes"])
    for kind in ("floors", "holes"):
        edges[kind] = [([vertices[i] for i in f["vertices"]], parameters(f["parameters"])) for f in level[kind]]
    return edges


def crosses(a: Any, b: Any) -> bool:
    return bool(shapely.LineString(a).intersects(shapely.LineString(b)))


def test_a_lane_leads_through_every_door_as_rmf_finds_it() -> None:
    """rmf_building_map_tools tells a lane to open the doors that it crosses."""
    level = as_rmf(render(".building.yaml", replace(ROOMS, objects={})))
    assert level["doors"]
    for a, b, door in level["doors"]:
        assert [lane for lane in level["lanes"] if crosses(lane[:2], (a, b))], door["name"]
    assert all(lane[2]["bidirectional"] for lane in level["lanes"])


def test_rooms_of_one_name_are_told_apart() -> None:
    same = {id: replace(r, name="Lab") for id, r in ROOMS.regions.items()}
    data = render(".building.yaml", replace(ROOMS, regions=same))
    as_rmf(data)
    names = {v[3] for v in yaml.safe_load(data)["levels"]["L1"]["vertices"]} - {""}
    assert names in ({"Lab", "Lab (r1)"}, {"Lab", "Lab (r2)"})


@settings(max_examples=25, deadline=None, suppress_health_check=SLOW)
@given(any_map)
def test_any_map_is_a_building_that_rmf_reads(map_: RGMap) -> None:
    level = as_rmf(render(".building.yaml", map_))
    assert {p["rg_id"] for _, p in level["floors"]} == set(map_.regions)
    assert len(level["holes"]) == sum(len(r.holes) for r in map_.regions.values())
    assert {w[2]["rg_id"] for w in level["walls"]} == {k for k, v in map_.lines.items() if not v.clutter}


# ---- ids survive in every format -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "ending", [".json", ".glb", ".svg", ".dxf", ".geojson", ".fg.json", ".osm", ".building.yaml", ".csv", ".graphml"]
)
def test_the_ids_of_regions_and_gateways_are_in_the_file(ending: str) -> None:
    out = exported(ending, ROOMS)
    text = b"".join([out.data, *out.beside.values()]).decode("utf-8", "replace")
    kinds: list[dict[str, Any]] = [ROOMS.regions]
    if ending != ".building.yaml":  # there a door has a name
        kinds.append(ROOMS.gateways)
    if ending != ".graphml":
        kinds.append(ROOMS.lines)
    if ending not in (".graphml", ".building.yaml"):
        kinds.append(ROOMS.objects)
    for id in (id for items in kinds for id in items):
        before, _, after = text.partition(id)
        assert after, id
        assert not before[-1].isalnum()


def test_a_zigzag_of_ways_stays_within_its_region() -> None:
    """Bends of the ways: every piece of the graph lies on free floor."""
    tree = json.loads(render(".route.geojson", replace(ROOMS, objects={})))
    free = shapely.union_all([shapely.Polygon(r.boundary, r.holes).buffer(0.15) for r in ROOMS.regions.values()])
    for f in tree["features"]:
        if f["geometry"]["type"] == "MultiLineString":
            for a, b in pairwise(f["geometry"]["coordinates"][0]):
                assert free.covers(shapely.LineString([a, b]))
