"""Floor plans as files: a sheet with an L of walls drawn on it, as an image and as CAD drawings."""

from __future__ import annotations

import io

import cv2
import ezdxf
import numpy as np
from ezdxf import units

WALLS = [(0.0, 0.0), (8.0, 0.0), (8.0, 3.0), (4.0, 3.0), (4.0, 6.0), (0.0, 6.0)]
"""m, an L: no two of its sides can be taken for one another"""


def image(ending: str = ".png", pixels_per_metre: int = 20, rim: int = 10) -> bytes:
    """Black walls on white paper; ``rim`` pixels of paper around them."""
    points = np.array(WALLS) * pixels_per_metre
    width, height = (points.max(0) + 2 * rim).astype(int)
    sheet = np.full((height, width, 3), 255, np.uint8)
    rows = np.stack([points[:, 0] + rim, height - rim - points[:, 1]], 1).astype(np.int32)
    cv2.polylines(sheet, [rows], True, (0, 0, 0), 2)
    return bytes(cv2.imencode(ending, sheet)[1])


def drawing(unit: int = units.MM, per_metre: float = 1000.0, hidden: bool = False) -> bytes:
    """The walls as a polyline, a door as a block; ``hidden``: a frozen layer with lines far off."""
    doc = ezdxf.new(units=unit)
    space = doc.modelspace()
    space.add_lwpolyline([(x * per_metre, y * per_metre) for x, y in WALLS], close=True)
    door = doc.blocks.new("DOOR")
    door.add_arc((0, 0), per_metre, 0, 90)
    space.add_blockref("DOOR", (2 * per_metre, 2 * per_metre), dxfattribs={"rotation": 90})
    if hidden:
        doc.layers.add("FAR").freeze()
        space.add_line((0, 0), (1e5 * per_metre, 0), dxfattribs={"layer": "FAR"})
    return written(doc)


def bomb() -> bytes:
    """Ten blocks in ten blocks in ten ...: a small file of a hundred million lines."""
    doc = ezdxf.new()
    doc.blocks.new("B0").add_line((0, 0), (1, 1))
    for k in range(1, 9):
        block = doc.blocks.new(f"B{k}")
        for i in range(10):
            block.add_blockref(f"B{k - 1}", (i, 0))
    doc.modelspace().add_blockref("B8", (0, 0))
    return written(doc)


def written(doc: ezdxf.document.Drawing) -> bytes:
    out = io.StringIO()
    doc.write(out)
    return out.getvalue().encode()
