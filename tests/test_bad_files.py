"""Every reader and every way in which a file goes wrong: empty, cut off, of another version, absurd in its header.

A file is read as far as it goes or refused in one line; no traceback, no hang, no memory for what a header promises.
``tests/bench/fuzz_readers.py`` looks for more of them.
"""

from __future__ import annotations

import gzip
import resource
import struct
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parent / "bench"))

from fuzz_readers import Read, seeds

from rgcore.errors import InputError, RgError
from rgcore.scans import source
from rgcore.scans.read import read_log

LONGEST = 10.0  # s of the processor
MEMORY = 3 << 29  # bytes more than there were
READERS = ("carmen", "gzip", "wean", "npz", "csv", "bag1", "bag2-db3", "bag2-yaml", "mcap", "grid-yaml", "grid-image",
           "plan", "plan-image", "backdrop-png", "backdrop-jpg", "backdrop-dxf", "relations", "odometry",
           "json", "geojson", "fg.json", "dxf", "osm")  # fmt: skip


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Path, Read]]:
    found = seeds(tmp_path_factory.mktemp("seeds"))
    assert set(found) == set(READERS)
    return found


@pytest.fixture(autouse=True)
def little_memory() -> Iterator[None]:
    """A header must not cost what it promises."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MEMORY, hard))
    yield
    resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def tried(seed: tuple[Path, Path, Read], data: bytes) -> str | None:
    """What is said of a file with this content; None if it is read."""
    path, file, read = seed
    whole = file.read_bytes()
    began = time.process_time()
    said = None
    try:
        file.write_bytes(data)
        read(path)
    except RgError as e:
        said = str(e)
    finally:
        file.write_bytes(whole)
    assert time.process_time() - began < LONGEST
    assert said is None or ("\n" not in said and 10 < len(said) < 500)
    return said


@pytest.mark.parametrize("name", READERS)
def test_whole_files_are_read_and_empty_ones_refused(name: str, files: dict[str, Any]) -> None:
    assert tried(files[name], files[name][1].read_bytes()) is None
    assert tried(files[name], b"") is not None
    assert tried(files[name], bytes(5000)) is not None


@pytest.mark.parametrize("name", READERS)
def test_a_file_that_ends_early_is_read_so_far_or_refused(name: str, files: dict[str, Any]) -> None:
    data = files[name][1].read_bytes()
    refused = [tried(files[name], data[: int(len(data) * share)]) for share in (0.001, 0.1, 0.5, 0.9, 0.999)]
    assert refused[0] is not None


def changed(old: bytes, new: bytes) -> Callable[[bytes], bytes]:
    def change(data: bytes) -> bytes:
        assert old in data, old
        return data.replace(old, new, 1)

    return change


VERSIONS: dict[str, tuple[Callable[[bytes], bytes], str | None]] = {
    "npz": (lambda d: d.replace(b"\x93NUMPY\x01", b"\x93NUMPY\x09"), "cannot be read"),
    "bag1": (changed(b"#ROSBAG V2.0", b"#ROSBAG V9.0"), "bag"),
    "bag2-db3": (changed(b"SQLite format 3", b"SQLite format 9"), "bag"),
    "bag2-yaml": (lambda d: d.replace(b"version: ", b"version: 9", 1), "bag"),
    "mcap": (lambda d: b"\x89MCAP9" + d[6:], "bag"),
    "json": (changed(b'"version": "1.0"', b'"version": "9.0"'), "this software reads 1.0; update it"),
    "dxf": (changed(b"AC1024", b"AC9999"), None),  # the parser reads what it knows of a newer version
    "backdrop-dxf": (changed(b"AC1027", b"AC9999"), None),
    "grid-image": (changed(b"P5", b"P9"), "not an image"),
    "osm": (changed(b'version="0.6"', b'version="9.6"'), None),
}


@pytest.mark.parametrize("name", VERSIONS)
def test_another_version_is_named_or_read(name: str, files: dict[str, Any]) -> None:
    change, says = VERSIONS[name]
    said = tried(files[name], change(files[name][1].read_bytes()))
    assert said is None or (says is not None and says in said)


def png(width: int, height: int) -> bytes:
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sIIBBBBB", 13, b"IHDR", width, height, 8, 2, 0, 0, 0) + bytes(100)


def long_chunk() -> bytes:
    """A small image whose data claim to be 2 GB: decoders make room for them first."""
    return png(64, 64)[:33] + struct.pack(">I4s", 2**31 - 1, b"IDAT") + bytes(100)


def npy(shape: str) -> bytes:
    import io
    import zipfile

    head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".encode().ljust(117) + b"\n"
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as z:
        z.writestr("ranges.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head)
    return out.getvalue()


LAUGHS = b'<?xml version="1.0"?><!DOCTYPE osm [<!ENTITY a "aaaaaaaaaa">' + b"".join(
    b'<!ENTITY %c "%s">' % (98 + k, (b"&%c;" % (97 + k)) * 10) for k in range(12)
) + b']><osm version="0.6"><node id="&m;" lat="0" lon="0"/></osm>'  # fmt: skip

ABSURD: dict[str, list[Callable[[bytes], bytes]]] = {
    "carmen": [
        lambda _: b"FLASER 999999999 1.0 2.0 3.0\n",
        lambda _: b"ROBOTLASER1 0 -1.57 3.14 0.01 80 0 0 4294967295 1 2\n",
    ],
    "gzip": [lambda d: d[:4] + b"\xff" * 6 + d[10:]],
    "wean": [lambda _: b"L 0 0 0 " + b"1 " * 200_000 + b"\n"],
    "npz": [lambda _: npy("(1000000000000,)"), lambda _: npy("(-5,)"), lambda _: npy("(1000000, 1000000)")],
    "csv": [lambda _: b"stamp,x,y,theta,range_0,range_999999999\n1,2,3,4,5,6\n", lambda _: b"," * 500_000],
    "bag1": [lambda d: d[:13] + b"\xff\xff\xff\x7f" + d[17:], lambda d: d[:13] + b"\xff" * 64 + d[77:]],
    "bag2-db3": [lambda d: d[:16] + b"\0\1" + d[18:28] + b"\xff" * 4 + d[32:]],
    "mcap": [lambda d: d[:9] + b"\xff" * 7 + b"\x7f" + d[17:]],
    "grid-yaml": [changed(b"resolution: 0.2", b"resolution: 1.0e-9"), changed(b"- -2.0", b"- 1.0e+300")],
    "grid-image": [
        lambda _: b"P5\n100000 100000\n255\n",
        lambda _: b"P5\n# x\n31000 31000 255\n" + bytes(99),
        lambda _: long_chunk(),
        lambda _: png(30000, 30000),
    ],
    "plan": [lambda _: b'{"name":' + b"[" * 100_000],
    "plan-image": [lambda _: png(200_000, 200_000), lambda _: png(30000, 30000), lambda _: long_chunk()],
    "backdrop-png": [lambda _: png(30000, 30000), lambda _: long_chunk()],
    "backdrop-jpg": [lambda d: d[:2] + b"\xff\xc0\x00\x0b\x08\xff\xff\xff\xff" + d[2:]],
    "backdrop-dxf": [changed(b"HEADER", b"HEADER\n 90\n 999999999999999999999")],
    "relations": [lambda _: b"EDGE2 99999999999 99999999999 0 0 0\n" * 1000],
    "odometry": [lambda _: b"1e308,0,1e308,1e308,1e308\n" * 1000],
    "json": [lambda _: b"[" * 100_000, lambda d: d.replace(b"0.", b"1e999", 1)],
    "geojson": [lambda _: b'{"features":' + b"[" * 100_000],
    "fg.json": [lambda _: b'{"features":[{"place":{"type":"Polygon","coordinates":' + b"[" * 50_000],
    "dxf": [
        changed(b"HEADER", b"HEADER\n 90\n 999999999999999999999"),
        lambda d: d.replace(b"\n 10\n", b"\n 10\n1e999\n", 3),
    ],
    "osm": [lambda _: LAUGHS, lambda _: b"<osm>" + b"<a>" * 100_000],
}  # fmt: skip


@pytest.mark.parametrize("name", ABSURD)
def test_an_absurd_header_costs_neither_time_nor_memory(name: str, files: dict[str, Any]) -> None:
    data = files[name][1].read_bytes()
    for change in ABSURD[name]:
        tried(files[name], change(data))


def test_all_readers_have_an_absurd_header() -> None:
    assert set(READERS) - set(ABSURD) == {"bag2-yaml"}, "its sizes are told by the database"


def test_a_small_file_that_unpacks_to_gigabytes_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source, "LARGEST", 1 << 20)
    (tmp_path / "a.log.gz").write_bytes(gzip.compress(bytes(5 << 20)))
    with pytest.raises(InputError, match="unpacks to more than"):
        read_log(tmp_path / "a.log.gz")
    (tmp_path / "b.log").write_bytes(b"x" * (2 << 20))
    with pytest.raises(InputError, match="is larger than"):
        read_log(tmp_path / "b.log")


def test_a_laser_of_no_beams_at_all(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", ranges=np.zeros((3, 0)), stamps=np.zeros(3))
    with pytest.raises(RgError):
        read_log(tmp_path / "a.npz")
