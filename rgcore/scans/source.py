"""Source: the bytes of a log file, unpacked, with a name for error messages."""

from __future__ import annotations

import hashlib
import zlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from rgcore.errors import InputError

LARGEST = 2 << 30
"""bytes of a log, unpacked: an hour of 1000 beams, 40 times a second, is 0.9 GB as text"""
_GZIP = b"\x1f\x8b"
_AS_GZIP = 16 + zlib.MAX_WBITS


@dataclass(frozen=True)
class Source:
    """A log file: ``data`` is its content after unpacking, ``sha256`` that of the file as it lies on the disk."""

    path: Path
    data: bytes
    sha256: str

    @cached_property
    def lines(self) -> list[str]:
        """The lines without their ends; ``lines[i]`` is line i + 1 of the file."""
        return [line.rstrip("\r") for line in self.data.decode("utf-8-sig", "replace").split("\n")]

    @cached_property
    def last_line(self) -> int:
        """Number of the last line that holds anything."""
        return next((i for i in range(len(self.lines), 0, -1) if self.lines[i - 1].strip()), 0)

    @property
    def ends_open(self) -> bool:
        """Whether the last line lacks its line end: a recording that was interrupted looks like this."""
        return not self.data.endswith(b"\n")

    def error(self, message: str, line: int | None = None) -> InputError:
        return InputError(self.path, message, line)


def open_source(path: str | Path) -> Source:
    """Read and unpack a file; gzip is told by its first bytes, not by its name. Raises InputError."""
    path = Path(path)
    try:
        size = path.stat().st_size
        raw = path.read_bytes() if size <= LARGEST else b""
    except FileNotFoundError as e:
        raise InputError(path, "no such file; check the path") from e
    except IsADirectoryError as e:
        raise InputError(path, "is a folder; name the log file in it") from e
    except (OSError, ValueError) as e:
        raise InputError(path, f"cannot be read: {getattr(e, 'strerror', None) or e}") from e
    if size > LARGEST:
        raise InputError(path, f"is larger than {LARGEST >> 30} GB; split the log")
    if not raw:
        raise InputError(path, "the file is empty; copy or record it again")
    data = _gunzip(path, raw) if raw.startswith(_GZIP) else raw
    if not data.strip():
        raise InputError(path, "the file holds nothing but white space; copy or record it again")
    return Source(path, data, hashlib.sha256(raw).hexdigest())


def _gunzip(path: Path, raw: bytes) -> bytes:
    """All members of a gzip file; zero bytes after the last one are padding."""
    out, left = [], LARGEST
    try:
        while raw:
            member = zlib.decompressobj(_AS_GZIP)
            out.append(member.decompress(raw, left + 1))
            left -= len(out[-1])
            if left < 0:
                raise InputError(path, f"unpacks to more than {LARGEST >> 30} GB; that is no log, or split it")
            if not member.eof:
                raise InputError(path, "the gzip file ends early; copy it again or unpack what is left with `zcat`")
            raw = member.unused_data.lstrip(b"\0")
    except zlib.error as e:
        raise InputError(path, f"the gzip file is damaged ({e}); copy it again") from e
    return b"".join(out)
