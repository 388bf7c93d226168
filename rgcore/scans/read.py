"""Reading a log: the content decides the reader, never the name.

To add a format, write a module with ``sniff(source) -> bool`` and ``read(source) -> ScanLog`` and add a row to
``READERS``.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from rgcore.scans import carmen, wean
from rgcore.scans.log import ScanLog
from rgcore.scans.source import Source, open_source


class Reader(NamedTuple):
    """One log format: ``sniff`` says whether a file looks like it, ``read`` reads it."""

    name: str
    sniff: Callable[[Source], bool]
    read: Callable[[Source], ScanLog]


READERS: tuple[Reader, ...] = (
    Reader("CARMEN", carmen.sniff, carmen.read),
    Reader("Wean Hall L/O", wean.sniff, wean.read),
)
"""Asked in this order; the first that knows the file reads it."""


def read_log(path: str | Path) -> ScanLog:
    """All scans of a log file, plain or gzipped, of any format in ``READERS``.

    Raises InputError, one line with file and, where there is one, line number.
    """
    source = open_source(path)
    for reader in READERS:
        if reader.sniff(source):
            return reader.read(source)
    known = ", ".join(reader.name for reader in READERS)
    what = "a binary file" if b"\0" in source.data[:4096] else "a text file"
    raise source.error(f"{what} of no known log format; known are: {known}")
