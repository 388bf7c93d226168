"""Object hypotheses: groups of lines inside a room that may be one thing (paper, section III).

The lines of a room suggest boxes (:mod:`rgcore.places.boxes`): cabinets at its walls, free-standing boxes. Each is
judged by what is seen of its sides and by whether beams went through it; where boxes share lines or overlap, the surest
stays.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np

from rgcore.config import Objects as Settings
from rgcore.lines.merge import Lines
from rgcore.places.boxes import BACK, FRONT, LEFT, RIGHT, Boxes, boxes_on
from rgcore.places.divide import free_mask
from rgcore.places.freespace import FreeSpace
from rgcore.places.places import Places

Point3 = tuple[float, float, float]


class FoundObject(msgspec.Struct, frozen=True, kw_only=True):
    """A box over a group of lines: ``size`` along ``yaw``, across it, and up; ``lines`` and ``region`` are indices."""

    label: str
    center: Point3
    size: Point3
    yaw: float
    lines: tuple[int, ...]
    region: int
    confidence: float


def find_objects(lines: Lines, places: Places, free: FreeSpace, settings: Settings) -> tuple[FoundObject, ...]:
    """Object hypotheses of all regions, the surest first within a region."""
    mask = free.grid(free_mask(free))
    believed: list[_Box] = []
    for region in range(len(places.regions)):
        own = np.nonzero(lines.region == region)[0]
        if len(own) < 2:
            continue
        low, high = lines.ends[own].min((0, 1)), lines.ends[own].max((0, 1))
        near = ((lines.ends.max(1) > low - 1) & (lines.ends.min(1) < high + 1)).all(1) & (lines.region != region)
        boxes = boxes_on(lines.ends[own], lines.ends[near], mask, settings)
        if boxes is not None:
            sure = confidence_of(boxes)
            above = np.nonzero(sure >= settings.min_confidence)[0].tolist()
            believed += [_Box(boxes, k, own, region, float(sure[k])) for k in above]
    return tuple(_found(b, settings) for b in _surest(believed))


def confidence_of(boxes: Boxes) -> np.ndarray:
    """How likely each box (K,) is a thing.

    A logistic model: weights from a regression over boxes in four simulated furnished buildings, rounded; those of
    ``clear``, ``beyond`` and ``foreign`` are set stronger by hand: those buildings hardly have walls that end free.

    Beams through the inside speak against it, and so do sides that are neither seen nor hidden; a side across the
    front that is seen speaks most for it.
    """
    seen = np.maximum(boxes.face, boxes.edge)
    sides, others = [RIGHT, LEFT], [RIGHT, BACK, LEFT]
    hidden = (1 - boxes.open) * (1 - boxes.wall) * (1 - seen)
    clear = boxes.open * (1 - seen)
    wall = boxes.wall * (1 - seen)
    score = (
        -9.0
        + 3.5 * boxes.solid
        + 1.0 * boxes.face[:, FRONT]
        + 1.5 * seen[:, sides].sum(1)
        + 2.5 * seen[:, sides].max(1)
        + 1.0 * boxes.face[:, others].sum(1)
        + 0.3 * wall[:, sides].sum(1)
        + 0.9 * hidden[:, sides].sum(1)
        + 1.1 * seen[:, BACK]
        + 0.4 * wall[:, BACK]
        - 0.4 * clear[:, others].sum(1)
        - 1.0 * np.minimum(boxes.beyond, 1).sum(1)
        - 3.0 * np.minimum(boxes.inside, 1)
        - 3.0 * boxes.foreign
        + 1.3 * np.minimum(boxes.size.min(1), 0.4)
    )
    return np.asarray(1 / (1 + np.exp(-score)))


class _Box:
    """One box of those of a region whose lines are ``index`` (L,)."""

    def __init__(self, boxes: Boxes, k: int, index: np.ndarray, region: int, confidence: float) -> None:
        self.size, self.origin = boxes.size[k], boxes.origin[k]
        self.axes = np.stack([boxes.u[k], boxes.down[k]])
        self.center = (self.origin + self.size @ self.axes / 2).tolist()
        self.radius = math.hypot(*self.size) / 2
        self.lines = frozenset(index[boxes.members[k]].tolist())
        self.region, self.confidence = region, confidence
        self.label = "cabinet" if boxes.wall[k, BACK] > 0.5 and boxes.face[k, BACK] < 0.5 else "box"

    def overlaps(self, other: _Box) -> bool:
        """Whether more than the part OVERLAP of the smaller one lies in the larger one."""
        small, large = (self, other) if self.size.prod() < other.size.prod() else (other, self)
        local = (small.origin + _SPREAD * small.size @ small.axes - large.origin) @ large.axes.T
        return bool(np.all((local > 0) & (local < large.size), axis=1).mean() > OVERLAP)


OVERLAP = 0.3
"""Boxes that share more than this part of the smaller one are not both there."""

_SPREAD = (np.stack(np.meshgrid(np.arange(8), np.arange(8)), -1).reshape(-1, 2) + 0.5) / 8


def _surest(boxes: list[_Box]) -> list[_Box]:
    """The surest first, none that overlaps or shares a line with a surer one."""
    chosen: list[_Box] = []
    used: set[int] = set()
    for box in sorted(boxes, key=lambda b: -b.confidence):
        near = (c for c in chosen if math.dist(c.center, box.center) < c.radius + box.radius)
        if not used & box.lines and not any(box.overlaps(c) for c in near):
            used |= box.lines
            chosen.append(box)
    return sorted(chosen, key=lambda b: b.region)


def _found(box: _Box, settings: Settings) -> FoundObject:
    (x, y), (width, depth), (ux, uy) = box.center, box.size, box.axes[0]
    return FoundObject(
        label=box.label,
        center=(round(x, 4), round(y, 4), round(settings.height / 2, 4)),
        size=(round(float(width), 4), round(float(depth), 4), settings.height),
        yaw=round(float(np.arctan2(uy, ux)), 4),
        lines=tuple(sorted(box.lines)),
        region=box.region,
        confidence=round(box.confidence, 3),
    )
