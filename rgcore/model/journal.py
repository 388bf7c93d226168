"""The journal: what people did, one checksummed line an entry, on the disk before anybody sees it.

A line is ``{"crc":"1f2e3d4c","entry":{...}}`` with the CRC-32 of the entry's bytes. A torn end (power cut, kill, full
disk) is recognised by it and set aside; damage before the end cannot come from a crash and is an error.
"""

from __future__ import annotations

import contextlib
import os
import zlib
from collections.abc import Sequence
from pathlib import Path

import msgspec

from rgcore.errors import EditError, ProjectError
from rgcore.model.history import AnyEntry


class _Line(msgspec.Struct, frozen=True):
    crc: str
    entry: msgspec.Raw


class Journal:
    """``edits.jsonl``. ``entries``: what it holds; ``notes``: what was found torn when it was opened."""

    def __init__(self, path: str | Path) -> None:
        """Read the journal; nothing is written before the first ``append``.

        Raises ProjectError if it cannot be read, is damaged before its end, or holds entries of a newer version.
        """
        self.path = Path(path)
        try:
            data = self.path.read_bytes()
        except OSError as e:
            remedy = "restore it, or make an empty file to go on without edits"
            raise ProjectError(f"{self.path}: cannot read the journal: {e.strerror}; {remedy}") from e
        self.entries, self._size = _parse(self.path, data)
        self._torn = data[self._size :]
        self._newline = self._size > 0 and data[self._size - 1 : self._size] != b"\n"
        self.notes: list[str] = []
        if self._torn.strip(b"\0"):
            size, kept = len(self._torn), len(self.entries)
            self.notes.append(f"{self.path}: the last entry was torn ({size} bytes); all {kept} before it are there")
        self._dirty = bool(self._torn)
        self._fd: int | None = None

    @property
    def next_number(self) -> int:
        return self.entries[-1].number + 1 if self.entries else 1

    def append(self, entry: AnyEntry) -> None:
        """Write an entry and see it onto the disk before returning.

        Raises ProjectError if that fails (full disk); the journal is then as it was before.
        """
        data = encode_line(entry)
        try:
            fd = self._ready()
            _write(fd, b"\n" + data if self._newline else data)
            os.fsync(fd)
        except OSError as e:
            self._dirty = True
            with contextlib.suppress(OSError):
                self._cut()
            raise ProjectError(f"{self.path}: the edit was not kept: {e.strerror}; make room and try again") from e
        self._size += len(data) + self._newline
        self._newline = False
        self.entries.append(entry)

    def close(self) -> None:
        if self._fd is not None:
            os.close(self._fd)
            self._fd = None

    def _ready(self) -> int:
        """The file opened for appending, ending after its last whole entry."""
        if self._fd is None:
            self._fd = os.open(self.path, os.O_WRONLY | os.O_APPEND | os.O_CLOEXEC)
        if self._torn:
            _set_aside(self.path.with_name(self.path.name + ".torn"), self._torn)
            self._torn = b""
        if self._dirty:
            self._cut()
        return self._fd

    def _cut(self) -> None:
        if self._fd is not None:
            os.ftruncate(self._fd, self._size)
            os.fsync(self._fd)
            self._dirty = False


def encode_line(entry: AnyEntry) -> bytes:
    """An entry as its line of the journal, with its checksum."""
    body = msgspec.json.encode(entry)
    return msgspec.json.encode(_Line(f"{zlib.crc32(body):08x}", msgspec.Raw(body))) + b"\n"


def readable(entry: AnyEntry) -> AnyEntry:
    """The entry as the journal will give it back. Raises EditError if it could not be read back."""
    try:
        return msgspec.json.decode(msgspec.json.encode(entry), type=AnyEntry)
    except (msgspec.ValidationError, TypeError, ValueError) as e:
        raise EditError(f"this cannot be recorded: {e}") from e


def encode_journal(entries: Sequence[AnyEntry]) -> bytes:
    """A whole journal."""
    return b"".join(encode_line(e) for e in entries)


def _parse(path: Path, data: bytes) -> tuple[list[AnyEntry], int]:
    """The entries, and where the last whole one ends (byte)."""
    lines = data.split(b"\n")
    whole = [_body(line) for line in lines]
    last = max((i for i, body in enumerate(whole) if body is not None), default=-1)
    entries: list[AnyEntry] = []
    for i, body in enumerate(whole[: last + 1]):
        if not lines[i].strip():
            continue
        if body is None:
            remedy = "restore the file, or take the line out to go on without it"
            raise ProjectError(f"{path}:{i + 1}: this entry is damaged; {remedy}")
        try:
            entry: AnyEntry = msgspec.json.decode(body, type=AnyEntry)
        except msgspec.ValidationError as e:
            remedy = "made by a newer rgviz? then upgrade with `pip install -U rgviz`"
            raise ProjectError(f"{path}:{i + 1}: {e}; {remedy}") from e
        if entries and entry.number <= entries[-1].number:
            order = f"entry {entry.number} stands after entry {entries[-1].number}"
            raise ProjectError(f"{path}:{i + 1}: {order}; restore the file")
        entries.append(entry)
    end = sum(len(line) + 1 for line in lines[: last + 1])
    return entries, min(end, len(data))


def _body(line: bytes) -> bytes | None:
    """The bytes of the entry in a line; None if the line is torn or damaged."""
    try:
        record = msgspec.json.decode(line, type=_Line)
    except (msgspec.DecodeError, ValueError):
        return None
    body = bytes(record.entry)
    return body if record.crc == f"{zlib.crc32(body):08x}" else None


def _write(fd: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(fd, view) :]


def _set_aside(path: Path, torn: bytes) -> None:
    with open(path, "ab") as f:
        f.write(torn + b"\n")
        f.flush()
        os.fsync(f.fileno())
