"""How a long computation tells what it is doing: values handed to a watcher, never printed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Progress:
    """A stage has done ``done`` of ``total`` units; ``partial`` is what there is to show so far, if anything.

    Partial results by stage: "slam": map_from_laser (k, 3) of the scans so far; "lines": Lines; "places": Places.
    """

    stage: str
    done: int
    total: int
    partial: Any = None


Watcher = Callable[[Progress], None]
"""Called from the computing thread; it may raise to cancel the run."""


def silent(progress: Progress) -> None:
    """The watcher that looks away."""
