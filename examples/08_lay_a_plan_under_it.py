"""Lay a floor plan under the map.

Most buildings have a drawing. Draws one as an architect would (DXF in millimetres, its own origin, turned by 20
degrees), lays it under a map, and brings it to its place by two points: two corners of the building on the plan, and
where they are on the map. The editor shows it under the walls; undo takes it back; a new run keeps it.

    python examples/08_lay_a_plan_under_it.py [FOLDER]
"""

from __future__ import annotations

import io
import json
import math
import sys
from pathlib import Path

import ezdxf
import numpy as np

from rgcore import pipeline
from rgcore.exports.formats import render
from rgcore.model.backdrops import placed
from rgcore.model.edits_backdrops import aligned
from rgcore.model.project import Project
from rgcore.scans.backdrop import Drawing, read_backdrop
from rgcore.scans.read import read_log
from rgviz.demo import LOG, PLAN

TURN = np.array([[math.cos(0.35), math.sin(0.35)], [-math.sin(0.35), math.cos(0.35)]])


def drawn(rooms: list[np.ndarray]) -> bytes:
    """The rooms as a drawing in millimetres, far from its origin."""
    doc = ezdxf.new(units=ezdxf.units.MM)
    for outline in rooms:
        doc.modelspace().add_lwpolyline(1000 * outline @ TURN + 250_000, close=True)
    out = io.StringIO()
    doc.write(out)
    return out.getvalue().encode()


def main(folder: Path) -> None:
    rooms = [np.array(r["outline"], float) for r in json.loads(PLAN.read_text())["rooms"]]
    data = drawn(rooms)
    with Project.create(folder / "office.rg", pipeline.run(read_log(LOG))) as project:
        id = project.add_backdrop(data, "office.dxf", by="script").id
        strokes = read_backdrop(data, "office.dxf")
        assert isinstance(strokes, Drawing)
        on_map = placed(project.map.backdrops[id], strokes.strokes)
        sides = np.concatenate([np.stack([r, np.roll(r, -1, 0)], 1) for r in rooms])  # the same strokes, true places
        far = [sides[:, 0].sum(1).argmin(), sides[:, 0].sum(1).argmax()]
        pairs = list(zip(on_map[far, 0].tolist(), sides[far, 0].tolist(), strict=True))
        project.do(aligned(project.map, id, pairs), by="script")

        plan = project.map.backdrops[id]
        on_map = placed(plan, strokes.strokes)
        print(f"{plan.name}: turned by {math.degrees(plan.yaw):.1f} degrees, {plan.scale:.4f} m a unit")
        print(f"every corner lies within {1000 * np.abs(on_map - sides).max():.1f} mm of its place")
        paths = "".join(f"M{x0:.3f} {-y0:.3f}L{x1:.3f} {-y1:.3f}" for (x0, y0), (x1, y1) in on_map)
        ink = f'<path d="{paths}" fill="none" stroke="#78288a" stroke-width="0.06"/>'
        picture = render(".svg", project.map).decode().replace("</svg>", ink + "</svg>")
        (folder / "plan.svg").write_text(picture, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
