"""What adaptation tried and chose, as it is kept in a run (:mod:`rgcore.lines.adapt` makes it)."""

from __future__ import annotations

import msgspec

from rgcore.config import Lines as LineSettings

PARAMETERS = ("distance", "gap", "ratio", "price")
"""Settings of merging that adapt themselves."""


class Curve(msgspec.Struct, frozen=True, kw_only=True):
    """What the tried settings, taken for all regions alike, give in a region or in the whole finished map, in order.

    lines     number of lines
    accuracy  m, root mean square difference of the readings of what is there, none above the penalty
    scans     how many scans saw the region
    chosen    index of the setting that was taken; of the map: the best single setting for all regions
    """

    lines: tuple[int, ...]
    accuracy: tuple[float, ...]
    scans: int
    chosen: int


class Adaptation(msgspec.Struct, frozen=True, kw_only=True):
    """What was tried, what came of it, and what each region takes.

    tried    parameters of merging, the configured ones first
    map      lines and accuracy of the whole map
    regions  one a region, in their order, and a last one for the lines of no region
    price    readings a line, the knob
    goal     m, acc(R) above which a region takes a lower price, where that helps
    """

    tried: tuple[dict[str, float], ...]
    map: Curve
    regions: tuple[Curve, ...]
    price: float
    goal: float = 0.0

    def settings(self, lines: LineSettings) -> tuple[LineSettings, ...]:
        """Settings by region for :func:`rgcore.lines.merge.merge_lines` and `rgcore.lines.complete.complete_lines`."""
        return tuple(msgspec.structs.replace(lines, **self.tried[r.chosen]) for r in self.regions)
