"""Regions like those that a person gave a class of their own: proposals, each an edit to accept or to leave."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rgcore.errors import EditError
from rgcore.model.edits_regions import ClassifyRegion
from rgcore.model.records import REGION_CLASSES, Region, RGMap
from rgcore.places.learn import FEWEST, features, learn
from rgcore.places.places import FoundRegion

LIKELY = 0.5
"""Regions of a lower score are not proposed."""


@dataclass(frozen=True)
class Proposal:
    """A region that is probably of the class, how likely, and the edit that says so."""

    region: str
    score: float
    edit: ClassifyRegion


def own_classes(map: RGMap) -> dict[str, int]:
    """Classes that people gave, beside those of the paper, and how many regions have each; the most used first."""
    count = Counter(r.class_ for r in map.regions.values() if r.class_ not in REGION_CLASSES)
    return dict(count.most_common())


def propose(map: RGMap, class_: str, others: Sequence[RGMap] = ()) -> list[Proposal]:
    """Regions of the map that are like those a person gave a class, in this map or in ``others``; the likeliest first.

    Regions to which a person gave a class, or that one confirmed, are examples of what they are and never proposed.
    Raises EditError where there are too few examples, with how to give them.
    """
    known: list[np.ndarray] = []
    against: list[np.ndarray] = []
    open_: list[tuple[str, np.ndarray]] = []
    for m in (map, *others):
        for region in m.regions.values():
            x = describe(m, region)
            if _said(region):
                (known if region.class_ == class_ else against).append(x)
            elif m is map:
                open_.append((region.id, x))
    if len(known) < FEWEST:
        raise EditError(f"{len(known)} regions are classed {class_!r}; give that class to at least {FEWEST} by hand")
    if not open_:
        return []
    at = np.array([x for _, x in open_])
    scores = learn(np.array(known), np.concatenate([np.array(against).reshape(-1, at.shape[1]), at])).scores(at)
    found = [
        Proposal(id, round(float(s), 3), ClassifyRegion(region=id, class_=class_))
        for (id, _), s in zip(open_, scores, strict=True)
        if s >= LIKELY
    ]
    return sorted(found, key=lambda p: -p.score)


def describe(map: RGMap, region: Region) -> np.ndarray:
    """What a region is compared by, from the corrected map."""
    found = FoundRegion(
        boundary=region.boundary,
        holes=region.holes,
        box_center=region.box.center,
        box_size=region.box.size,
        box_yaw=region.box.yaw,
        first_scan=-1,
    )
    posts = [map.gateways[g].posts for g in map.gateways_of(region.id)]
    own = [(v.start, v.end) for v in map.lines.values() if v.regions[:1] == (region.id,)]
    labels = [map.objects[o].label for o in map.objects_of(region.id)]
    tables = labels.count("table")
    hall, cluttered = (sum(region.class_scores.get(c, 0.25) for c in k) for k in (("CDMA", "ODMA"), ("CC",)))
    return features(
        found, posts, np.array(own, float).reshape(-1, 2, 2), (tables, len(labels) - tables), (hall, cluttered)
    )


def _said(region: Region) -> bool:
    """Whether a person said what the region is: a class that the mapper did not give, or one that is confirmed."""
    ranked = max(region.class_scores, key=region.class_scores.__getitem__, default=None)
    return (
        region.class_ not in REGION_CLASSES or region.provenance.confirmed or region.class_ != (ranked or region.class_)
    )
