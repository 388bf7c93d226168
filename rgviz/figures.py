"""What the evidence that a run keeps says of a single item: measured when somebody asks, for the map as it stands."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from rgcore.exports.report import Fit, differences, fit
from rgcore.geometry.polygons import locate, polygon
from rgcore.lines.adaptation import Adaptation, Curve
from rgcore.model.folder import KeptSegments
from rgcore.model.project import Project
from rgcore.model.records import Line, Point, Region

BESIDE = 0.1
"""m: a segment with both ends no farther than this from a line was merged into it, or could have been"""


class Figures:
    """Of one open project and its current run; the files of the run are read once, when they are first wanted."""

    def __init__(self, project: Project) -> None:
        self.project = project

    def fit(self, region: Region) -> Fit | None:
        """How the lines of the map predict the readings of the scans taken in a region; None without such scans."""
        kept = self._segments
        if kept is None:
            return None
        places = self.project.trajectory.map_from_base[kept.sample][:, :2]
        inside = locate([polygon(region.boundary, region.holes)], places) == 0
        if not inside.any():
            return None
        here = kept._replace(sample=kept.sample[inside], ranges=kept.ranges[inside])
        return fit(differences(self.project, here)[0], self.project.map)

    def scans_of(self, line: Line) -> int | None:
        """Number of scans with a segment along a line; None where the run keeps no segments."""
        kept = self._segments
        if kept is None:
            return None
        along, off = _beside(kept.ends, line.start, line.end)
        length = float(np.hypot(line.end[0] - line.start[0], line.end[1] - line.start[1]))
        near = (np.abs(off) <= BESIDE).all(1) & (along.max(1) > 0) & (along.min(1) < length)
        return len(np.unique(kept.scan[near]))

    def curve(self, region: str) -> Curve | None:
        """Lines and accuracy that each tried setting gives in a region of the mapper's own."""
        fitted, order = self._adaptation, _numbered(self.project.base.regions)
        if fitted is None or region not in order or order[region] >= len(fitted.regions) - 1:
            return None
        return fitted.regions[order[region]]

    def map_curve(self) -> Curve | None:
        """The same of the whole map, a setting for all regions alike."""
        return None if self._adaptation is None else self._adaptation.map

    @cached_property
    def _segments(self) -> KeptSegments | None:
        return self.project.segments

    @cached_property
    def _adaptation(self) -> Adaptation | None:
        return self.project.adaptation


def _numbered(regions: Sequence[str] | dict[str, Region]) -> dict[str, int]:
    """Index of each region of the mapper by its id: ``r1`` was the first."""
    return {id: int(id[1:]) - 1 for id in regions if id[1:].isdigit()}


def _beside(ends: np.ndarray, a: Point, b: Point) -> tuple[np.ndarray, np.ndarray]:
    """(M, 2) m along the line from ``a`` to ``b`` and m to its left, of the ends (M, 2, 2) of segments."""
    d = np.subtract(b, a) / max(float(np.hypot(b[0] - a[0], b[1] - a[1])), 1e-9)
    off = ends - np.asarray(a)
    return off @ d, off @ np.array([-d[1], d[0]])
