"""Maps edited elsewhere come back as edits: what was not touched gives none, what was touched gives just that."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest
from export_maps import ROOMS
from lxml import etree

from rgcore.errors import InputError
from rgcore.exports.formats import export
from rgcore.exports.options import Georeference
from rgcore.exports.readers import read_drawing
from rgcore.exports.returned import Returned, edits_from
from rgcore.model import edits as e
from rgcore.model.records import Note, RGMap, replace

BREMEN = Georeference(53.1069, 8.8531, math.radians(30))
NOTE = Note(id="n1", text="printer", place=(7.0, 1.0))
PLAIN = replace(
    ROOMS,
    regions={k: replace(r, name="Lab" if k == "r1" else r.name) for k, r in ROOMS.regions.items()},
    notes={"n1": NOTE},
)
ENDINGS = [".geojson", ".fg.json", ".dxf", ".osm", ".json"]


def back(path: Path, map_: RGMap = PLAIN, where: Georeference | None = None) -> Returned:
    return edits_from(read_drawing(path, where), map_)


def applied(returned: Returned, map_: RGMap = PLAIN) -> RGMap:
    for edit in returned.edits:
        map_ = edit.apply(map_)
    return map_


@pytest.mark.parametrize("where", [None, BREMEN])
@pytest.mark.parametrize("ending", ENDINGS)
def test_what_nobody_touched_gives_no_edits(tmp_path: Path, ending: str, where: Georeference | None) -> None:
    export(tmp_path / f"a{ending}", PLAIN, georeference=where)
    assert back(tmp_path / f"a{ending}", where=where) == Returned((), ())


def edited_json(path: Path, change: Any) -> None:
    tree = json.loads(path.read_text(encoding="utf-8"))
    items = {f["id"]: f for f in tree["features"]}
    change(items, tree["features"])
    path.write_text(json.dumps(tree), encoding="utf-8")


@pytest.mark.parametrize("ending", [".geojson", ".fg.json"])
def test_features_that_were_edited_in_a_gis(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"a{ending}"
    export(path, PLAIN)
    shape = "geometry" if ending == ".geojson" else "place"

    def change(items: dict[str, Any], features: list[Any]) -> None:
        items["r2"]["properties"]["class"] = "TOMA"
        items["r2"]["properties"]["name"] = "Corridor"
        items["g1"][shape]["coordinates"] = [[6.05, 1.4], [6.05, 2.6]]
        items["l11"][shape]["coordinates"][1] = [8.1, 9.0]
        features.remove(items["l12"])
        wall = {"type": "LineString", "coordinates": [[6.5, 5.0], [7.5, 5.0]]}
        features.append({"type": "Feature", shape: wall, "properties": {"kind": "line"}})

    edited_json(path, change)
    found = back(path)
    assert found.refused == ()
    made = applied(found)
    assert (made.regions["r2"].class_, made.regions["r2"].name) == ("TOMA", "Corridor")
    assert made.gateways["g1"].posts == ((6.05, 1.4), (6.05, 2.6))
    assert made.lines["l11"].end == (8.1, 9.0)
    assert "l12" not in made.lines
    (new,) = made.lines.keys() - PLAIN.lines.keys()
    assert made.lines[new].regions == ("r2",)
    assert len(found.edits) == 6


def test_a_drawing_that_was_edited_in_cad(tmp_path: Path) -> None:
    path = tmp_path / "a.dxf"
    export(path, PLAIN)
    doc = ezdxf.readfile(path)
    space = doc.modelspace()
    for line in space.query('LINE[layer=="RG_LINES"]'):
        if ("id=l12") in [v for _, v in line.get_xdata("RGVIZ")]:
            space.delete_entity(line)
    for text in space.query('TEXT[layer=="RG_NAMES"]'):
        if text.dxf.text == "Lab":
            text.dxf.text = "Robot lab"
    space.add_line((6.5, 5.0), (7.5, 5.0), dxfattribs={"layer": "RG_LINES"})
    space.add_lwpolyline([(9, 0), (12, 0), (12, 3), (9, 3)], close=True, dxfattribs={"layer": "RG_REGIONS"})
    doc.saveas(path)
    found = back(path)
    assert sorted(type(x).__name__ for x in found.edits) == ["AddRegion", "DeleteLines", "DrawLine", "RenameRegion"]
    made = applied(found)
    assert made.regions["r1"].name == "Robot lab"
    (new,) = made.regions.keys() - PLAIN.regions.keys()
    assert set(made.regions[new].boundary) == {(9.0, 0.0), (12.0, 0.0), (12.0, 3.0), (9.0, 3.0)}


def test_a_drawing_in_millimetres_is_taken_as_such(tmp_path: Path) -> None:
    path = tmp_path / "a.dxf"
    export(path, PLAIN)
    doc = ezdxf.readfile(path)
    for entity in doc.modelspace():
        entity.scale(1000, 1000, 1000)
    doc.units = ezdxf.units.MM
    doc.saveas(path)
    assert back(path) == Returned((), ())


def test_a_map_that_was_edited_in_josm(tmp_path: Path) -> None:
    path = tmp_path / "a.osm"
    export(path, PLAIN, georeference=BREMEN)
    root = etree.parse(path).getroot()
    for way in list(root.iter("way")):
        tags = {t.get("k"): t for t in way.iter("tag")}
        way.set("id", str(int(way.get("id")) - 5000)) if "rg:id" in tags and tags["rg:id"].get("v") != "r1" else None
        if tags.get("rg:id") is not None and tags["rg:id"].get("v") == "l12":
            way.set("action", "delete")
        if tags.get("rg:id") is not None and tags["rg:id"].get("v") == "g1":
            tags["name"].set("v", "Main door")
    path.write_bytes(etree.tostring(root))
    found = back(path, where=BREMEN)
    assert found == Returned((e.DeleteLines(lines=("l12",)), e.RenameGateway(gateway="g1", name="Main door")), ())


def test_what_the_map_refuses_is_told_and_the_rest_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "a.geojson"
    export(path, PLAIN)

    def change(items: dict[str, Any], features: list[Any]) -> None:
        items["g1"]["geometry"]["coordinates"] = [[6.0, 2.0], [6.0, 2.001]]
        items["r2"]["properties"]["name"] = "Corridor"
        items["l1"]["id"] = "l99"

    edited_json(path, change)
    found = back(path)
    assert any("less than 5 cm apart" in why for why in found.refused)
    assert any(why.startswith("l99 is not in this map") for why in found.refused)
    assert e.RenameRegion(region="r2", name="Corridor") in found.edits


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("a.geojson", b'{"type": "FeatureCollection"}', "is damaged: 'features'"),
        ("a.geojson", b"\xff\xfe nonsense", "is damaged"),
        ("a.dxf", b"0\nSECTION\n2\nHEADER\n", "no DXF that can be read"),
        ("a.osm", b"<osm><node id='-1'/></osm>", "is damaged: 'lon'"),
        ("a.osm", b"<osm", "no OSM XML"),
        ("a.osm", b"<?xml version='1.0' encoding='utf-x'?><osm/>", "no OSM XML that can be read: unknown encoding"),
        ("a.osm", b'<!DOCTYPE x [<!ENTITY a "b">]><osm>&a;</osm>', "no OSM XML"),
        ("a.glb", b"", r"no drawing that can come back; known endings: \.geojson"),
    ],
)
def test_files_that_are_no_drawing_are_told(tmp_path: Path, name: str, content: bytes, told: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=told):
        read_drawing(tmp_path / name)


def test_a_copy_that_kept_its_id_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.geojson"
    export(path, PLAIN)
    edited_json(path, lambda items, features: features.append(items["r1"]))
    with pytest.raises(InputError, match="r1 is there twice; a copy must lose its id"):
        read_drawing(path)


@pytest.mark.parametrize("ending", ENDINGS)
def test_damage_of_any_kind_is_a_line(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"a{ending}"
    export(path, PLAIN)
    whole, rng, told = path.read_bytes(), np.random.default_rng(2), 0
    for n in range(40):
        damaged = bytearray(whole[: int(len(whole) * rng.uniform(0.02, 1))] if n % 2 else whole)
        for at in rng.integers(0, len(damaged), 4):
            damaged[at] = rng.integers(0, 256)
        path.write_bytes(bytes(damaged))
        try:
            read_drawing(path)
        except InputError as error:
            told += "\n" not in str(error)
    assert told > 10
