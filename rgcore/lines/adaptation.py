"""What adaptation tried and chose, as it is kept in a run (:mod:`rgcore.lines.adapt` makes it)."""

from __future__ import annotations

import msgspec

from rgcore.config import Lines as LineSettings

PARAMETERS = ("distance", "gap", "ratio", "min_length", "min_support")
"""Settings of merging that adapt themselves."""


class Curve(msgspec.Struct, frozen=True, kw_only=True):
    """What the tried settings give in a region or in the whole map, in their order.

    lines     number of lines
    accuracy  m, acc over the scans that see the region, all other regions being as configured
    scans     how many scans those are
    chosen    index of the setting that was taken; of the map: the best single setting for all regions
    """

    lines: tuple[int, ...]
    accuracy: tuple[float, ...]
    scans: int
    chosen: int


class Adaptation(msgspec.Struct, frozen=True, kw_only=True):
    """What was tried, what came of it, and what each region takes.

    tried    parameters of merging, the configured ones first
    map      lines and accuracy if all regions took a setting
    regions  one a region, in their order, and a last one for the lines of no region
    price    scans a line, the knob
    """

    tried: tuple[dict[str, float], ...]
    map: Curve
    regions: tuple[Curve, ...]
    price: float

    def settings(self, lines: LineSettings) -> tuple[LineSettings, ...]:
        """Settings by region for :func:`rgcore.lines.merge.merge_lines`."""
        return tuple(msgspec.structs.replace(lines, **self.tried[r.chosen]) for r in self.regions)
