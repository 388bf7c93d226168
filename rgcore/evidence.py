"""Evidence: frozen structs of arrays, read-only from birth, that select and save alike.

Everything that was *measured or computed* (scans, segments, poses, lines) is an ``Evidence``; everything that a
person may *correct* is a record (``rgcore.model.records``).
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

E = TypeVar("E", bound="Evidence")


@dataclass(frozen=True, eq=False)
class Evidence:
    """Base of the array structs.

    Subclasses are frozen dataclasses. Fields annotated ``np.ndarray`` share their first axis, unless they are named in
    ``whole`` (arrays that belong to the struct as a whole, such as the bearings of all scans).
    """

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            if isinstance(value, np.ndarray):
                value = value.view()
                value.flags.writeable = False
                object.__setattr__(self, f.name, value)

    @classmethod
    def whole(cls) -> frozenset[str]:
        """Names of the array fields that indexing leaves as they are."""
        return frozenset()

    def _rows(self) -> list[str]:
        return [
            f.name for f in fields(self) if f.name not in self.whole() and isinstance(getattr(self, f.name), np.ndarray)
        ]

    def __len__(self) -> int:
        return len(getattr(self, self._rows()[0]))

    def __getitem__(self: E, keep: Any) -> E:
        """The same type with the rows that ``keep`` (mask, indices or slice) selects."""
        rows = set(self._rows())
        return type(self)(
            **{f.name: getattr(self, f.name)[keep] if f.name in rows else getattr(self, f.name) for f in fields(self)}
        )

    def save(self, path: str | Path) -> None:
        """Write an ``.npz`` that :meth:`load` reads back; strings and numbers are kept as 0-d arrays."""
        np.savez_compressed(
            path, **{f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name) is not None}
        )

    @classmethod
    def load(cls: type[E], path: str | Path) -> E:
        """Read what :meth:`save` wrote. Raises OSError, ValueError or KeyError if the file is not that."""
        with np.load(path, allow_pickle=False) as data:
            return cls(**{k: (v.item() if v.ndim == 0 else v) for k, v in data.items()})
