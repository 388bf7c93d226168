"""What becomes of edits, by kind: the colours of list and map, and what comes first."""

from __future__ import annotations

from collections.abc import Sequence

from rgcore.model.outcome import Outcome
from rgviz import theme
from rgviz.theme import RGB

KIND_COLORS: dict[str, RGB] = {
    "conflict": theme.REMOVED,
    "stale": theme.STALE,
    "shifted": theme.SHIFTED,
    "applied": theme.ADDED,
}
"""In the order in which they want attention; white can be read on all but the last."""


def by_need(outcomes: Sequence[Outcome]) -> list[Outcome]:
    """Those first that want a person's attention."""
    kinds = list(KIND_COLORS)
    return sorted(outcomes, key=lambda o: kinds.index(o.kind))
