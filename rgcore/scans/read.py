"""Reading a log: the content decides the reader, never the name.

To add a format, write a module with ``sniff(source) -> bool`` and ``read(source) -> ScanLog`` and add a row to
``READERS``. Bags are asked first: they may be folders, and too large to be held whole.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from rgcore.scans import bags, carmen, grid_map, tables, wean
from rgcore.scans.bags import USUAL, Topics
from rgcore.scans.log import ScanLog
from rgcore.scans.source import Source, open_source


class Reader(NamedTuple):
    """One log format: ``sniff`` says whether a file looks like it, ``read`` reads it."""

    name: str
    sniff: Callable[[Source], bool]
    read: Callable[[Source], ScanLog]


READERS: tuple[Reader, ...] = (
    Reader("NPZ", tables.sniff_npz, tables.read_npz),
    Reader("CARMEN", carmen.sniff, carmen.read),
    Reader("Wean Hall L/O", wean.sniff, wean.read),
    Reader("CSV", tables.sniff_csv, tables.read_csv),
)
"""Asked in this order; the first that knows the file reads it."""


def read_log(path: str | Path, topics: Topics = USUAL) -> ScanLog:
    """All scans of a log: a ROS bag, a grid map, or a file, plain or gzipped, of any format in ``READERS``.

    topics: which topics of a bag to read. Raises InputError, one line with file and, where there is one, line number.
    """
    path = Path(path)
    if bags.is_bag(path):
        return bags.read(path, topics)
    if grid_map.is_grid_map(path):
        return grid_map.read(path)
    source = open_source(path)
    for reader in READERS:
        if reader.sniff(source):
            return reader.read(source)
    known = ", ".join(["ROS bag", "grid map (.yaml)", *(reader.name for reader in READERS)])
    what = "a binary file" if b"\0" in source.data[:4096] else "a text file"
    raise source.error(f"{what} of no known log format; known are: {known}")
