"""The drawing: well-formed, metres as units, every item with its id, nothing that people type breaks it."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest
from export_maps import HOSTILE, ROOMS, any_map
from hypothesis import HealthCheck, given, settings

from rgcore.exports.formats import render
from rgcore.exports.palette import as_hex, class_color
from rgcore.model.records import RGMap, replace

SVG = "{http://www.w3.org/2000/svg}"


def drawn(map_: RGMap) -> ElementTree.Element:
    return ElementTree.fromstring(render(".svg", map_))


def item(root: ElementTree.Element, layer: str, id_: str) -> ElementTree.Element:
    return next(e for e in root.iterfind(f"./{SVG}g[@id='{layer}']//*[@data-rg-id]") if e.get("data-rg-id") == id_)


def test_every_item_is_there_with_its_id_and_class() -> None:
    root = drawn(ROOMS)
    layers = {"floors": ROOMS.regions, "lines": ROOMS.lines, "gateways": ROOMS.gateways, "objects": ROOMS.objects}
    for layer, items in layers.items():
        assert {e.get("data-rg-id") for e in root.iterfind(f"./{SVG}g[@id='{layer}']/*")} == set(items)
    assert item(root, "floors", "r1").get("data-rg-class") == "TOMA"
    assert item(root, "floors", "r1").get("fill") == as_hex(class_color("TOMA"))


def test_units_are_metres_with_y_up_in_the_map() -> None:
    root = drawn(ROOMS)
    assert item(root, "lines", "l11").get("d") == "M8.1,0 8.1,-10"
    x, y, w, h = (float(v) for v in root.get("viewBox", "").split())
    assert x < -1
    assert x + w > 8.1
    assert y < -12
    assert y + h > 0
    assert float(root.get("width", 0)) / w == pytest.approx(float(root.get("height", 0)) / h, rel=0.01)
    assert max(float(root.get("width", 0)), float(root.get("height", 0))) > 500


def test_holes_are_cut_out() -> None:
    floor = item(drawn(ROOMS), "floors", "r1")
    assert floor.get("fill-rule") == "evenodd"
    assert floor.get("d", "").count("Z") == 2


def test_texts_are_escaped() -> None:
    names = ["".join(e.itertext()) for e in drawn(ROOMS).iterfind(f"./{SVG}g[@id='names']/*")]
    assert any(name.startswith(HOSTILE.replace("\x07", "")) for name in names)


def test_the_scale_bar_is_as_long_as_it_says() -> None:
    legend = next(e for e in drawn(ROOMS).iterfind(f"./{SVG}g[@id='legend']"))
    bar = legend.find(f"{SVG}path")
    assert bar is not None
    length = re.search(r"h([\d.]+)", bar.get("d", ""))
    assert length is not None
    assert f"{float(length[1]):g} m" in ["".join(t.itertext()) for t in legend.iterfind(f"{SVG}text")]


def test_an_empty_map_is_an_empty_sheet() -> None:
    assert drawn(RGMap()).find(f"{SVG}rect") is not None


def test_labels_stand_inside_of_their_region() -> None:
    hook = ((0.0, 0.0), (10.0, 0.0), (10.0, 8.0), (8.0, 8.0), (8.0, 2.0), (0.0, 2.0))
    region = replace(ROOMS.regions["r2"], boundary=hook)
    label = item(drawn(replace(ROOMS, regions={"r2": region})), "names", "r2")
    at = re.match(r"translate\((\S+) (\S+)\)", label.get("transform", ""))
    assert at is not None
    x, y = float(at[1]), -float(at[2])
    assert (0.5 < x < 10 and 0.5 < y < 1.5) or (8.5 < x < 9.5 and 0.5 < y < 8)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(any_map)
def test_any_map_gives_a_well_formed_drawing(map_: RGMap) -> None:
    root = drawn(map_)
    assert len(root.findall(f"./{SVG}g[@id='lines']/*")) == len(map_.lines)
