"""How large an image is, by its header: before it is unpacked, for a small file may unpack to gigabytes."""

from __future__ import annotations

import re
import struct

_PNM = re.compile(rb"P[1-6]((?:\s+|#[^\n]*\n)+)(\d{1,9})((?:\s+|#[^\n]*\n)+)(\d{1,9})")


def image_size(data: bytes) -> tuple[int, int]:
    """Width and height in pixels of a png, jpg, pnm (pgm, pbm, ppm) or bmp; 0, 0 of anything else, or of damaged ones
    whose parts claim to be longer than the file."""
    if data.startswith(b"\x89PNG\r\n\x1a\n"):
        return _png(data)
    if data.startswith(b"\xff\xd8\xff"):
        return _jpg(data)
    if data.startswith(b"BM") and len(data) >= 26:
        width, height = struct.unpack("<ii", data[18:26])
        return abs(width), abs(height)
    found = _PNM.match(data[:4096])
    return (int(found[2]), int(found[4])) if found else (0, 0)


def _png(data: bytes) -> tuple[int, int]:
    """Header first, and every chunk no longer than the file: decoders make room for what a chunk claims."""
    if len(data) < 24 or data[12:16] != b"IHDR":
        return 0, 0
    at = 8
    while at + 8 <= len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        if at + 12 + length > len(data):
            return 0, 0
        if kind == b"IEND":
            break
        at += 12 + length
    width, height = struct.unpack(">II", data[16:24])
    return width, height


def _jpg(data: bytes) -> tuple[int, int]:
    """The frame header (SOFn) stands behind others, each with its length (ITU T.81, annex B)."""
    at = 2
    while at + 9 <= len(data) and data[at] == 0xFF:
        marker, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4], "big")
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", data[at + 5 : at + 9])
            return width, height
        at += 1 if marker == 0xFF else 2 + length
    return 0, 0
