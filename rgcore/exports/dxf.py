"""The map as DXF for CAD: metres, a layer a kind, names as text, the id of each item in its extended data (XDATA)."""

from __future__ import annotations

import io
from typing import Any

import ezdxf
from ezdxf import colors, units

from rgcore.exports.cells import footprint
from rgcore.exports.flat import printable
from rgcore.exports.options import Exported, Options
from rgcore.exports.palette import GATEWAY, OBJECT, class_color
from rgcore.geometry.polygons import label_place
from rgcore.model.base import natural
from rgcore.model.records import RGMap
from rgcore.slam.trajectory import Trajectory

APP = "RGVIZ"
"""Name that the extended data stand under."""

LAYERS = {"line": "RG_LINES", "region": "RG_REGIONS", "gateway": "RG_GATEWAYS", "object": "RG_OBJECTS"}
NAMES, CLUTTER, NOTES = "RG_NAMES", "RG_CLUTTER", "RG_NOTES"

_LONGEST = 60
"""Characters of a string of XDATA: it holds 255 bytes, and a character takes up to four."""

_LOST = (
    "class scores, confidence, accuracy, main axes and who made what: the id, class and name of an item are kept",
    "crossing-points and gateway-points",
)


def render(map: RGMap, trajectory: Trajectory | None, options: Options) -> Exported:
    """The drawing as text DXF (R2010)."""
    ezdxf.options.write_fixed_meta_data_for_testing = True  # the same map, the same bytes: no times, no random ids
    doc = ezdxf.new("R2010", units=units.M)
    doc.appids.add(APP)
    for name in (*LAYERS.values(), NAMES, CLUTTER, NOTES):
        doc.layers.add(name)
    space = doc.modelspace()
    for r in _ordered(map.regions):
        layer = {"layer": LAYERS["region"], "true_color": _color(class_color(r.class_))}
        outline = space.add_lwpolyline(r.boundary, close=True, dxfattribs=layer)
        _tell(outline, kind="region", id=r.id, name=r.name, **{"class": r.class_})
        for n, hole in enumerate(r.holes):
            _tell(space.add_lwpolyline(hole, close=True, dxfattribs=layer), kind="hole", id=r.id, name=str(n))
        at, room = label_place(r.boundary, r.holes)
        text = space.add_text(
            printable(r.name) or r.id, height=max(0.15, min(0.4, room / 3)), dxfattribs={"layer": NAMES}
        )
        text.set_placement(at, align=ezdxf.enums.TextEntityAlignment.MIDDLE_CENTER)
        _tell(text, kind="name", id=r.id)
    for v in _ordered(map.lines):
        line = space.add_line(v.start, v.end, dxfattribs={"layer": CLUTTER if v.clutter else LAYERS["line"]})
        _tell(line, kind="line", id=v.id)
    for g in _ordered(map.gateways):
        layer = {"layer": LAYERS["gateway"], "true_color": _color(GATEWAY)}
        _tell(
            space.add_line(g.posts[0], g.posts[1], dxfattribs=layer),
            kind="gateway",
            id=g.id,
            name=g.name,
            **{"class": g.class_},
        )
    for o in _ordered(map.objects):
        layer = {"layer": LAYERS["object"], "true_color": _color(OBJECT), "thickness": o.size[2]}
        layer["elevation"] = o.center[2] - o.size[2] / 2
        box = space.add_lwpolyline(footprint(o), close=True, dxfattribs=layer)
        _tell(box, kind="object", id=o.id, name=o.label)
    for note in _ordered(map.notes):
        text = space.add_text(printable(note.text), height=0.15, dxfattribs={"layer": NOTES, "insert": note.place})
        _tell(text, kind="note", id=note.id)
    out = io.StringIO()
    doc.write(out)
    return Exported(out.getvalue().encode("utf-8", "surrogateescape"), lost=_LOST)


def _tell(entity: Any, **about: str) -> None:
    """``name=value`` strings under our application's name."""
    entity.set_xdata(APP, [(1000, printable(f"{k}={v}")[:_LONGEST]) for k, v in about.items()])


def _color(rgb: Any) -> int:
    r, g, b = (int(c) for c in rgb[:3])
    return int(colors.rgb2int((r, g, b)))


def _ordered(items: dict[str, Any]) -> list[Any]:
    return [items[k] for k in sorted(items, key=natural)]
