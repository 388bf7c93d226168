"""What others read: each format is opened by a reader that is not ours and compared with the map."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path
from typing import Any

import ezdxf
import networkx as nx
import numpy as np
import pyogrio.raw
import pytest
import yaml
from export_maps import ROOMS, any_map
from ezdxf.audit import Auditor
from hypothesis import HealthCheck, given, settings
from lxml import etree

from rgcore.errors import RgError
from rgcore.exports.earth import to_earth, to_map
from rgcore.exports.formats import export, exported, render
from rgcore.exports.options import Georeference
from rgcore.model.records import RGMap, replace

BREMEN = Georeference(53.1069, 8.8531, math.radians(30))


def by_gdal(path: Path, layer: str | None = None) -> dict[str, list[Any]]:
    """Columns of a file as GDAL reads them, geometry as WKB beside."""
    meta, _, geometry, fields = pyogrio.raw.read(path, layer=layer)
    return {**dict(zip(meta["fields"].tolist(), [list(f) for f in fields], strict=True)), "wkb": list(geometry)}


def test_gdal_reads_the_features_with_ids_and_classes(tmp_path: Path) -> None:
    export(tmp_path / "a.geojson", ROOMS)
    table = by_gdal(tmp_path / "a.geojson")
    found = dict(zip(table["id"], table["class"], strict=True))
    assert set(found) == {*ROOMS.regions, *ROOMS.gateways, *ROOMS.lines, *ROOMS.objects}
    assert found["r1"] == "TOMA"
    assert found["g1"] == "narrow_passage"


def test_without_a_georeference_the_export_says_that_it_is_in_metres() -> None:
    assert "metres of the map frame" in exported(".geojson", ROOMS).lost[0]
    assert "metres of the map frame" not in " ".join(exported(".geojson", ROOMS, georeference=BREMEN).lost)


def test_with_a_georeference_lengths_stay_and_the_origin_lies_where_it_was_put() -> None:
    tree = json.loads(render(".geojson", ROOMS, georeference=BREMEN))
    hall = next(f for f in tree["features"] if f["id"] == "r2")["geometry"]["coordinates"][0]
    back = to_map(BREMEN, np.array(hall))
    np.testing.assert_allclose(back[:-1], ROOMS.regions["r2"].boundary, atol=1e-3)
    np.testing.assert_allclose(to_earth(BREMEN, np.zeros((1, 2))), [[BREMEN.longitude, BREMEN.latitude]])
    east, north = to_earth(BREMEN, np.array([[10.0, 0.0]]))[0] - [BREMEN.longitude, BREMEN.latitude]
    assert math.atan2(north, east * math.cos(math.radians(BREMEN.latitude))) == pytest.approx(BREMEN.heading, abs=0.01)
    with pytest.raises(RgError, match=r"georeference 91,0: latitude -90\.\.90"):
        render(".geojson", ROOMS, georeference=Georeference(91, 0))


def test_json_fg_keeps_the_metres_and_describes_their_frame() -> None:
    tree = json.loads(render(".fg.json", ROOMS))
    assert tree["coordRefSys"]["value"]["type"] == "EngineeringCRS"
    lab = next(f for f in tree["features"] if f["id"] == "r1")
    assert lab["geometry"] is None
    assert lab["featureType"] == "rg:region"
    assert lab["place"]["coordinates"][0][:-1] == [list(p) for p in ROOMS.regions["r1"].boundary]
    assert len(lab["place"]["coordinates"]) == 2
    earthly = json.loads(render(".fg.json", ROOMS, georeference=BREMEN))["features"]
    assert all(f["geometry"] is not None and f["place"] is not None for f in earthly)


def test_cad_finds_a_sound_drawing_in_metres(tmp_path: Path) -> None:
    export(tmp_path / "a.dxf", ROOMS)
    doc = ezdxf.readfile(tmp_path / "a.dxf")
    auditor: Auditor = doc.audit()
    assert not auditor.has_errors
    assert not auditor.fixes
    assert doc.units == ezdxf.units.M
    space = doc.modelspace()
    assert len(space.query('LINE[layer=="RG_LINES"]')) == len(ROOMS.lines)
    (door,) = space.query('LINE[layer=="RG_GATEWAYS"]')
    tags = dict(v.split("=", 1) for _, v in door.get_xdata("RGVIZ"))
    assert tags == {"kind": "gateway", "id": "g1", "name": "Door", "class": "narrow_passage"}
    np.testing.assert_allclose([door.dxf.start.xyz[:2], door.dxf.end.xyz[:2]], ROOMS.gateways["g1"].posts)
    outlines = {
        dict(v.split("=", 1) for _, v in e.get_xdata("RGVIZ"))["id"]: [p[:2] for p in e.get_points()]
        for e in space.query('LWPOLYLINE[layer=="RG_REGIONS"]')
        if dict(v.split("=", 1) for _, v in e.get_xdata("RGVIZ"))["kind"] == "region"
    }
    np.testing.assert_allclose(outlines["r2"], ROOMS.regions["r2"].boundary)
    assert "DXF" in pyogrio.list_drivers()
    assert len(by_gdal(tmp_path / "a.dxf")["wkb"]) >= len(ROOMS.lines) + 2


def test_the_same_map_gives_the_same_drawing() -> None:
    assert render(".dxf", ROOMS) == render(".dxf", ROOMS)


def test_a_graph_reader_finds_regions_joined_by_the_door() -> None:
    graph = nx.parse_graphml(render(".graphml", ROOMS).decode(), force_multigraph=True)
    assert set(graph) == {"r1", "r2"}
    ((a, b, door),) = graph.edges(data=True)
    assert {a, b} == {"r1", "r2"}
    assert door["gateway"] == "g1"
    assert door["width"] == 1.0
    assert graph.nodes["r2"]["class"] == "CDMA"


def test_tables_hold_a_row_an_item(tmp_path: Path) -> None:
    export(tmp_path / "a.csv", ROOMS)
    for kind, items in (("", ROOMS.regions), ("-gateways", ROOMS.gateways), ("-lines", ROOMS.lines)):
        with (tmp_path / f"a{kind}.csv").open(newline="", encoding="utf-8") as f:
            rows = {row["id"]: row for row in csv.DictReader(f)}
        assert set(rows) == set(items)
    with (tmp_path / "a-gateways.csv").open(newline="", encoding="utf-8") as f:
        (door,) = csv.DictReader(f)
    assert (float(door["x1"]), float(door["y2"]), door["regions"]) == (6.05, 2.5, "r1 r2")


def test_open_rmf_gets_walls_doors_and_lanes_in_metres() -> None:
    tree = yaml.safe_load(render(".building.yaml", ROOMS))
    assert tree["coordinate_system"] == "cartesian_meters"
    level = tree["levels"]["L1"]
    at = np.array([v[:2] for v in level["vertices"]], float)
    walls = sorted(tuple(map(tuple, at[w[:2]].tolist())) for w in level["walls"])
    assert walls == sorted((v.start, v.end) for v in ROOMS.lines.values())
    (door,) = level["doors"]
    np.testing.assert_allclose(at[door[:2]], ROOMS.gateways["g1"].posts)
    assert door[2]["name"] == [1, "Door"]
    lanes = nx.Graph([lane[:2] for lane in level["lanes"]])
    assert nx.is_connected(lanes)
    floors = {f["parameters"]["rg_id"][1]: at[f["vertices"]] for f in level["floors"]}
    np.testing.assert_allclose(at[level["holes"][0]["vertices"]], ROOMS.regions["r1"].holes[0])
    np.testing.assert_allclose(floors["r2"], ROOMS.regions["r2"].boundary)


def test_josm_gets_rooms_walls_and_doors_with_our_ids(tmp_path: Path) -> None:
    data = render(".osm", ROOMS, georeference=BREMEN)
    root = etree.fromstring(data)
    nodes = {n.get("id"): (float(n.get("lon")), float(n.get("lat"))) for n in root.iter("node")}
    assert all(int(e.get("id")) < 0 for e in root)
    assert len({(e.tag, e.get("id")) for e in root}) == len(root)
    tags = {
        {t.get("k"): t.get("v") for t in e.iter("tag")}.get("rg:id"): e
        for e in (*root.iter("way"), *root.iter("relation"))
    }
    hall = tags["r2"]
    places = to_map(BREMEN, np.array([nodes[n.get("ref")] for n in hall.iter("nd")]))
    np.testing.assert_allclose(places[:-1], ROOMS.regions["r2"].boundary, atol=2e-3)
    assert places[0] == pytest.approx(places[-1])
    lab = {t.get("k"): t.get("v") for t in tags["r1"].iter("tag")}
    assert (tags["r1"].tag, lab["type"], lab["indoor"]) == ("relation", "multipolygon", "room")
    assert [m.get("role") for m in tags["r1"].iter("member")] == ["outer", "inner"]
    (tmp_path / "a.osm").write_bytes(data)
    assert {name for name, _ in pyogrio.list_layers(tmp_path / "a.osm")} >= {"lines", "multipolygons"}


ENDINGS = (".geojson", ".fg.json", ".dxf", ".graphml", ".csv", ".osm", ".building.yaml", ".route.geojson")


@settings(max_examples=12, suppress_health_check=[HealthCheck.too_slow])
@given(map_=any_map)
def test_any_map_makes_files_that_can_be_parsed(map_: RGMap) -> None:
    json.loads(render(".geojson", map_))
    json.loads(render(".fg.json", map_))
    ezdxf.read(io.StringIO(render(".dxf", map_).decode()))
    etree.fromstring(render(".graphml", map_))
    etree.fromstring(render(".osm", map_))
    list(csv.reader(io.StringIO(render(".csv", map_).decode())))


@pytest.mark.parametrize("ending", ENDINGS)
def test_an_empty_map_is_an_empty_file_not_an_error(ending: str) -> None:
    assert render(ending, replace(ROOMS, lines={}, regions={}, gateways={}, objects={}))
