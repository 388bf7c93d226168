"""What is true of a simulated run, as files: poses, rooms, gateways, lines and objects.

NAME.truth.json   rooms and gateways (posts, width, rooms, passed or only seen), lines, junctions, objects
NAME.rooms.png    the rooms as a label image, first row = largest y; 0 = no free floor
NAME.poses.tum    true pose of the laser at each scan
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from rgcore.scans.drive import crosses
from rgcore.scans.floor import FACE, POST, Floor
from rgcore.scans.plan_image import write_labels

if TYPE_CHECKING:
    from rgcore.scans.simulate import Simulated


def truth_of(simulated: Simulated) -> dict[str, Any]:
    """The truth as it is written to JSON. Metres, radians."""
    floor, path = simulated.floor, simulated.map_from_base[:, :2]
    visited = set(np.unique(floor.labels.at(path)).tolist()) - {0}
    area = np.bincount(floor.labels.values.ravel(), minlength=256) * floor.labels.resolution**2
    return {
        "map": floor.name,
        "resolution": floor.labels.resolution,
        "origin": _round(floor.labels.origin),
        "start": _round(simulated.map_from_base[0]),
        "rooms": [
            {
                "id": r.id,
                "name": r.room.name,
                "cls": r.room.cls,
                "class": r.room.region_class,
                "visited": r.id in visited,
                "area": round(float(area[r.id]), 2),
                "polygon": _round(r.outline),
                "holes": [_round(h) for h in r.holes],
            }
            for r in floor.rooms
        ],
        "gateways": [
            {
                "regions": [d.a, d.b],
                "posts": _round(d.posts),
                "width": round(d.door.width, 3),
                "kind": "door" if d.door.kind == "narrow_passage" else "opening",
                "class": d.door.kind,
                "passed": bool(crosses(path, d.posts).any()),
            }
            for d in floor.doors
            if d.door.open
        ],
        "closed_doors": [{"regions": [d.a, d.b], "posts": _round(d.posts)} for d in floor.doors if not d.door.open],
        "junctions": _junctions(floor),
        "objects": _furniture(floor, "box"),
        "tables": _furniture(floor, "legs"),
        "lines": [
            {
                "start": _round(a),
                "end": _round(b),
                "of": {FACE: "wall", POST: "post"}.get(int(k), "object"),
                "room": int(r) or None,
            }
            for (a, b), k, r in zip(floor.segments, floor.kind, floor.room, strict=True)
        ],
    }


def write_truth(simulated: Simulated, log: str | Path) -> list[Path]:
    """Write the truth of a run beside its log; the files' paths. Raises OSError."""
    log = Path(log)
    name = log.name.removesuffix(".gz").removesuffix(".log").removesuffix(".txt")
    truth, rooms, poses = (log.with_name(f"{name}.{e}") for e in ("truth.json", "rooms.png", "poses.tum"))
    truth.write_bytes(_readable(truth_of(simulated)))
    write_labels(simulated.floor.labels, rooms)
    half = simulated.map_from_laser[:, 2] / 2
    rows = zip(simulated.log.stamps, simulated.map_from_laser, np.sin(half), np.cos(half), strict=True)
    poses.write_text("".join(f"{t:.3f} {p[0]:.4f} {p[1]:.4f} 0 0 0 {s:.6f} {c:.6f}\n" for t, p, s, c in rows))
    return [truth, rooms, poses]


def _readable(truth: dict[str, Any]) -> bytes:
    """JSON with an item a line: a change in the plan makes a short diff."""
    parts = []
    for key, value in truth.items():
        many = isinstance(value, list) and value and isinstance(value[0], dict)
        text = (
            "[\n  " + ",\n  ".join(msgspec.json.encode(v).decode() for v in value) + "\n]"
            if many
            else msgspec.json.encode(value).decode()
        )
        parts.append(f'"{key}": {text}')
    return ("{\n" + ",\n".join(parts) + "\n}\n").encode()


def _junctions(floor: Floor) -> list[dict[str, Any]]:
    ids = {r.room.name: r.id for r in floor.rooms}
    return [
        {
            "class": j.kind,
            "regions": [ids[j.room]],
            "center": _round(np.array(j.at)),
            "crossing_points": [
                _round(np.array(j.at) + j.width / 2 * np.array([np.cos(a), np.sin(a)])) for a in j.arms
            ],
        }
        for j in floor.junctions
    ]


def _furniture(floor: Floor, shape: str) -> list[dict[str, Any]]:
    """Furniture of one shape, each with the room whose walls it stands between."""
    out = []
    for f in (f for f in floor.furniture if f.shape == shape):
        room = next((r.id for r in floor.rooms if r.holds(np.array(f.at))), None)
        out.append(
            {
                "kind": f.label,
                "room": room,
                "center": _round(np.array(f.at)),
                "size": _round(np.array(f.size)),
                "yaw": round(f.yaw, 4),
            }
        )
    return out


def _round(values: np.ndarray) -> Any:
    return (np.round(values, 4) + 0.0).tolist()
