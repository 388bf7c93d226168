"""Object hypotheses: groups of lines inside a room that may be one thing (paper, section III).

The lines of a room suggest boxes (:mod:`rgcore.places.boxes`): cabinets at its walls, free-standing boxes. Each is
judged by what is seen of its sides and by whether beams went through it; where boxes share lines or overlap, the surest
stays.
"""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path

import msgspec
import numpy as np

from rgcore.config import Objects as Settings
from rgcore.lines.merge import Lines
from rgcore.places.boxes import Boxes, boxes_on, features
from rgcore.places.divide import free_mask
from rgcore.places.freespace import FreeSpace
from rgcore.places.network import Network
from rgcore.places.places import Places
from rgcore.places.tables import LEG, find_legs, tables_on

BOXES, TABLES = (Path(__file__).with_name(f"{kind}.npz") for kind in ("objects", "tables"))
"""Made by ``python -m rgcore.places.train_objects``."""

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
    mask = free_mask(free)
    believed: list[_Box] = []
    for region in range(len(places.regions)):
        own, near = near_lines(lines, region)
        boxes = boxes_on(lines.ends[own], lines.ends[near], free.grid(mask), settings)
        if boxes is not None:
            sure = confidence_of(boxes)
            above = np.nonzero(sure >= settings.min_confidence)[0].tolist()
            believed += [_Box.of(boxes, k, own, region, float(sure[k])) for k in above]
    believed += _tables(lines, places, free, mask, settings)
    return tuple(_found(b, settings) for b in _surest(believed))


def near_lines(lines: Lines, region: int) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the lines of a region, and of those of other regions that run near them."""
    own = np.nonzero(lines.region == region)[0]
    if len(own) == 0:
        return own, own
    low, high = lines.ends[own].min((0, 1)), lines.ends[own].max((0, 1))
    near = ((lines.ends.max(1) > low - 1) & (lines.ends.min(1) < high + 1)).all(1) & (lines.region != region)
    return own, np.nonzero(near)[0]


def confidence_of(boxes: Boxes) -> np.ndarray:
    """How likely each box (K,) is a thing: a network trained on surveys of random furnished floors."""
    return network(BOXES).probabilities(features(boxes))[:, 1]


@lru_cache(maxsize=2)
def network(weights: Path) -> Network:
    """A shipped network."""
    return Network.load(weights)


def _tables(lines: Lines, places: Places, free: FreeSpace, mask: np.ndarray, settings: Settings) -> list[_Box]:
    legs = find_legs(free, mask)
    tables = tables_on(legs, free, mask, settings)
    if len(tables) == 0:
        return []
    sure = network(TABLES).probabilities(tables.features)[:, 1]
    short = np.nonzero(np.hypot(*(lines.ends[:, 1] - lines.ends[:, 0]).T) < 2 * LEG)[0]
    leg_of = np.hypot(*(lines.ends[short].mean(1)[:, None] - legs.middle[None]).transpose(2, 0, 1))
    home = places.labels.at(legs.middle, outside=-1)
    out = []
    for k in np.nonzero(sure >= settings.min_confidence)[0].tolist():
        its = leg_of[:, tables.legs[k]]
        region = int(places.labels.at(tables.corners[k].mean(0), outside=-1))
        region = region if region >= 0 else int(home[tables.legs[k]].max())
        out.append(_Box.around(tables.corners[k], short[its.min(1) < LEG], tables.legs[k], region, float(sure[k])))
    return out


class _Box:
    """One hypothesis that others may contradict; ``uses``: lines and legs that only one thing can have."""

    def __init__(self, label: str, origin: np.ndarray, axes: np.ndarray, size: np.ndarray, confidence: float) -> None:
        self.label, self.origin, self.axes, self.size, self.confidence = label, origin, axes, size, confidence
        self.center = (origin + size @ axes / 2).tolist()
        self.radius = math.hypot(*size) / 2
        self.lines: frozenset[int] = frozenset()
        self.legs: frozenset[int] = frozenset()
        self.region = -1

    @classmethod
    def of(cls, boxes: Boxes, k: int, index: np.ndarray, region: int, confidence: float) -> _Box:
        """Box ``k`` of those of a region whose lines are ``index`` (L,)."""
        width, depth = boxes.size[k]
        long = np.array([width, depth, width, depth]) >= 0.6 * max(width, depth)
        at_wall = bool(np.any(long & (boxes.wall[k] > 0.5) & (boxes.face[k] < 0.5)))
        axes = np.stack([boxes.u[k], boxes.down[k]])
        box = cls("cabinet" if at_wall else "box", boxes.origin[k], axes, boxes.size[k], confidence)
        box.lines, box.region = frozenset(index[boxes.members[k]].tolist()), region
        return box

    @classmethod
    def around(cls, corners: np.ndarray, lines: np.ndarray, legs: np.ndarray, region: int, confidence: float) -> _Box:
        """A table whose legs stand at ``corners`` (4, 2)."""
        side, back = (corners[[1, 2]] - corners[[0, 3]]).mean(0), (corners[[2, 3]] - corners[[1, 0]]).mean(0)
        u = side / np.hypot(*side)
        axes = np.stack([u, [-u[1], u[0]]])
        size = np.array([np.hypot(*side), np.hypot(*back)])
        box = cls("table", corners.mean(0) - size @ axes / 2, axes, size, confidence)
        box.lines, box.legs, box.region = frozenset(lines.tolist()), frozenset(legs.tolist()), region
        return box

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
    stood: set[int] = set()
    for box in sorted(boxes, key=lambda b: -b.confidence):
        near = (c for c in chosen if math.dist(c.center, box.center) < c.radius + box.radius)
        if not used & box.lines and not stood & box.legs and not any(box.overlaps(c) for c in near):
            used |= box.lines
            stood |= box.legs
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
