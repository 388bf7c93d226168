"""Edits of regions: what they are called, and where they begin and end."""

from __future__ import annotations

import math

import msgspec
import numpy as np

from rgcore.errors import EditError
from rgcore.geometry import cutting
from rgcore.model.edit import Edit, drop, must_be_new, put, put_all, several, the_region
from rgcore.model.fields import (
    ClassName,
    Name,
    NewGatewayId,
    NewRegionId,
    Path,
    RegionId,
    Ring,
    Rings,
    SomeRegions,
    Text,
)
from rgcore.model.gates import LEAST_WIDTH, directions, gateway_points, middle
from rgcore.model.ground import LEAST_REGION, checked_rings, claim, free_name, reshaped, settle, shape_of
from rgcore.model.records import Box2, Gateway, Point, Region, RGMap, replace, rounded


class ClassifyRegion(Edit, frozen=True):
    """A region is of this class: CDMA, ODMA, TOMA, CC or any other name."""

    region: RegionId
    class_: ClassName = msgspec.field(name="class")

    def change(self, map: RGMap) -> RGMap:
        return put(map, "regions", replace(the_region(map, self.region), class_=self.class_))

    def title(self, map: RGMap) -> str:
        return f"relabel {self.region} as {self.class_}"


class RenameRegion(Edit, frozen=True):
    """A region has this name."""

    region: RegionId
    name: Name

    def change(self, map: RGMap) -> RGMap:
        return put(map, "regions", replace(the_region(map, self.region), name=self.name))

    def title(self, map: RGMap) -> str:
        return f"rename {self.region} to {self.name}"


class ReshapeRegion(Edit, frozen=True):
    """A region has this outline and these holes. What it gains its neighbours lose; lines, gateways and objects go
    with the ground."""

    region: RegionId
    boundary: Ring
    holes: Rings = ()

    def change(self, map: RGMap) -> RGMap:
        old = the_region(map, self.region)
        boundary, holes = checked_rings(old.id, self.boundary, self.holes)
        new = replace(old, boundary=boundary, holes=holes)
        if new == old:
            return map
        losers = claim(map, old.id, cutting.minus(shape_of(new), shape_of(old)))
        after = put_all(map, "regions", [new, *losers])
        return settle(map, after, [old.id, *(r.id for r in losers)])

    def title(self, map: RGMap) -> str:
        return f"reshape {self.region}"


class AddRegion(Edit, frozen=True):
    """There is a region with this outline. What it covers its neighbours lose."""

    id: NewRegionId
    boundary: Ring
    holes: Rings = ()
    name: Text = ""
    class_: ClassName = msgspec.field(name="class", default="TOMA")

    def change(self, map: RGMap) -> RGMap:
        must_be_new(map, "regions", self.id)
        boundary, holes = checked_rings("the new region", self.boundary, self.holes)
        new = Region(
            id=self.id,
            name=self.name or free_name(map, "Region"),
            class_=self.class_,
            boundary=boundary,
            holes=holes,
            box=Box2(center=boundary[0], size=(0.0, 0.0), yaw=0.0),
        )
        losers = claim(map, new.id, shape_of(new))
        after = put_all(map, "regions", [new, *losers])
        return settle(map, after, [new.id, *(r.id for r in losers)])

    def title(self, map: RGMap) -> str:
        return f"add the region {self.name}" if self.name else "add a region"


class SplitRegion(Edit, frozen=True):
    """A region is two, parted by this cut, which goes on straight to its outline; the larger part stays the region.

    ``gateway``: the id of a gateway on the cut, or none. Lines, gateways and objects go with the ground.
    """

    region: RegionId
    cut: Path
    id: NewRegionId
    name: Text = ""
    gateway: NewGatewayId | None = None
    gateway_class: ClassName = "opening"

    def change(self, map: RGMap) -> RGMap:
        old = the_region(map, self.region)
        must_be_new(map, "regions", self.id)
        halves, cut = self._halves(old)
        kept = reshaped(old, halves[0])
        name = self.name or free_name(map, old.name)
        new = reshaped(replace(old, id=self.id, name=name, class_scores={}, accuracy=None, scans=0), halves[1])
        after = settle(map, put_all(map, "regions", [kept, new]), [old.id, new.id])
        return after if self.gateway is None else put(after, "gateways", self._gateway(after, cut))

    def _halves(self, old: Region) -> tuple[list, np.ndarray]:
        if any(math.dist(a, b) < 1e-3 for a, b in zip(self.cut, self.cut[1:], strict=False)):
            raise EditError("two points of the cut are the same")
        halves, cut = cutting.halve(shape_of(old), np.array(self.cut), LEAST_REGION)
        if not halves:
            raise EditError(f"the cut does not lie in {old.id}")
        if len(halves) == 1:
            raise EditError(f"the cut does not part {old.id} in two; draw it from wall to wall")
        if len(halves) > 2:
            raise EditError(f"the cut parts {old.id} into {len(halves)}; draw it so that it makes two parts")
        if halves[1].area < LEAST_REGION:
            raise EditError(f"a part of {old.id} would be smaller than {LEAST_REGION} m²")
        return halves, cut

    def _gateway(self, map: RGMap, cut: np.ndarray) -> Gateway:
        assert self.gateway is not None
        must_be_new(map, "gateways", self.gateway)
        posts = (_point(cut[0]), _point(cut[-1]))
        if math.dist(*posts) < LEAST_WIDTH:
            raise EditError("the gateway on the cut would be less than 5 cm wide; split without one")
        both = (self.region, self.id)
        return Gateway(
            id=self.gateway,
            class_=self.gateway_class,
            confidence=1.0,
            regions=both,
            posts=posts,
            crossing_points=(middle(posts),),
            gateway_points=gateway_points(map, posts, both),
            traversal_directions=directions(posts),
        )

    def title(self, map: RGMap) -> str:
        return f"split {self.region}"


class MergeRegions(Edit, frozen=True):
    """Regions that lie side by side are one: the first keeps its id, name and class. Gateways between them go."""

    regions: SomeRegions

    def change(self, map: RGMap) -> RGMap:
        if len(set(self.regions)) < len(self.regions):
            raise EditError("a region is named twice")
        old = [the_region(map, id) for id in self.regions]
        first, gone = old[0], self.regions[1:]
        within = [g for g in map.gateways.values() if len(g.regions) > 1 and set(g.regions) <= set(self.regions)]
        doors = np.array([g.posts for g in within]).reshape(-1, 2, 2)
        others = [shape_of(r) for r in map.regions.values() if r.id not in self.regions]
        whole = cutting.unite([shape_of(r) for r in old], doors, others)
        if whole is None:
            raise EditError(f"{several(self.regions, 'regions')} do not all lie side by side")
        one = replace(reshaped(first, whole), accuracy=_accuracy(old), scans=sum(r.scans for r in old))
        after = drop(put(map, "regions", one), "regions", *gone)
        if within:
            after = drop(after, "gateways", *(g.id for g in within))
        return settle(map, after, [first.id], gone)

    def title(self, map: RGMap) -> str:
        return f"merge {several(self.regions, 'regions')}"


class DeleteRegion(Edit, frozen=True):
    """There is no such region; its gateways go with it, its lines and objects stay without it."""

    region: RegionId

    def change(self, map: RGMap) -> RGMap:
        return settle(map, drop(map, "regions", the_region(map, self.region).id), [], [self.region])

    def title(self, map: RGMap) -> str:
        return f"delete {self.region}"


def _accuracy(regions: list[Region]) -> float | None:
    """acc(R) of regions together: root mean square over their scans (paper, section IV-C)."""
    known = [(r.accuracy, r.scans) for r in regions if r.accuracy is not None and r.scans]
    if not known:
        return None
    return rounded(math.sqrt(sum(n * a * a for a, n in known) / sum(n for _, n in known)))


def _point(p: np.ndarray) -> Point:
    return rounded(p[0]), rounded(p[1])
