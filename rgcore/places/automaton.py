"""The finite state automaton that tells which place the robot is in, scan by scan (paper, section IV-D).

Its states are those of the paper: in a region of a class, in an unclassified region, entering an unknown region. It is
fed with what one scan tells (:class:`Sight`): where the map so far places the robot, the gateway that it just went
through, and what the last line scans look like to the network of the region classes. What it tells are events.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import msgspec
import numpy as np

from rgcore.places.classify import CLASSES

State = Literal["in-CDMA", "in-ODMA", "in-TOMA", "in-CC", "in-unclassified", "entering-unknown"]
"""The states of the paper, without the word region."""

Pose = tuple[float, float, float]

CERTAIN = 0.5
"""A class is told once the mean of its scores is above it ..."""

BETTER = 0.15
"""... and another one only once that is so much likelier."""

MEMORY = 30
"""Line scans over which the scores are averaged: the k of the paper."""

LEAST = 5
"""Scans in a row that must lie in another region where no gateway to it was noticed."""

PAST = 0.4
"""m behind a gateway at which it counts as left: a little less than its gateway-point."""


class Event(msgspec.Struct, frozen=True, kw_only=True, tag_field="event"):
    """Something happened at ``scan``, at ``stamp`` [s], where the robot was at ``pose`` (map_from_base)."""

    scan: int
    stamp: float
    pose: Pose


class GatewayEntered(Event, frozen=True, kw_only=True, tag="gateway entered"):
    """The robot goes through a gateway, out of ``region``. ``known``: it was in the map before."""

    gateway: str
    region: str
    known: bool


class GatewayLeft(Event, frozen=True, kw_only=True, tag="gateway left"):
    """The gateway lies behind the robot, which is in ``region`` now: the old one, if it turned back or was none."""

    gateway: str
    region: str


class RegionLeft(Event, frozen=True, kw_only=True, tag="region left"):
    """The robot is in ``region`` no more."""

    region: str


class RegionFound(Event, frozen=True, kw_only=True, tag="region found"):
    """The robot is in a region for the first time."""

    region: str


class RegionRecognised(Event, frozen=True, kw_only=True, tag="region recognised"):
    """The robot is back in a region that it knows; ``gateway`` is the one it came through, if one was noticed."""

    region: str
    gateway: str | None = None


class RegionClassed(Event, frozen=True, kw_only=True, tag="region classed"):
    """What kind of place ``region``, where the robot is, looks like from now on; ``score`` is the class's."""

    region: str
    class_: str = msgspec.field(name="class")
    score: float


class RegionsJoined(Event, frozen=True, kw_only=True, tag="regions joined"):
    """What seemed another place is part of ``into``: ``region`` is no more."""

    region: str
    into: str


class MapBent(Event, frozen=True, kw_only=True, tag="map bent"):
    """A loop was closed: ``scans`` poses have moved, by up to ``distance`` [m]; regions and gateways follow."""

    scans: int
    distance: float


AnyEvent = (
    GatewayEntered | GatewayLeft | RegionLeft | RegionFound | RegionRecognised | RegionClassed | RegionsJoined | MapBent
)
"""Everything that a step may tell; msgspec encodes and decodes it by its tag."""
