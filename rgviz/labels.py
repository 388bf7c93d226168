"""Labels of the map; the browser decides which of them have room (``static/rgviz.js``)."""

from __future__ import annotations

from typing import Any

from rgcore.model.records import RGMap
from rgviz import theme
from rgviz.artist import Artist


def labels(map_: RGMap, artist: Artist) -> list[dict[str, Any]]:
    """One a region, gateway, object and note.

    ``weight`` orders them (the heavier one gets the room), ``room`` is the metres that they may fill, ``least`` the
    pixels that those metres must be on the screen.
    """
    out = []
    for r in map_.regions.values():
        x, y = artist.middle(r)
        color = theme.css(tuple(int(0.62 * c) for c in theme.class_color(r.class_)))  # type: ignore[arg-type]
        out.append(
            _label(
                "region",
                r.id,
                r.name or r.id,
                x,
                y,
                room=max(p[0] for p in r.boundary) - min(p[0] for p in r.boundary),
                least=24,
            )
            | {"color": color, "note": r.class_, "weight": 1e3 + r.box.size[0] * r.box.size[1]}
        )
    for g in map_.gateways.values():
        (ax, ay), (bx, by) = g.posts
        text = g.name or g.id
        named = bool(g.name)
        out.append(
            _label("gateway", g.id, text, (ax + bx) / 2, (ay + by) / 2, room=g.width, least=24 if named else 60)
            | {"color": theme.css((150, 62, 0)), "note": "", "weight": 100.0 if named else 1.0}
        )
    for o in map_.objects.values():
        out.append(
            _label("object", o.id, o.label or o.id, o.center[0], o.center[1], room=max(o.size[:2]), least=36)
            | {"color": theme.css((130, 60, 100)), "note": "", "weight": 10.0}
        )
    for n in map_.notes.values():
        out.append(
            _label("note", n.id, n.text, *n.place, room=1.0, least=24)
            | {"color": theme.css((110, 80, 0)), "note": "", "weight": 50.0}
        )
    return out


def _label(kind: str, id_: str, text: str, x: float, y: float, room: float, least: float) -> dict[str, Any]:
    short = text if len(text) <= 40 else text[:39] + "…"
    return {"kind": kind, "id": id_, "text": short, "x": x, "y": y, "room": room, "least": least}
