"""What becomes of an edit in the map of another run: told, and never dropped."""

from __future__ import annotations

from typing import Literal

import msgspec

from rgcore.model.edits import AnyEdit
from rgcore.model.history import Do, Settle
from rgcore.model.records import Point

Key = tuple[str, int]
"""What an edit is known by for good: the run in whose journal it was made first, and its number there."""
LEAVE: Literal["leave"] = "leave"
"""Choice: an edit that could be made shall wait instead."""


class Remedy(msgspec.Struct, frozen=True, kw_only=True):
    """What can be done about an edit that waits, by one click; ``edit`` None: let it go."""

    name: str
    edit: AnyEdit | None = None


class Outcome(msgspec.Struct, frozen=True, kw_only=True):
    """An edit after a re-run.

    kind      applied: it holds in the new map. shifted: it was made, but what it is about lies elsewhere or looks other
              than the poses say (``reason``: by how much). conflict: the new map contradicts it. stale: what it is
              about has no clear counterpart there. The last two wait for a person.
    run       the run whose journal holds ``entry``; title: its name for a person; reason: a sentence, "" for none
    place     [m] where it is in the new map, or would be; None where nobody can say
    edit      as it was made in the new run; None: not made, or nothing left to do (the new map is so already)
    remedies  what can be done about it; the last one lets it go
    """

    run: str
    entry: Do | Settle
    title: str
    kind: Literal["applied", "shifted", "conflict", "stale"] = msgspec.field(name="outcome")
    reason: str = ""
    place: Point | None = None
    edit: AnyEdit | None = None
    remedies: tuple[Remedy, ...] = ()

    @property
    def key(self) -> Key:
        return self.run, self.entry.number

    @property
    def waits(self) -> bool:
        """Whether it is for a person to decide."""
        return self.kind in ("conflict", "stale")

    def __str__(self) -> str:
        return f"{self.title}: {self.reason}" if self.reason else self.title


Choice = Remedy | Literal["leave"]
"""What a person decides about an outcome before the new run is accepted."""
