"""An edit that a new run could not take over: kept and told, never dropped."""

from __future__ import annotations

from typing import Literal

import msgspec

from rgcore.model.history import Do


class Conflict(msgspec.Struct, frozen=True, kw_only=True):
    """An edit that waits for a person.

    outcome  stale: what it is about has no clear counterpart in the new map; conflict: the new map refuses it
    run      the run whose journal holds it; reason: a sentence
    """

    run: str
    entry: Do
    title: str
    outcome: Literal["stale", "conflict"]
    reason: str

    def __str__(self) -> str:
        return f"{self.title}: {self.reason}"
