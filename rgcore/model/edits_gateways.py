"""Edits of gateways: what they are, where they stand, what they join."""

from __future__ import annotations

import math

import msgspec

from rgcore.errors import EditError
from rgcore.model.edit import Edit, drop, must_be_new, put, several, the_gateway, the_region
from rgcore.model.fields import ClassName, GatewayId, NewGatewayId, Places, Posts, RegionIds, Text
from rgcore.model.follow import Follow
from rgcore.model.gates import LEAST_WIDTH, directions, gateway_points, middle
from rgcore.model.records import Gateway, RGMap, replace


class ClassifyGateway(Edit, frozen=True):
    """A gateway is of this class: narrow_passage, junction_T, junction_L, junction_X, opening or any other name."""

    gateway: GatewayId
    class_: ClassName = msgspec.field(name="class")

    def change(self, map: RGMap) -> RGMap:
        return put(map, "gateways", replace(the_gateway(map, self.gateway), class_=self.class_))

    def title(self, map: RGMap) -> str:
        return f"relabel {self.gateway} as {self.class_}"


class RenameGateway(Edit, frozen=True):
    """A gateway has this name; the empty name takes it away."""

    gateway: GatewayId
    name: Text

    def change(self, map: RGMap) -> RGMap:
        return put(map, "gateways", replace(the_gateway(map, self.gateway), name=self.name))

    def title(self, map: RGMap) -> str:
        return f"rename {self.gateway} to {self.name}" if self.name else f"take the name off {self.gateway}"


class MoveGateway(Edit, frozen=True):
    """The posts stand here; crossing- and gateway-points are as given, or follow the posts where they are not."""

    gateway: GatewayId
    posts: Posts
    crossing_points: Places | None = None
    gateway_points: Places | None = None

    def change(self, map: RGMap) -> RGMap:
        old = the_gateway(map, self.gateway)
        _must_stand_apart(self.gateway, self.posts)
        _must_be_one_a_region(old, self.gateway_points)
        follow = Follow(old.posts, self.posts)
        crossing, points = self.crossing_points, self.gateway_points
        moved = replace(
            old,
            posts=self.posts,
            crossing_points=follow.points(old.crossing_points) if crossing is None else crossing,
            gateway_points=follow.points(old.gateway_points) if points is None else points,
            traversal_directions=follow.directions(old.traversal_directions),
        )
        return put(map, "gateways", moved)

    def title(self, map: RGMap) -> str:
        return f"move {self.gateway}"


class MoveGatewayPoints(Edit, frozen=True):
    """The gateway is crossed here, and counts as entered and left there (one point a region); the posts stay."""

    gateway: GatewayId
    crossing_points: Places | None = None
    gateway_points: Places | None = None

    def change(self, map: RGMap) -> RGMap:
        old = the_gateway(map, self.gateway)
        _must_be_one_a_region(old, self.gateway_points)
        crossing = old.crossing_points if self.crossing_points is None else self.crossing_points
        points = old.gateway_points if self.gateway_points is None else self.gateway_points
        return put(map, "gateways", replace(old, crossing_points=crossing, gateway_points=points))

    def title(self, map: RGMap) -> str:
        return f"move points of {self.gateway}"


class AddGateway(Edit, frozen=True):
    """There is a gateway between these posts that joins these regions; crossing- and gateway-points follow."""

    id: NewGatewayId
    posts: Posts
    regions: RegionIds
    class_: ClassName = msgspec.field(name="class", default="narrow_passage")
    name: Text = ""

    def change(self, map: RGMap) -> RGMap:
        must_be_new(map, "gateways", self.id)
        _must_stand_apart("the new gateway", self.posts)
        _must_join("the new gateway", self.regions, self.class_)
        made = Gateway(
            id=self.id,
            name=self.name,
            class_=self.class_,
            confidence=1.0,
            regions=self.regions,
            posts=self.posts,
            crossing_points=(middle(self.posts),),
            gateway_points=gateway_points(map, self.posts, self.regions),
            traversal_directions=directions(self.posts),
        )
        return put(map, "gateways", made)

    def title(self, map: RGMap) -> str:
        return f"add a gateway between {several(self.regions, 'regions')}"


class AssignGateway(Edit, frozen=True):
    """A gateway joins these regions. Gateway-points of regions that stay, stay; others follow from the posts."""

    gateway: GatewayId
    regions: RegionIds

    def change(self, map: RGMap) -> RGMap:
        old = the_gateway(map, self.gateway)
        _must_join(old.id, self.regions, old.class_)
        for id in self.regions:
            the_region(map, id)
        if self.regions == old.regions:
            return map
        stay = set(self.regions) & set(old.regions)
        points = dict(zip(old.regions, old.gateway_points, strict=False)) if stay else {}
        if any(id not in points for id in self.regions):
            points = dict(zip(self.regions, gateway_points(map, old.posts, self.regions), strict=True)) | points
        return put(
            map, "gateways", replace(old, regions=self.regions, gateway_points=tuple(points[id] for id in self.regions))
        )

    def title(self, map: RGMap) -> str:
        return f"let {self.gateway} join {several(self.regions, 'regions')}"


class DeleteGateway(Edit, frozen=True):
    """There is no such gateway."""

    gateway: GatewayId

    def change(self, map: RGMap) -> RGMap:
        return drop(map, "gateways", the_gateway(map, self.gateway).id)

    def title(self, map: RGMap) -> str:
        return f"delete {self.gateway}"


def _must_stand_apart(what: str, posts: Posts) -> None:
    if math.dist(*posts) < LEAST_WIDTH:
        raise EditError(f"the posts of {what} would stand less than 5 cm apart")


def _must_be_one_a_region(gateway: Gateway, points: Places | None) -> None:
    if points is not None and len(points) != len(gateway.regions):
        wanted, given = len(gateway.regions), len(points)
        raise EditError(f"{gateway.id} needs {wanted} gateway-points, one a region, not {given}")


def _must_join(what: str, regions: tuple[str, ...], class_: str) -> None:
    if len(set(regions)) < len(regions):
        raise EditError(f"{what} would join a region with itself")
    if len(regions) != 2 and not (class_.startswith("junction_") and regions):
        raise EditError(f"{what} ({class_}) must join 2 regions, not {len(regions)}")
