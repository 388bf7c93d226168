"""The finite state automaton that tells which place the robot is in, scan by scan (paper, section IV-D).

Its states are those of the paper: in a region of a class, in an unclassified region, entering an unknown region. It is
fed with what one scan tells (:class:`Sight`): where the map so far places the robot, the gateway that it just went
through, and what the line scans of the region look like to the network of the region classes. What it tells are events.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

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

MEMORY = 6
"""Scans over which the scores are averaged; each look already goes by all line scans of the region."""

SURE = 3
"""Looks before a class is told at all."""

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


class Passage(NamedTuple):
    """A gateway that the robot goes through now: its id, its middle, whether it was in the map before."""

    gateway: str
    middle: tuple[float, float]
    known: bool


class Sight(NamedTuple):
    """What one scan tells.

    here      the region that the map so far places the robot in, None where it does not know
    scans     how many scans that map knows
    passage   the gateway whose line the robot crossed since the last scan
    chance    (4,) what the line scans of the region look like, by ``CLASSES``; None where nothing can be told
    """

    scan: int
    stamp: float
    pose: Pose
    here: str | None
    scans: int
    passage: Passage | None = None
    chance: np.ndarray | None = None


class Automaton:
    """``step`` takes one sight after the other and gives the events; ``state``, ``region`` and ``class_`` are now."""

    def __init__(self, first: str) -> None:
        """``first``: id of the region where the robot starts."""
        self.region: str | None = None
        self.classes: dict[str, str] = {}  # as told last
        self.known: set[str] = set()
        self._joined: set[str] = set()
        self._first = first
        self._belief: dict[str, np.ndarray] = {}
        self._weight: dict[str, float] = {}
        self._passage: Passage | None = None
        self._since = 0  # scan at which it was crossed
        self._from = first
        self._elsewhere = ("", 0)  # the region that the last scans lay in, and how many

    @property
    def class_(self) -> str | None:
        """Class of the region that the robot is in, as told last."""
        return self.classes.get(self.region) if self.region is not None else None

    @property
    def state(self) -> State:
        if self.region is None:
            return "entering-unknown"
        return IN[self.classes.get(self.region)]

    @property
    def waiting(self) -> int | None:
        """The scan that a map must know before it can be told where the robot is; None while that is known."""
        return self._since if self.region is None else None

    def step(self, s: Sight) -> list[Event]:
        """The events of a scan."""
        told: list[Event] = []
        if self.region is None and self._passage is None:
            told += self._enter(s, self._first, None)
        if s.passage is not None:
            told += self._cross(s, s.passage)
        elif self._passage is not None:
            told += self._leave(s, self._passage)
        elif s.here is not None and s.here != self.region:
            count = self._elsewhere[1] + 1 if self._elsewhere[0] == s.here else 1
            self._elsewhere = (s.here, count)
            if count >= LEAST:
                told += self._change(s, s.here, None)
        else:
            self._elsewhere = ("", 0)
        if s.chance is not None and self.region is not None:
            told += self._look(s, self.region, s.chance)
        return told

    def join(self, scan: int, stamp: float, pose: Pose, region: str, into: str) -> list[Event]:
        """A survey found that ``region`` is part of ``into``."""
        if region not in self.known:
            return []
        self.known.discard(region)
        self._joined.add(region)
        self.known.add(into)
        class_ = self.classes.pop(region, None)
        if class_ is not None:
            self.classes.setdefault(into, class_)
        self.region = into if self.region == region else self.region
        self._from = into if self._from == region else self._from
        return [RegionsJoined(scan=scan, stamp=stamp, pose=pose, region=region, into=into)]

    def part(self, region: str) -> None:
        """A survey found that ``region``, which had become part of another, stands alone again: it is known still."""
        if region in self._joined:
            self._joined.discard(region)
            self.known.add(region)

    def _cross(self, s: Sight, passage: Passage) -> list[Event]:
        """Through a gateway; what lies behind an unknown one is not known yet, unless it is the way back."""
        last, self._passage = self._passage, passage
        if last is not None and last.gateway == passage.gateway and s.scan - self._since < LEAST:
            return []  # still on its line
        self._since = s.scan
        self._elsewhere = ("", 0)
        if self.region is not None:
            self._from = self.region
            self.region = self.region if passage.known else None
        elif last is not None and last.gateway == passage.gateway:
            self.region = self._from
        return [GatewayEntered(**_at(s), gateway=passage.gateway, region=self._from, known=passage.known)]

    def _leave(self, s: Sight, passage: Passage) -> list[Event]:
        """Out of the gateway, as soon as the robot is past it and the map knows what lies there."""
        x, y, _ = s.pose
        if math.hypot(x - passage.middle[0], y - passage.middle[1]) < PAST:
            return []
        if self.region is not None:  # a known gateway, or the way back through an unknown one
            here = s.here if passage.known and s.here is not None else self.region
        elif s.here is None or s.scans <= self._since:
            return []
        else:
            here = s.here
        self._passage = None
        left = GatewayLeft(**_at(s), gateway=passage.gateway, region=here)
        return [left, *self._change(s, here, passage.gateway)]

    def _change(self, s: Sight, region: str, gateway: str | None) -> list[Event]:
        """The robot is in ``region`` now."""
        if region == self._from and self.region is None:
            self.region = region
        if region == self.region:
            return []
        left = self.region if self.region is not None else self._from
        return [
            RegionLeft(**_at(s), region=left),
            *self._enter(s, region, gateway),
        ]

    def _enter(self, s: Sight, region: str, gateway: str | None) -> list[Event]:
        self.region, self._elsewhere = region, ("", 0)
        if region in self.known:
            return [RegionRecognised(**_at(s), region=region, gateway=gateway)]
        self.known.add(region)
        return [RegionFound(**_at(s), region=region)]

    def _look(self, s: Sight, region: str, chance: np.ndarray) -> list[Event]:
        """Take what the line scans look like into the mean of the region; tell its class where that is sure."""
        weight = min(self._weight.get(region, 0.0) + 1.0, MEMORY)
        belief = self._belief.get(region, np.zeros(len(CLASSES)))
        belief = belief + (chance - belief) / weight
        self._belief[region], self._weight[region] = belief, weight
        best = int(belief.argmax())
        now = self.classes.get(region)
        last = belief[CLASSES.index(now)] if now is not None else max(CERTAIN - BETTER, 0.0)
        if weight < SURE or CLASSES[best] == now or belief[best] < last + BETTER:
            return []
        self.classes[region] = CLASSES[best]
        score = round(float(belief[best]), 3)
        return [RegionClassed(**_at(s), region=region, class_=CLASSES[best], score=score)]


def _at(s: Sight) -> dict[str, Any]:
    return {"scan": s.scan, "stamp": s.stamp, "pose": s.pose}


IN: dict[str | None, State] = {
    None: "in-unclassified",
    "CDMA": "in-CDMA",
    "ODMA": "in-ODMA",
    "TOMA": "in-TOMA",
    "CC": "in-CC",
}
"""The state of being in a region of a class."""
