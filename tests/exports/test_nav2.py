"""Nav2 reads the grid as the lines have it, and drives the graph as the map has it."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
import yaml
from export_maps import ROOMS
from PIL import Image

from rgcore.errors import RgError
from rgcore.exports.formats import archived, export, exported, render
from rgcore.model.records import RGMap, replace


def served(path: Path) -> tuple[np.ndarray, float, np.ndarray]:
    """The cells as Nav2's map server would publish them (nav2_map_server, map_io): values, resolution, origin."""
    about = yaml.safe_load(path.read_text())
    pixels = np.asarray(Image.open(path.parent / about["image"]).convert("L"), float)
    shade = pixels[::-1] / 255.0
    if about["mode"] == "raw":
        value = np.round(shade * 255)
        return np.where(value <= 100, value, -1), about["resolution"], np.array(about["origin"])
    occupied = shade if about["negate"] else 1.0 - shade
    cells = np.full(shade.shape, -1.0)
    cells[occupied > about["occupied_thresh"]] = 100
    cells[occupied < about["free_thresh"]] = 0
    return cells, about["resolution"], np.array(about["origin"])


def value_at(grid: tuple[np.ndarray, float, np.ndarray], points: np.ndarray) -> np.ndarray:
    cells, resolution, origin = grid
    ix, iy = np.floor((np.asarray(points) - origin[:2]) / resolution).astype(int).T
    return cells[iy, ix]


def distance_to_lines(map_: RGMap, points: np.ndarray) -> np.ndarray:
    best = np.full(len(points), np.inf)
    for line in map_.lines.values():
        a, b = np.array(line.start), np.array(line.end)
        t = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        best = np.minimum(best, np.hypot(*(points - a - t[:, None] * (b - a)).T))
    return best


def test_every_pixel_agrees_with_the_lines(tmp_path: Path) -> None:
    map_ = replace(ROOMS, objects={})
    export(tmp_path / "office.yaml", map_)
    grid = served(tmp_path / "office.yaml")
    for line in map_.lines.values():
        along = np.linspace(0, 1, 200)[:, None]
        points = np.array(line.start) + along * (np.array(line.end) - np.array(line.start))
        assert (value_at(grid, points) == 100).mean() > 0.8  # a slanting line cuts the corners of cells
        near = np.stack([value_at(grid, points + d) for d in ([0, 0], [0.05, 0], [-0.05, 0], [0, 0.05], [0, -0.05])])
        assert (near.max(0) == 100).all()
    iy, ix = np.nonzero(grid[0] == 100)
    centers = grid[2][:2] + (np.stack([ix, iy], 1) + 0.5) * grid[1]
    assert distance_to_lines(map_, centers).max() < 0.05
    assert value_at(grid, [(1.0, 1.0), (7.0, 9.0), (6.05, 2.0), (2.5, 1.5), (-0.5, -0.5)]).tolist() == [0, 0, 0, -1, -1]


def test_objects_stand_in_the_way_and_clutter_does_not(tmp_path: Path) -> None:
    export(tmp_path / "a.yaml", ROOMS)
    assert value_at(served(tmp_path / "a.yaml"), [(1.0, 3.0)]) == 100
    first = next(iter(ROOMS.lines.values()))
    moved = replace(ROOMS, lines={first.id: replace(first, clutter=True)}, objects={})
    export(tmp_path / "b.yaml", moved)
    assert not (served(tmp_path / "b.yaml")[0] == 100).any()


def test_masks_follow_the_classes(tmp_path: Path) -> None:
    rooms = {k: replace(r, class_="CC" if k == "r1" else "Keepout") for k, r in ROOMS.regions.items()}
    export(tmp_path / "a.yaml", replace(ROOMS, regions=rooms))
    keepout, speed = served(tmp_path / "a-keepout.yaml"), served(tmp_path / "a-speed.yaml")
    assert value_at(keepout, [(1.0, 1.0), (7.0, 9.0)]).tolist() == [0, 100]
    assert value_at(speed, [(1.0, 1.0), (7.0, 9.0)]).tolist() == [50, 0]


@pytest.mark.parametrize("resolution", [0.02, 0.1])
def test_the_resolution_can_be_chosen(tmp_path: Path, resolution: float) -> None:
    export(tmp_path / "a.yaml", ROOMS, resolution=resolution)
    _cells, got, origin = served(tmp_path / "a.yaml")
    assert got == resolution
    assert origin[2] == 0
    np.testing.assert_allclose(origin[:2] / resolution, np.round(origin[:2] / resolution), atol=1e-6)
    with pytest.raises(RgError, match="resolution 5 m: must lie between"):
        render(".yaml", ROOMS, resolution=5.0)


def test_an_empty_map_has_no_grid() -> None:
    with pytest.raises(RgError, match="the map is empty"):
        render(".yaml", RGMap())


def test_a_download_packs_what_belongs_together() -> None:
    data, packed = archived(".yaml", "office", exported(".yaml", ROOMS, stem="office"))
    assert packed
    names = zipfile.ZipFile(io.BytesIO(data)).namelist()
    assert sorted(names) == sorted(
        f"office{n}" for n in (".yaml", ".pgm", "-keepout.pgm", "-keepout.yaml", "-speed.pgm", "-speed.yaml")
    )


def graph_of(map_: RGMap) -> nx.DiGraph:
    """As Nav2's loader takes it: nodes are points, edges lines that name the nodes by id."""
    out = nx.DiGraph()
    features = json.loads(render(".route.geojson", map_))["features"]
    ids = [f["properties"]["id"] for f in features]
    assert len(set(ids)) == len(ids)
    for f in features:
        p = f["properties"]
        if f["geometry"]["type"] == "Point":
            out.add_node(p["id"], at=f["geometry"]["coordinates"], **p["metadata"])
        else:
            assert p["startid"] in out
            assert p["endid"] in out
            ends = [out.nodes[p[k]]["at"] for k in ("startid", "endid")]
            assert f["geometry"]["coordinates"] == [ends]
            out.add_edge(p["startid"], p["endid"], cost=p["cost"], operations=p.get("operations"), **p["metadata"])
    return out


def test_the_route_graph_leads_from_room_to_room_through_the_door() -> None:
    graph = graph_of(replace(ROOMS, objects={}))
    home = {d["rg_id"]: n for n, d in graph.nodes(data=True) if d["kind"] == "region"}
    way = nx.shortest_path(graph, home["r1"], home["r2"], weight="cost")
    assert [graph.nodes[n]["rg_id"] for n in way if graph.nodes[n]["kind"] == "crossing"] == ["g1"]
    assert nx.is_strongly_connected(graph)
    back = nx.shortest_path(graph, home["r2"], home["r1"], weight="cost")
    assert back == way[::-1]
    door = [d for *_, d in graph.edges(data=True) if d.get("rg_id") == "g1"]
    assert all(d["class"] == "narrow_passage" and d["width"] == 1.0 and d["speed_limit"] == 50.0 for d in door)
    assert all(d["operations"]["open_door"]["type"] == "OpenDoor" for d in door)


def test_a_room_that_cannot_be_reached_is_told() -> None:
    graph = graph_of(replace(ROOMS, gateways={}))
    assert nx.number_weakly_connected_components(graph) == 2
    lone = replace(ROOMS, gateways={})
    assert "the graph holds the ways only" in exported(".route.geojson", lone).lost[0]
