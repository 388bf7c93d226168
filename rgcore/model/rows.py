"""Numbers of many records as one array, kept from one map to the next."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import compress, repeat
from operator import is_
from typing import Any, Generic, TypeVar

import numpy as np

from rgcore.model.records import Line

T = TypeVar("T")


class Rows(Generic[T]):
    """Numbers read off each record of a table, row by row; of the next map only what is new is read.

    A record that no edit touched is the same object, so a change of one line among 100,000 costs no 100,000 readings.
    """

    def __init__(self, read: Callable[[T], Any], shape: tuple[int, ...] = ()) -> None:
        self._read = read
        self._kept: tuple[Mapping[str, T], np.ndarray] = {}, np.zeros((0, *shape))

    def __call__(self, table: Mapping[str, T]) -> np.ndarray:
        """(N, ...) in the order of the table, read-only."""
        old, rows = self._kept
        if table is not old:
            rows = self._next(old, rows, table)
            self._kept = table, rows
        return rows

    def _next(self, old: Mapping[str, T], kept: np.ndarray, table: Mapping[str, T]) -> np.ndarray:
        count = len(table)
        place = dict(zip(old, range(len(old)), strict=True))
        came_from = np.fromiter(map(place.get, table, repeat(-1)), np.intp, count)
        same = np.fromiter(map(is_, table.values(), map(old.get, table)), bool, count)
        rows = np.zeros((count, *kept.shape[1:]))
        rows[same] = kept[came_from[same]]
        fresh = [self._read(v) for v in compress(table.values(), ~same)]
        if fresh:
            rows[~same] = fresh
        rows.flags.writeable = False
        return rows


_LINES: Rows[Line] = Rows(lambda v: (*v.start, *v.end, v.clutter), (5,))


def line_ends(lines: Mapping[str, Line]) -> np.ndarray:
    """(N, 2, 2) start and end of each line."""
    return _LINES(lines)[:, :4].reshape(-1, 2, 2)


def is_clutter(lines: Mapping[str, Line]) -> np.ndarray:
    """(N,) whether each line is a thing and no wall."""
    return _LINES(lines)[:, 4] > 0
