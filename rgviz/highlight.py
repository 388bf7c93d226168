"""What a selection looks like: a few strokes over the map, drawn in the browser that selected."""

from __future__ import annotations

import numpy as np

from rgcore.model.records import MapObject, RGMap
from rgviz import theme
from rgviz.artist import Artist
from rgviz.drawings import BOX_EDGES, Drawings, Faces, Strokes, at, node_name, object_corners
from rgviz.picking import Item

AROUND = 0.35
"""m: how far from its place a selected note is marked"""


def marks(map_: RGMap, items: tuple[Item, ...], artist: Artist) -> Drawings:
    """Outlines and lines of the selected items; selected floors are twice as strong."""
    strokes: list[np.ndarray] = []
    floors: dict[str, list[np.ndarray]] = {}
    for i in items:
        if i.kind == "region":
            r = map_.regions[i.id]
            strokes.append(_raised(artist.rings(r)))
            floors.setdefault(r.class_, []).append(artist.floor(r).reshape(-1, 2))
        elif i.kind == "gateway":
            strokes.append(_raised(np.array([map_.gateways[i.id].posts])))
        elif i.kind == "line":
            strokes.append(_raised(np.array([[map_.lines[i.id].start, map_.lines[i.id].end]])))
        elif i.kind == "note":
            x, y = map_.notes[i.id].place
            corners = np.array([(x + dx * AROUND, y + dy * AROUND) for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1))])
            strokes.append(_raised(np.stack([corners, np.roll(corners, -1, 0)], 1)))
        else:
            strokes.append(object_corners(map_.objects[i.id])[BOX_EDGES])
    out: Drawings = {}
    if strokes:
        out["strokes"] = Strokes(np.concatenate(strokes), theme.SELECTION, theme.SELECTION_WIDTH)
    for class_, parts in floors.items():
        flat = at(np.concatenate(parts), theme.Z_FLOOR + 0.005)
        faces = np.arange(len(flat)).reshape(-1, 3)
        out[node_name(class_)] = Faces(flat, faces, theme.over_white(theme.class_color(class_), theme.CHOSEN_OPACITY))
    return out


def box(o: MapObject) -> Drawings:
    """The edges of a box that is being moved."""
    edges = object_corners(o)[BOX_EDGES].astype(np.float32)
    return {"edges": Strokes(edges, theme.SELECTION, theme.SELECTION_WIDTH)}


def _raised(strokes: np.ndarray) -> np.ndarray:
    return at(strokes, theme.Z_SELECTION)
