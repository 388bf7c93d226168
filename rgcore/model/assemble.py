"""From evidence to the document: what the stages found becomes records with ids and names."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np

from rgcore import __version__
from rgcore.config import Config, changed
from rgcore.lines.accuracy import Accuracy
from rgcore.lines.merge import Lines
from rgcore.model.records import (
    REGION_CLASSES,
    Box2,
    Gateway,
    Line,
    MapObject,
    Point,
    Region,
    RGMap,
    Source,
    Stats,
    rounded,
)
from rgcore.places.classify import Classes
from rgcore.places.objects import FoundObject
from rgcore.places.places import Places
from rgcore.scans.extract import Segments
from rgcore.scans.log import ScanLog

FEW = 3
"""Sightings: a line seen less often from a region is chance (a badly matched scan, a glimpse) and not listed there."""

NAMES = {"CDMA": "Hallway", "ODMA": "Hallway", "TOMA": "Room", "CC": "Cluttered room"}


def assemble(
    log: ScanLog,
    config: Config,
    segments: Segments,
    places: Places,
    lines: Lines,
    line_of: np.ndarray,
    accuracy: Accuracy,
    classes: Classes,
    objects: Sequence[FoundObject],
    scan_regions: np.ndarray,
) -> RGMap:
    """The map. Ids number by first-seen order, so the same log and settings give the same map.

    line_of (M,): line of each segment, -1 = none. scan_regions (N,): region that each scan was taken in, -1 = none.
    """
    seen = _sightings(segments, line_of, scan_regions, len(lines), len(places.regions))
    acc = accuracy.of(np.arange(len(log)))
    taken = np.full_like(scan_regions, -1) if log.surveyed else scan_regions
    return RGMap(
        source=Source(
            log=log.source,
            sha256=log.sha256,
            format=log.format,
            settings=changed(config),
            software=f"rgviz {__version__}",
        ),
        stats=Stats(
            scans=0 if log.surveyed else len(log),
            points=0 if log.surveyed else int(log.usable(config.slam.max_range).sum()),
            segments=len(segments),
            accuracy=None if acc is None else rounded(acc),
            accuracy_penalty=config.accuracy.penalty,
        ),
        lines=_by_id(_line(lines, i, seen[i]) for i in range(len(lines))),
        regions=_by_id(_regions(places, classes, accuracy, taken)),
        gateways=_by_id(_gateways(places)),
        objects=_by_id(_objects(objects)),
    )


def _sightings(
    segments: Segments, line_of: np.ndarray, scan_regions: np.ndarray, lines: int, regions: int
) -> np.ndarray:
    """(L, R) how many segments of a line were seen from a region."""
    where = scan_regions[segments.scan]
    ok = (line_of >= 0) & (where >= 0)
    count = np.zeros((lines, regions), np.int64)
    np.add.at(count, (line_of[ok], where[ok]), 1)
    return count


def _line(lines: Lines, i: int, seen: np.ndarray) -> Line:
    home = int(lines.region[i])
    others = [int(r) for r in np.argsort(-seen, kind="stable") if seen[r] >= FEW and r != home]
    rms = float(lines.rms[i])
    return Line(
        id=f"l{i + 1}",
        start=_point(lines.ends[i, 0]),
        end=_point(lines.ends[i, 1]),
        regions=tuple(f"r{r + 1}" for r in ([home] if home >= 0 else []) + others),
        support=int(lines.support[i]),
        residual=rounded(rms) if math.isfinite(rms) else None,
        deviation=_deviation(lines.covariance[i]),
    )


def _deviation(covariance: np.ndarray) -> Point | None:
    """Across [m] and of the direction [rad]; None where nothing tells."""
    return _point(np.sqrt(covariance[[0, 2]])) if covariance[0] > 0 else None


def _regions(places: Places, classes: Classes, accuracy: Accuracy, scan_regions: np.ndarray) -> Iterable[Region]:
    number: Counter[str] = Counter()
    for i, found in enumerate(places.regions):
        here = scan_regions == i
        acc = accuracy.of(here)
        class_ = REGION_CLASSES[int(np.argmax(classes.scores[i]))]
        number[NAMES[class_]] += 1
        yield Region(
            id=f"r{i + 1}",
            name=f"{NAMES[class_]} {number[NAMES[class_]]}",
            class_=class_,
            class_scores={c: rounded(s) for c, s in zip(REGION_CLASSES, classes.scores[i], strict=True)},
            boundary=_points(found.boundary),
            holes=tuple(_points(h) for h in found.holes),
            box=Box2(center=_point(found.box_center), size=_point(found.box_size), yaw=rounded(found.box_yaw)),
            axes=tuple(_axis(a) for a in classes.axes[i] if np.isfinite(a)),
            accuracy=None if acc is None else rounded(acc),
            scans=int(here.sum()),
        )


def _gateways(places: Places) -> Iterable[Gateway]:
    for i, g in enumerate(places.gateways):
        yield Gateway(
            id=f"g{i + 1}",
            class_=g.class_,
            confidence=rounded(g.confidence),
            regions=tuple(f"r{r + 1}" for r in g.regions),
            posts=(_point(g.posts[0]), _point(g.posts[1])),
            crossing_points=_points(g.crossing_points),
            gateway_points=_points(g.gateway_points),
            traversal_directions=tuple(rounded(a) for a in g.traversal_directions),
            passed=bool(g.passed),
        )


def _objects(objects: Sequence[FoundObject]) -> Iterable[MapObject]:
    for i, o in enumerate(objects):
        x, y, z = o.center
        along, across, height = o.size
        yield MapObject(
            id=f"o{i + 1}",
            label=o.label,
            center=(rounded(x), rounded(y), rounded(z)),
            size=(rounded(along), rounded(across), rounded(height)),
            yaw=rounded(o.yaw),
            lines=tuple(f"l{k + 1}" for k in o.lines),
            region=f"r{o.region + 1}" if o.region >= 0 else None,
            confidence=rounded(o.confidence),
        )


def _by_id(records: Iterable) -> dict:
    return {r.id: r for r in records}


def _point(p: Sequence[float] | np.ndarray) -> Point:
    return rounded(p[0]), rounded(p[1])


def _points(points: Iterable[Sequence[float]]) -> tuple[Point, ...]:
    return tuple(_point(p) for p in points)


def _axis(angle: float) -> float:
    """An axis [rad] in [0, pi), also after rounding."""
    a = rounded(float(angle) % math.pi)
    return a if a < math.pi else 0.0
