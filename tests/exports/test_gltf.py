"""The 3D model, read back by two other programs: metres, y up, named nodes that say what they are."""

from __future__ import annotations

import io
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import playwright
import pygltflib
import pytest
import trimesh
from export_maps import HOSTILE, ROOMS, any_map
from hypothesis import HealthCheck, given, settings

from rgcore.exports.formats import render
from rgcore.exports.palette import class_color
from rgcore.model.records import RGMap


def load(map_: RGMap, wall_height: float = 2.5) -> trimesh.Scene:
    scene = trimesh.load(io.BytesIO(render(".glb", map_, wall_height=wall_height)), file_type="glb")
    assert isinstance(scene, trimesh.Scene)
    return scene


def parse(map_: RGMap) -> pygltflib.GLTF2:
    gltf = pygltflib.GLTF2.load_from_bytes(render(".glb", map_))
    assert gltf is not None
    return gltf


def extras(map_: RGMap) -> dict[str, dict]:
    return {node.name: node.extras for node in parse(map_).nodes if node.extras}


def world(scene: trimesh.Scene, name: str) -> trimesh.Trimesh:
    """A node's mesh in the coordinates of glTF."""
    matrix, geometry = scene.graph[name]
    return scene.geometry[geometry].copy().apply_transform(matrix)


def test_metres_and_up_axis() -> None:
    low, high = load(ROOMS).bounds
    np.testing.assert_allclose(low, [-1.0, 0.0, -12.0], atol=1e-5)
    np.testing.assert_allclose(high, [8.1, 2.5, 0.0], atol=1e-5)


@pytest.mark.parametrize("height", [0.5, 4.0])
def test_wall_height_is_settable(height: float) -> None:
    walls = world(load(ROOMS, height), "walls r2")
    assert walls.bounds[:, 1].tolist() == pytest.approx([0, height])


def test_floor_leaves_its_hole_out_and_faces_up() -> None:
    floor = world(load(ROOMS), "region r1")
    assert floor.area == pytest.approx(6 * 4 - 1)
    assert (floor.face_normals[:, 1] > 0.99).all()


def test_walls_stand_by_region_and_face_the_free_side() -> None:
    scene, about = load(ROOMS), extras(ROOMS)
    assert about["walls r1"]["lines"] == ["l1", "l2"]
    assert about["walls r2"]["lines"] == ["l10", "l11"]
    assert about["walls without region"]["lines"] == ["l12"]
    normals = world(scene, "walls r1").face_normals
    np.testing.assert_allclose(normals[:2], [[0, 0, -1]] * 2, atol=1e-9)  # l1 runs along x: free is y, which is -z here
    np.testing.assert_allclose(normals[2:], [[-1, 0, 0]] * 2, atol=1e-9)


def test_the_door_lies_on_the_floor_between_its_posts() -> None:
    low, high = world(load(ROOMS), "gateway g1").bounds
    np.testing.assert_allclose([low[2], high[2]], [-2.5, -1.5], atol=1e-5)
    assert low[0] < 6.05 < high[0]
    assert 0 < high[1] < 0.05


def test_the_object_is_a_box_of_its_size_where_it_stands() -> None:
    box = world(load(ROOMS), "object o1")
    assert box.is_watertight
    assert box.volume == pytest.approx(2.0 * 0.5 * 1.2, rel=1e-5)
    np.testing.assert_allclose(box.centroid, [1.0, 0.6, -3.0], atol=1e-5)
    np.testing.assert_allclose(sorted(box.bounding_box_oriented.primitive.extents), [0.5, 1.2, 2.0], atol=1e-4)
    long = max(box.edges_unique, key=lambda e: np.ptp(box.vertices[e], axis=0) @ [1, 0, 1])
    x, _, z = np.diff(box.vertices[long], axis=0)[0]
    assert np.arctan2(-z, x) % np.pi == pytest.approx(np.pi / 6, abs=1e-4) or np.hypot(x, z) > 2


def test_extras_name_every_item() -> None:
    about = extras(ROOMS)
    lab = about["region r1"]
    assert (lab["id"], lab["name"], lab["class"], lab["gateways"]) == ("r1", HOSTILE, "TOMA", ["g1"])
    assert lab["class_scores"] == {"CC": 0.25, "TOMA": 0.75}
    assert about["gateway g1"]["class"] == "narrow_passage"
    assert about["gateway g1"]["regions"] == ["r1", "r2"]
    assert (about["object o1"]["id"], about["object o1"]["class"]) == ("o1", "cabinet")
    scene = load(ROOMS)
    assert scene.metadata["format"] == "rgmap"
    edge = scene.graph.transforms.edge_data[(scene.graph.transforms.parents["region r1"], "region r1")]
    assert edge["metadata"]["name"] == HOSTILE


def test_floors_have_their_class_colour_and_show_from_both_sides() -> None:
    gltf = parse(ROOMS)
    floor = next(n for n in gltf.nodes if n.name == "region r2")
    material = gltf.materials[gltf.meshes[floor.mesh].primitives[0].material]
    linear = np.array(material.pbrMetallicRoughness.baseColorFactor[:3])
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(255 * srgb, class_color("CDMA"), atol=8)
    assert material.doubleSided


def test_a_child_of_the_root_keeps_the_coordinates_of_the_map() -> None:
    scene = load(ROOMS)
    floor = scene.geometry[scene.graph["region r2"][1]]
    np.testing.assert_allclose(floor.bounds, [[6.1, 0, 0], [8.1, 10, 0]], atol=1e-5)


def test_an_empty_map_is_a_valid_file() -> None:
    assert [n.name for n in parse(RGMap()).nodes] == ["map", "floors", "lines", "walls", "gateways", "objects"]


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(any_map)
def test_any_map_has_a_node_for_each_item(map_: RGMap) -> None:
    names = {n.name for n in parse(map_).nodes}
    assert {f"region {id_}" for id_ in map_.regions} <= names
    assert {f"gateway {id_}" for id_ in map_.gateways} <= names
    assert {f"object {id_}" for id_ in map_.objects} <= names


def judged(path: Path) -> dict[str, Any]:
    """What the official validator says of a file."""
    package = Path(sys.prefix) / "gltf-validator/node_modules/gltf-validator"
    assert package.exists(), "run `sh tests/exports/validator.sh .venv` first; `make test` does"
    node = shutil.which("node") or str(Path(playwright.__file__).parent / "driver/node")
    command = [node, str(Path(__file__).parent / "validate.js"), str(package), str(path)]
    report: dict[str, Any] = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    return report


@pytest.mark.parametrize("map_", [ROOMS, RGMap()], ids=["rooms", "empty"])
def test_the_official_validator_finds_nothing(tmp_path: Path, map_: RGMap) -> None:
    path = tmp_path / "map.glb"
    path.write_bytes(render(".glb", map_))
    issues = judged(path)["issues"]
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]


def test_the_validator_would_find_something(tmp_path: Path) -> None:
    data = bytearray(render(".glb", ROOMS))
    at = data.index(b'"componentType":5126')
    data[at : at + 20] = b'"componentType":9999'
    (tmp_path / "map.glb").write_bytes(bytes(data))
    assert judged(tmp_path / "map.glb")["issues"]["numErrors"] > 0


def test_lines_are_there_as_lines_too() -> None:
    scene = load(ROOMS)
    drawn = np.concatenate([g.vertices[:, :2] for n, g in scene.geometry.items() if n.startswith("lines")])
    ends = np.array([p for v in ROOMS.lines.values() for p in (v.start, v.end)])
    assert {tuple(p) for p in np.round(drawn, 5).tolist()} == {tuple(p) for p in np.round(ends, 5).tolist()}
