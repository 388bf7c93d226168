"""Thin strokes as a GLB: the graphics card's own lines, a pixel wide, many times cheaper than viser's thick ones."""

from __future__ import annotations

import struct

import msgspec
import numpy as np

from rgviz.theme import RGB, srgb_to_linear

_POINTS, _LINES, _FLOAT, _UBYTE = 34962, 1, 5126, 5121
"""glTF 2.0: ARRAY_BUFFER, primitive mode, component types"""


def strokes_glb(ends: np.ndarray, color: RGB | np.ndarray) -> bytes:
    """A binary glTF 2.0 of strokes (N, 2, 3) [m] in one sRGB colour or one each (N, 3); N > 0."""
    points = np.ascontiguousarray(ends, np.float32).reshape(-1, 3)
    colors = np.full((len(points), 4), 255, np.uint8)
    colors[:, :3] = np.repeat(srgb_to_linear(np.broadcast_to(np.asarray(color, np.uint8), (len(ends), 3))), 2, 0)
    places, tints = points.tobytes(), colors.tobytes()
    extent = {"min": points.min(0).tolist(), "max": points.max(0).tolist()}
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"mode": _LINES, "attributes": {"POSITION": 0, "COLOR_0": 1}, "material": 0}]}],
        "materials": [{"extensions": {"KHR_materials_unlit": {}}, "pbrMetallicRoughness": {}}],
        "extensionsUsed": ["KHR_materials_unlit"],
        "accessors": [
            {"bufferView": 0, "componentType": _FLOAT, "count": len(points), "type": "VEC3", **extent},
            {"bufferView": 1, "componentType": _UBYTE, "normalized": True, "count": len(points), "type": "VEC4"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(places), "target": _POINTS},
            {"buffer": 0, "byteOffset": len(places), "byteLength": len(tints), "target": _POINTS},
        ],
        "buffers": [{"byteLength": len(places) + len(tints)}],
    }
    text = msgspec.json.encode(document)
    return _chunks((b"JSON", text + b" " * (-len(text) % 4)), (b"BIN\0", places + tints))


def _chunks(*chunks: tuple[bytes, bytes]) -> bytes:
    body = b"".join(struct.pack("<I4s", len(data), kind) + data for kind, data in chunks)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body
