"""Floor plans to lay under a map: what is read, in which units, and what is refused before it costs anything."""

from __future__ import annotations

import io
import struct
import time
import tracemalloc

import cv2
import ezdxf
import numpy as np
import pytest
from ezdxf import units
from make_plans import WALLS, bomb, drawing, image, written

from rgcore.errors import InputError
from rgcore.scans import backdrop
from rgcore.scans.backdrop import MOST_PIXELS, SHARPEST, Drawing, Picture, read_backdrop

SPAN = np.ptp(WALLS, axis=0)


@pytest.mark.parametrize("ending", [".png", ".jpg"])
def test_an_image_is_what_its_bytes_say_whatever_it_is_called(ending: str) -> None:
    plan = read_backdrop(image(ending), "plan.dxf")
    assert isinstance(plan, Picture)
    assert plan.size == tuple(SPAN * 20 + 20)
    assert plan.pixels.shape == (int(plan.size[1]), int(plan.size[0]), 3)
    dark = plan.pixels.max(2) < 100
    assert dark[-11, 12:160].all()  # the long wall lies at the bottom
    assert not dark[:5].any()
    assert not plan.measured


@pytest.mark.parametrize(
    ("unit", "per_metre"),
    [(units.MM, 1000), (units.CM, 100), (units.M, 1), (units.IN, 1 / 0.0254), (units.FT, 1 / 0.3048)],
)
def test_a_drawing_is_in_metres_whatever_its_units(unit: int, per_metre: float) -> None:
    plan = read_backdrop(drawing(unit, per_metre), "a.dxf")
    assert isinstance(plan, Drawing)
    assert plan.measured
    np.testing.assert_allclose(plan.size, SPAN, atol=1e-6)
    ends = plan.strokes.reshape(-1, 2)
    np.testing.assert_allclose([ends.min(0), ends.max(0)], [-SPAN / 2, SPAN / 2], atol=1e-6)
    arc = plan.strokes[len(WALLS) :]  # the door: a quarter about (2, 2), turned to the left
    assert len(arc) > 4
    np.testing.assert_allclose(np.hypot(*(arc.reshape(-1, 2) + SPAN / 2 - 2).T), 1.0, atol=1e-3)


def test_a_drawing_without_units_says_so_and_hidden_layers_do_not_count() -> None:
    plan = read_backdrop(drawing(0, 1000, hidden=True), "a.dxf")
    assert not plan.measured
    np.testing.assert_allclose(plan.size, SPAN * 1000)


def test_all_kinds_of_outlines_are_strokes_and_text_is_none() -> None:
    doc = ezdxf.new(units=units.M)
    space = doc.modelspace()
    space.add_circle((0, 0), 2)
    space.add_ellipse((10, 0), (2, 0), 0.5)
    space.add_spline([(20, 0), (22, 1), (24, 0)])
    space.add_polyline2d([(30, 0), (31, 0), (31, 1)])
    space.add_solid([(40, 0), (41, 0), (40, 1), (41, 1)])
    space.add_text("Lab")
    space.add_line((50, 0), (float("nan"), 0))
    plan = read_backdrop(written(doc), "a.dxf")
    assert isinstance(plan, Drawing)
    np.testing.assert_allclose(plan.size, (43, 4), atol=0.01)
    assert np.isfinite(plan.strokes).all()


def test_transparent_paper_is_white_and_sixteen_bits_are_eight() -> None:
    sheet = np.zeros((4, 6, 4), np.uint8)
    sheet[1, 2] = (255, 0, 0, 255)
    blue = read_backdrop(bytes(cv2.imencode(".png", sheet)[1]), "a.png")
    assert isinstance(blue, Picture)
    assert blue.pixels[1, 2].tolist() == [0, 0, 255]
    assert blue.pixels[0, 0].tolist() == [255, 255, 255]
    grey = read_backdrop(bytes(cv2.imencode(".png", np.full((4, 6), 0x80FF, np.uint16))[1]), "a.png")
    assert isinstance(grey, Picture)
    assert (grey.pixels == 0x80).all()


def test_a_large_image_is_thinned_and_keeps_its_size() -> None:
    plan = read_backdrop(bytes(cv2.imencode(".png", np.full((60, 6000), 255, np.uint8))[1]), "a.png")
    assert isinstance(plan, Picture)
    assert plan.size == (6000, 60)
    assert plan.pixels.shape == (31, SHARPEST, 3)


def png(width: int, height: int) -> bytes:
    """A header alone."""
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sIIBBBBB", 13, b"IHDR", width, height, 8, 2, 0, 0, 0) + bytes(4)


def jpg(width: int, height: int) -> bytes:
    return b"\xff\xd8\xff\xe0\0\4ab\xff\xc0\0\x0b\x08" + struct.pack(">HH", height, width) + bytes(8)


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (b"", "an empty file; expected png, jpg or DXF"),
        (b"hello", "no floor plan; expected png, jpg or DXF"),
        (b"GIF89a", "no floor plan"),
        (b"%PDF-1.7", "a PDF; save the page as png"),
        (b"AC1027\0\0", "a DWG, which only CAD programs read; save it as DXF there"),
        (image()[:400], "a damaged png"),
        (image()[:20], "a damaged png"),
        (image(".jpg")[:100], "a damaged jpg"),
        (png(100_000, 100_000), f"100000 x 100000 pixels; at most {MOST_PIXELS // 10**6} million"),
        (jpg(60_000, 60_000), "60000 x 60000 pixels"),
        (png(0, 10), "a damaged png"),
        (png(70_000_000, 1), "30,000 in a row"),
        (b"0\nSECTION\n2\nENTITIES\n0\nENDSEC\n0\nEOF\n", "holds no lines in its model space"),
        (drawing()[:5000], r"holds no lines|no DXF that can be read"),
        (bytes(backdrop.LARGEST + 1), "is larger than 32 MB; save it smaller"),
    ],
    ids=lambda v: v[:20] if isinstance(v, str) else "",
)
def test_what_is_no_plan_is_refused_in_a_line(data: bytes, why: str) -> None:
    with pytest.raises(InputError, match=why) as e:
        read_backdrop(data, "plan")
    assert str(e.value).startswith("plan: ")
    assert "\n" not in str(e.value)


def test_an_image_that_unpacks_to_gigabytes_is_refused_before_it_is_unpacked() -> None:
    data = png(30_000, 30_000)
    tracemalloc.start()
    with pytest.raises(InputError, match="30000 x 30000 pixels"):
        read_backdrop(data, "plan")
    assert tracemalloc.get_traced_memory()[1] < 1 << 20
    tracemalloc.stop()


def test_blocks_in_blocks_without_end_are_refused_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backdrop, "MOST_STROKES", 3000)
    monkeypatch.setattr(backdrop, "MOST_PARTS", 5000)
    start = time.process_time()
    with pytest.raises(InputError, match=r"more than 3,000 strokes|without end"):
        read_backdrop(bomb(), "plan")
    doc = ezdxf.new()
    doc.blocks.new("A").add_blockref("A", (1, 0))
    doc.blocks.new("B").add_line((0, 0), (1, 0))
    doc.modelspace().add_line((0, 0), (1, 0))
    doc.modelspace().add_blockref("A", (0, 0))
    with pytest.raises(InputError, match="without end"):
        read_backdrop(written(doc), "plan")
    doc.modelspace().delete_all_entities()
    many = {"row_count": 30000, "column_count": 30000, "row_spacing": 1, "column_spacing": 1}
    doc.modelspace().add_blockref("B", (0, 0), dxfattribs=many)
    with pytest.raises(InputError, match=r"strokes|without end"):
        read_backdrop(written(doc), "plan")
    assert time.process_time() - start < 10


def test_a_drawing_with_faults_is_mended_in_silence(capfd: pytest.CaptureFixture[str]) -> None:
    """CAD programs write faulty files; what can be read is."""
    data = drawing().replace(b"$INSUNITS", b"$OTHER", 1)
    plan = read_backdrop(data, "a.dxf")
    assert isinstance(plan, Drawing)
    assert not plan.measured
    assert io.StringIO(capfd.readouterr().err).read() == ""
