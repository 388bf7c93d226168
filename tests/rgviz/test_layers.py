"""Drawing the map: the right geometry, and nothing anew that did not change."""

from __future__ import annotations

import numpy as np
import pytest
import viser
from office_map import big_office, office_map

from rgcore.model.draft import object_from_lines
from rgcore.model.edits import ClassifyRegion, DeleteGateway, DeleteLines, MoveLine, RenameRegion
from rgcore.model.records import Line, RGMap, replace
from rgcore.model.rows import Rows
from rgviz import highlight, theme
from rgviz.artist import Artist
from rgviz.drawings import Dots, Drawing, Faces, Strokes, bounds, box_corners
from rgviz.labels import labels
from rgviz.layers import LAYERS, extent, growing_path
from rgviz.picking import Item
from rgviz.scene import Canvas, Scene

MAP = office_map(4, 1, 2)


def artist(map_: RGMap = MAP) -> Artist:
    points = np.random.default_rng(0).uniform(0, 9, (50, 2)).astype(np.float32)
    return Artist(points, np.array([[0.0, 6], [5, 6], [9, 6]]), theme.region_colors(map_))


def drawn(name: str, map_: RGMap = MAP) -> dict[str, Drawing]:
    return next(layer for layer in LAYERS if layer.name == name).draw(map_, artist(map_))


def test_every_layer_draws_every_map() -> None:
    lone = RGMap(lines={"l1": replace(MAP.lines["l1"], regions=())})
    for map_, who in ((MAP, artist()), (RGMap(), Artist()), (lone, Artist())):
        for layer in LAYERS:
            for drawing in layer.draw(map_, who).values():
                for f in ("ends", "vertices", "points"):
                    values = getattr(drawing, f, np.zeros((1, 3)))
                    assert values.shape[-1] == 3
                    assert np.isfinite(values).all()


def test_floors_cover_the_regions_in_their_class_colours() -> None:
    floors = drawn("/floors")
    total = 0.0
    for f in floors.values():
        assert isinstance(f, Faces)
        a, b, c = (f.vertices[f.faces[:, n], :2].astype(float) for n in range(3))
        total += np.abs(np.cross(np.c_[b - a, 0 * a[:, :1]], np.c_[c - a, 0 * a[:, :1]])[:, 2]).sum() / 2
    assert total == pytest.approx(3 * 12 + 16 * 2 + 8 * 3.8 * 5, rel=1e-5)
    colors = {theme.class_color(r.class_) for r in MAP.regions.values()}
    assert {f.color for f in floors.values()} == {theme.over_white(c) for c in colors}  # type: ignore[union-attr]


def test_lines_have_the_colour_of_their_region_and_neighbours_differ() -> None:
    lines = drawn("/lines")["lines"]
    assert isinstance(lines, Strokes)
    assert isinstance(lines.color, np.ndarray)
    colors = theme.region_colors(MAP)
    for n, line in enumerate(MAP.lines.values()):
        assert tuple(lines.color[n]) == colors[line.regions[0]]
        assert np.allclose(lines.ends[n, :, :2], (line.start, line.end))
    for gateway in MAP.gateways.values():
        a, b = gateway.regions
        assert colors[a] != colors[b]
    renamed = RenameRegion(region="r4", name="lab").apply(MAP)
    assert theme.region_colors(renamed, colors) == colors


def test_gateways_show_posts_crossings_and_entries() -> None:
    g = drawn("/gateways")
    n = len(MAP.gateways)
    posts, crossing, entries = g["posts"], g["crossing"], g["entries"]
    assert isinstance(posts, Dots)
    assert isinstance(crossing, Dots)
    assert isinstance(entries, Dots)
    assert (len(posts.points), len(crossing.points), len(entries.points)) == (2 * n, n, 2 * n)
    assert len({d.shape for d in (posts, crossing, entries)}) == 3
    assert len({d.color for d in (posts, crossing, entries)}) == 3


def test_walls_leave_furniture_low() -> None:
    walls, bodies = drawn("/walls")["walls"], drawn("/objects")["bodies"]
    assert isinstance(walls, Faces)
    assert isinstance(bodies, Faces)
    explained = {i for o in MAP.objects.values() for i in o.lines}
    assert len(walls.faces) == 2 * (len(MAP.lines) - len(explained))
    assert walls.vertices[:, 2].max() == pytest.approx(theme.WALL_HEIGHT)
    assert bodies.vertices[:, 2].max() == pytest.approx(1.0)
    assert len(bodies.vertices) == 8 * len(MAP.objects)


def test_turned_boxes_keep_their_size() -> None:
    box = replace(MAP.regions["r4"].box, yaw=0.7)
    c = box_corners(box)
    sides = np.linalg.norm(np.roll(c, -1, 0) - c, axis=1)
    assert np.allclose(sides, [*box.size, *box.size])
    assert np.allclose(c.mean(0), box.center)
    along = c[1] - c[0]
    assert np.arctan2(along[1], along[0]) == pytest.approx(0.7)


def test_extent_is_that_of_the_regions_not_of_a_stray_line() -> None:
    stray = replace(MAP.lines["l1"], id="l999", start=(90.0, 90.0), end=(91.0, 90.0), regions=())
    far = replace(MAP, lines={**MAP.lines, "l999": stray})
    assert np.allclose(extent(far, artist()), extent(MAP, artist()))
    assert np.allclose(extent(MAP, artist()), [[-3, 0], [16, 12]], atol=0.01)
    assert np.allclose(bounds(np.array([[np.nan, 1.0]])), [[-5, -5], [5, 5]])
    assert (np.ptp(bounds(np.array([[2.0, 2.0]])), axis=0) >= 1).all()
    way = growing_path(np.array([[0.0, 0], [1, 0], [1, 1]]))["path"]
    assert isinstance(way, Strokes)
    assert len(way.ends) == 2


class Node:
    """A node that tells when it is changed or removed."""

    def __init__(self, name: str, calls: list[str]) -> None:
        self.__dict__.update(name=name, calls=calls)

    def __setattr__(self, _: str, value: object) -> None:
        self.calls.append(self.name)

    def remove(self) -> None:
        self.calls.append(f"-{self.name}")


class Recorder:
    """A scene that remembers what was put into it."""

    def __init__(self) -> None:
        self.calls: list[str] = []

    def _add(self, name: str, *_: object, **__: object) -> Node:
        self.calls.append(name)
        return Node(name, self.calls)

    add_line_segments = add_point_cloud = add_mesh_simple = add_glb = _add


def test_only_what_changed_is_drawn_again() -> None:
    recorder, who = Recorder(), artist()
    canvases = {layer.name: Canvas(recorder, layer.name) for layer in LAYERS}  # type: ignore[arg-type]

    def touched(map_: RGMap) -> set[str]:
        recorder.calls.clear()
        for layer in LAYERS:
            canvases[layer.name].draw(layer.draw(map_, who))
        return set(recorder.calls)

    touched(MAP)
    assert touched(MAP) == set()
    assert touched(RenameRegion(region="r4", name="lab").apply(MAP)) == set()
    relabelled = ClassifyRegion(region="r4", class_="CC").apply(MAP)
    assert touched(relabelled) == {"/floors/cTOMA", "/floors/cCC", "/outlines/cTOMA", "/outlines/cCC"}
    touched(MAP)
    seeded = object_from_lines(MAP, ["l29", "l30"], 1.0).apply(MAP)
    assert {c.split("/")[1] for c in touched(seeded)} == {"objects", "walls"}
    touched(MAP)
    gone = touched(replace(MAP, gateways={}))
    assert "-/gateways/posts" in gone
    assert {c.strip("-").split("/")[1] for c in gone} == {"gateways"}


def test_a_layer_that_nobody_looks_at_costs_nothing() -> None:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        scene = Scene(server)
        shown = set(scene.show(MAP))
        assert "/lines" in shown
        assert "/walls" not in shown
        fewer = DeleteLines(lines=("l3",)).apply(MAP)
        assert scene.show(fewer) == ["/lines"]
        scene.want("/walls")
        assert len(scene.layers["/walls"].drawn["walls"].faces) == len(drawn("/walls", fewer)["walls"].faces)  # type: ignore[union-attr]
        assert scene.show(MAP) == ["/lines", "/walls"]
    finally:
        server.stop()


def test_rows_are_read_once_for_each_record() -> None:
    read: list[str] = []
    rows = Rows[Line](lambda v: (read.append(v.id), (v.start, v.end))[1], (2, 2))
    first = rows(MAP.lines)
    assert len(read) == len(MAP.lines)
    assert rows(MAP.lines) is first
    read.clear()
    moved = MoveLine(line="l5", start=(0.0, 0.0), end=(1.0, 0.0)).apply(DeleteLines(lines=("l3",)).apply(MAP))
    again = rows(moved.lines)
    assert read == ["l5"]
    assert np.array_equal(again, [(v.start, v.end) for v in moved.lines.values()])
    assert np.array_equal(rows(MAP.lines), first)
    assert rows({}).shape == (0, 2, 2)


def test_floors_are_triangulated_once_per_outline() -> None:
    who = artist()
    layer = next(layer for layer in LAYERS if layer.name == "/floors")
    layer.draw(MAP, who)
    kept = {i: who.floor(r) for i, r in MAP.regions.items()}
    relabelled = ClassifyRegion(region="r4", class_="CC").apply(MAP)
    assert all(who.floor(r) is kept[i] for i, r in relabelled.regions.items())


def test_highlight_marks_exactly_what_is_selected() -> None:
    def strokes(*items: Item) -> int:
        s = highlight.marks(MAP, items, artist())["strokes"]
        assert isinstance(s, Strokes)
        return len(s.ends)

    assert strokes(Item("line", "l3")) == 1
    assert strokes(Item("line", "l3"), Item("line", "l4")) == 2
    assert strokes(Item("region", "r4")) == 4
    assert strokes(Item("gateway", "g2")) == 1
    assert strokes(Item("object", "o1")) == 12
    assert highlight.marks(MAP, (), artist()) == {}


def test_labels_stand_inside_and_weigh_by_size() -> None:
    found = {v["id"]: v for v in labels(MAP, artist())}
    assert set(found) == set(MAP.regions) | set(MAP.gateways) | set(MAP.objects)
    for i, r in MAP.regions.items():
        (x0, y0), (x1, y1) = np.min(r.boundary, 0), np.max(r.boundary, 0)
        assert x0 < found[i]["x"] < x1
        assert y0 < found[i]["y"] < y1
    assert found["r1"]["weight"] > found["r4"]["weight"] > found["g1"]["weight"]
    long = RenameRegion(region="r4", name="x" * 70).apply(MAP)
    assert len({v["id"]: v for v in labels(long, artist())}["r4"]["text"]) == 40


def test_few_nodes_for_a_large_map() -> None:
    m = big_office(5000)
    who = Artist(colors=theme.region_colors(m))
    assert sum(len(layer.draw(m, who)) for layer in LAYERS) < 40


def test_selection_lets_go_with_the_gateway() -> None:
    from rgviz import selecting

    gone = DeleteGateway(gateway="g2").apply(MAP)
    items = (Item("gateway", "g2"), Item("gateway", "g3"))
    assert selecting.still_there(gone, items) == (Item("gateway", "g3"),)
