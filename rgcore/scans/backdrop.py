"""Floor plans to lay under a map: images (png, jpg) and CAD drawings (DXF), out of bytes that nobody vouches for.

What it is is told by its first bytes, never by a name. Its size is known before it is unpacked: a small file that
unpacks to gigabytes is refused.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np

from rgcore.errors import InputError
from rgcore.scans.image_size import image_size

Form = Literal["png", "jpg", "dxf"]
Size = tuple[float, float]

LARGEST = 32 << 20
"""bytes of a file: a large scanned plan, or the drawing of a floor"""
MOST_PIXELS = 80_000_000
"""of an image: a sheet of A0 at 200 dpi has 62 million"""
LONGEST = 30_000
"""pixels of its longer side: thinning a row of many millions takes gigabytes"""
SHARPEST = 3072
"""pixels of its longer side that are shown: a centimetre in 30 m, and every graphics card takes it as one texture"""
MOST_STROKES = 150_000
"""of a drawing"""
MOST_PARTS = 300_000
"""entities of a drawing with all blocks put in their places"""
DEEPEST = 32
"""blocks within blocks"""
SAG = 0.01
"""m that a stroke may lie beside the arc that it stands for"""


@dataclass(frozen=True, eq=False)
class Picture:
    """An image: ``pixels`` (H, W, 3) uint8 RGB, first row on top, thinned to ``SHARPEST``; ``size``: width and height
    of the whole in pixels."""

    pixels: np.ndarray
    size: Size

    measured = False
    """whether its units are metres"""


@dataclass(frozen=True, eq=False)
class Drawing:
    """A CAD drawing: ``strokes`` (N, 2, 2) about the middle of all, ``size``: how far they extend; metres if
    ``measured``, else units that nobody named."""

    strokes: np.ndarray
    size: Size
    measured: bool


Plan = Picture | Drawing


def read_file(path: Path) -> bytes:
    """The bytes of a plan's file, no more of them than are taken. Raises InputError."""
    try:
        with open(path, "rb") as f:
            data = f.read(LARGEST + 1)
    except OSError as e:
        raise InputError(path, f"cannot be read: {e.strerror or e}") from e
    form_of(data, str(path))
    return data


def form_of(data: bytes, name: str) -> Form:
    """What a file is. Raises InputError, which names it, for anything that cannot be shown."""
    if len(data) > LARGEST:
        raise InputError(name, f"is larger than {LARGEST >> 20} MB; save it smaller")
    if data.startswith(b"\x89PNG\r\n\x1a\n"):
        return "png"
    if data.startswith(b"\xff\xd8\xff"):
        return "jpg"
    if data.startswith(b"AutoCAD Binary DXF") or b"SECTION" in data[:4096]:
        return "dxf"
    if data.startswith((b"AC10", b"AC1.", b"MC0.")):
        raise InputError(name, "a DWG, which only CAD programs read; save it as DXF there")
    if data.startswith(b"%PDF"):
        raise InputError(name, "a PDF; save the page as png")
    raise InputError(name, f"{'an empty file' if not data else 'no floor plan'}; expected png, jpg or DXF")


def read_backdrop(data: bytes, name: str) -> Plan:
    """The plan that a file holds; ``name`` is for messages only. Raises InputError, a line."""
    form = form_of(data, name)
    return _drawing(data, name) if form == "dxf" else _picture(data, name, form)


def _picture(data: bytes, name: str, form: Form) -> Picture:
    width, height = image_size(data)
    if not width or not height:
        raise InputError(name, f"a damaged {form}; save it anew")
    if width * height > MOST_PIXELS or max(width, height) > LONGEST:
        most = f"at most {MOST_PIXELS // 10**6} million, {LONGEST:,} in a row"
        raise InputError(name, f"{width} x {height} pixels; {most}: save it smaller")
    try:
        pixels = cv2.imdecode(
            np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED if form == "png" else cv2.IMREAD_COLOR
        )
    except (cv2.error, MemoryError):
        pixels = None
    if pixels is None:
        raise InputError(name, f"a damaged {form}; save it anew")
    height, width = pixels.shape[:2]  # a jpg may lie on its side
    shrink = min(1.0, SHARPEST / max(width, height))
    if shrink < 1:
        small = max(1, round(width * shrink)), max(1, round(height * shrink))
        pixels = cv2.resize(pixels, small, interpolation=cv2.INTER_AREA)
    return Picture(_rgb(pixels), (float(width), float(height)))


def _rgb(pixels: np.ndarray) -> np.ndarray:
    """(H, W, 3) uint8 RGB on white paper, of grey or BGR, 8 or 16 bit, opaque or not."""
    if pixels.dtype == np.uint16:
        pixels = (pixels >> 8).astype(np.uint8)
    if pixels.ndim == 2:
        return np.repeat(pixels[:, :, None], 3, 2)
    rgb = pixels[:, :, 2::-1]
    if pixels.shape[2] == 3:
        return np.ascontiguousarray(rgb)
    opaque = pixels[:, :, 3:].astype(np.uint16)
    return ((rgb * opaque + 255 * (255 - opaque)) // 255).astype(np.uint8)


def _drawing(data: bytes, name: str) -> Drawing:
    from ezdxf import recover, units  # takes a third of a second, and most have no DXF

    try:
        doc, _ = recover.read(io.BytesIO(data))
    except Exception as e:  # a damaged file ends its parser in many ways
        raise InputError(
            name, f"no DXF that can be read: {(str(e).splitlines() or [type(e).__name__])[0][:120]}"
        ) from e
    metre = units.conversion_factor(units.InsertUnits(doc.units), units.InsertUnits.Meters) if doc.units else 1.0
    try:
        found = list(_strokes(doc, name, SAG / metre))
    except InputError:
        raise
    except Exception as e:
        raise InputError(name, f"a damaged DXF: {(str(e).splitlines() or [type(e).__name__])[0][:120]}") from e
    strokes = metre * (np.concatenate(found) if found else np.zeros((0, 2, 2)))
    strokes = strokes[(np.abs(strokes) < 1e9).all((1, 2))]  # also drops what is no number
    if not len(strokes):
        raise InputError(name, "holds no lines in its model space; export the floor as lines or polylines")
    low, high = strokes.min((0, 1)), strokes.max((0, 1))
    width, height = (max(float(v), 1e-3) for v in high - low)
    return Drawing(strokes - (low + high) / 2, (width, height), bool(doc.units))


def _strokes(doc: Any, name: str, sag: float) -> Iterator[np.ndarray]:
    """(N, 2, 2) pieces of all that is seen of the model space, in the drawing's units."""
    from ezdxf import path

    hidden = {layer.dxf.name.lower() for layer in doc.layers if layer.is_off() or layer.is_frozen()}
    count = 0
    for entity in _parts(doc.modelspace(), name):
        if entity.dxf.get("layer", "0").lower() in hidden or entity.dxf.get("invisible", 0):
            continue
        try:
            way = path.make_path(entity)
        except (TypeError, ValueError, ZeroDivisionError):
            continue  # text, hatches, dimensions: no outline
        corners = []
        for v in way.flattening(sag):
            corners.append((v.x, v.y))
            count += 1
            if count > MOST_STROKES:
                raise InputError(name, f"more than {MOST_STROKES:,} strokes; export the walls of one floor only")
        if len(corners) > 1:
            c = np.array(corners, float)
            yield np.stack([c[:-1], c[1:]], 1)


def _parts(space: Any, name: str) -> Iterator[Any]:
    """Entities with blocks put in their places. Raises InputError where that is without end."""
    waiting, seen = [iter(space)], 0
    while waiting:
        entity = next(waiting[-1], None)
        if entity is None:
            waiting.pop()
            continue
        seen += 1
        if seen > MOST_PARTS or len(waiting) > DEEPEST:
            raise InputError(name, "blocks within blocks without end; explode them, or export one floor")
        if entity.dxftype() != "INSERT":
            yield entity
        elif entity.mcount > 1:
            waiting.append(entity.multi_insert())
        else:
            waiting.append(entity.virtual_entities())
