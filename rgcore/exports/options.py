"""What one may ask of an export."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Options:
    """``wall_height`` [m]: how high lines are extruded in formats that have a height."""

    wall_height: float = 2.5
