"""Object hypotheses: groups of lines inside a room that may be one thing (paper, section III).

The lines of a room suggest boxes (:mod:`rgcore.places.boxes`): cabinets at its walls, free-standing boxes. Each is
judged by what is seen of its sides and by whether beams went through it; where boxes share lines or overlap, the surest
stays.
"""

from __future__ import annotations

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
    found: list[FoundObject] = []
    mask = free.grid(free_mask(free))
    for region in range(len(places.regions)):
        own = np.nonzero(lines.region == region)[0]
        boxes = boxes_on(lines.ends[own], mask, settings) if len(own) >= 2 else None
        if boxes is not None:
            found += _best(boxes, own, region, settings)
    return tuple(found)


def confidence_of(boxes: Boxes) -> np.ndarray:
    """How likely each box (K,) is a thing, by logistic regression over boxes in known buildings.

    Beams through the inside speak against it, and so do sides that are neither seen nor hidden; a side across the
    front that is seen speaks most for it.
    """
    seen = np.maximum(boxes.face, boxes.edge)
    sides, others = [RIGHT, LEFT], [RIGHT, BACK, LEFT]
    hidden = (1 - boxes.open) * (1 - boxes.wall) * (1 - seen)
    clear = boxes.open * (1 - seen)
    wall = boxes.wall * (1 - seen)
    score = (
        -11.5
        + 4.2 * boxes.solid
        + 1.6 * boxes.face[:, FRONT]
        + 1.8 * seen[:, sides].sum(1)
        + 3.3 * seen[:, sides].max(1)
        + 0.9 * boxes.face[:, others].sum(1)
        + 0.3 * wall[:, sides].sum(1)
        + 1.3 * hidden[:, sides].sum(1)
        + 1.1 * seen[:, BACK]
        + 0.3 * wall[:, BACK]
        - 0.6 * clear[:, others].sum(1)
    )
    return np.asarray(1 / (1 + np.exp(-score)))


def _best(boxes: Boxes, index: np.ndarray, region: int, settings: Settings) -> list[FoundObject]:
    """The boxes to believe: the surest first, none that overlaps or shares a line with a surer one."""
    confidence = confidence_of(boxes)
    order = np.argsort(-confidence, kind="stable")
    used = np.zeros(boxes.members.shape[1], bool)
    chosen: list[int] = []
    for k in order[confidence[order] >= settings.min_confidence]:
        if not (used & boxes.members[k]).any() and not _overlaps(boxes, int(k), chosen):
            used |= boxes.members[k]
            chosen.append(int(k))
    return [_found(boxes, k, float(confidence[k]), index, region, settings) for k in chosen]


def _found(boxes: Boxes, k: int, confidence: float, index: np.ndarray, region: int, settings: Settings) -> FoundObject:
    (x, y), (width, depth), (ux, uy) = boxes.center[k], boxes.size[k], boxes.u[k]
    at_wall = boxes.wall[k, 1:].max() > 0.5 and boxes.face[k, BACK] < 0.5
    return FoundObject(
        label="cabinet" if at_wall else "box",
        center=(round(float(x), 4), round(float(y), 4), round(settings.height / 2, 4)),
        size=(round(float(width), 4), round(float(depth), 4), settings.height),
        yaw=round(float(np.arctan2(uy, ux)), 4),
        lines=tuple(int(index[m]) for m in np.nonzero(boxes.members[k])[0]),
        region=region,
        confidence=round(confidence, 3),
    )


OVERLAP = 0.3
"""Boxes that share more than this part of the smaller one are not both there."""

_SPREAD = (np.stack(np.meshgrid(np.arange(8), np.arange(8)), -1).reshape(-1, 2) + 0.5) / 8


def _overlaps(boxes: Boxes, k: int, others: list[int]) -> bool:
    """Whether a box overlaps one of the others."""
    axes = np.stack([boxes.u, boxes.down], 1)
    for o in others:
        small, large = (k, o) if boxes.size[k].prod() < boxes.size[o].prod() else (o, k)
        points = boxes.origin[small] + _SPREAD * boxes.size[small] @ axes[small]
        local = (points - boxes.origin[large]) @ axes[large].T
        if np.all((local > 0) & (local < boxes.size[large]), axis=1).mean() > OVERLAP:
            return True
    return False
