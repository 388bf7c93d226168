"""The tape: what the mapping of a log told scan by scan, kept within bounds, so that it can be shown again."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import replace
from typing import get_args

import numpy as np

from rgcore.geometry import se2
from rgcore.places import automaton as told
from rgcore.places.automaton import AnyEvent, State
from rgviz.play.child import NONE, Mapped, Opening, Picture

NOMINAL = 0.1
"""s between two scans of a log whose stamps tell nothing: usual for laser scanners that were written to files"""
LONGEST = 5.0
"""s: a longer break between two scans is played as this"""
MOST_PICTURES = 128
"""pictures that are kept, about: evenly over the log, and the newest"""
MOST_EVENTS = 5000
"""events that are kept"""
STATES: tuple[State, ...] = get_args(State)


def timeline(stamps: np.ndarray) -> tuple[np.ndarray, str]:
    """(N,) s since the first scan at which each is played, strictly rising, and a sentence on what had to be guessed.

    Where stamps repeat or run backwards, the usual time between two scans of the log counts (``NOMINAL`` if there is
    none); longer breaks than ``LONGEST`` are cut.
    """
    steps = np.diff(np.asarray(stamps, float))
    good = np.isfinite(steps) & (steps > 1e-6)
    usual = float(np.median(steps[good])) if 2 * good.sum() > len(steps) else NOMINAL
    long = good & (steps > max(LONGEST, 2 * usual))
    notes = []
    if len(steps) and not good.all():
        notes.append(f"{(~good).sum():,} stamps repeat or run backwards: {usual:.2g} s a scan is played there")
    if long.any():
        notes.append(f"{long.sum():,} breaks are played as {LONGEST:g} s")
    steps = np.where(good, np.where(long, LONGEST, steps), usual)
    return np.concatenate([[0.0], np.cumsum(steps)])[: len(stamps)], "; ".join(notes)


class Tape:
    """All that was told of the scans so far, within bounds: a few numbers and the echoes of each, some pictures.

    ``len`` is the number of scans that are mapped, ``total`` of those in the log.
    """

    def __init__(self, opening: Opening) -> None:
        self.source, self.total = opening.source, len(opening.stamps)
        self.times, self.note = timeline(opening.stamps)
        self.events: list[AnyEvent] = []
        self.pictures: list[Picture] = []
        self._bearings, self._mounting = opening.bearings, opening.base_from_laser
        self._poses = np.zeros((self.total, 3))
        self._states = np.zeros(self.total, np.int8)
        self._regions: list[str | None] = []
        self._ranges = np.full((self.total, len(opening.bearings)), NONE)
        self._newest: Picture | None = None

    def __len__(self) -> int:
        return len(self._regions)

    def add(self, mapped: Mapped) -> None:
        """The next scans."""
        for step, ranges in zip(mapped.steps, mapped.ranges, strict=True):
            k = step.scan
            self._poses[k], self._states[k], self._ranges[k] = step.pose, STATES.index(step.state), ranges
            self._regions.append(step.region)
            self.events += step.events
        del self.events[:-MOST_EVENTS]

    def draw(self, picture: Picture) -> None:
        """One more picture. What is equal in the one before is kept once, so that it need not be drawn again."""
        before = self._newest
        if before is not None and picture.regions is None:
            picture = replace(picture, regions=before.regions, gateways=before.gateways)
        elif before is not None and picture.regions is not None:
            known = {r.id: r for r in before.regions or ()}
            picture = replace(
                picture, regions=tuple(known[r.id] if known.get(r.id) == r else r for r in picture.regions)
            )
        self._newest = picture
        if len(self.pictures) > 1 and picture.scan - self.pictures[-2].scan < self.total / MOST_PICTURES:
            self.pictures.pop()  # it was only the newest
        self.pictures.append(picture)

    def pose(self, scan: int) -> np.ndarray:
        """(3,) map_from_base when the scan came in."""
        pose: np.ndarray = self._poses[scan]
        return pose

    def place(self, scan: int) -> tuple[State, str | None]:
        """The state of the automaton and the region that the robot was in."""
        return STATES[self._states[scan]], self._regions[scan]

    def echoes(self, scan: int) -> np.ndarray:
        """(K, 2) [m] what the laser saw, map frame."""
        ranges = self._ranges[scan]
        seen = ranges != NONE
        r, b = ranges[seen] / 100.0, self._bearings[seen]
        laser = se2.compose(self._poses[scan], self._mounting)
        echoes: np.ndarray = se2.transform(laser, np.stack([r * np.cos(b), r * np.sin(b)], 1))
        return echoes

    def picture(self, scan: int) -> Picture | None:
        """The last picture that was made by then."""
        n = bisect_right(self.pictures, scan, key=lambda p: p.scan)
        return self.pictures[n - 1] if n else None

    def way(self, first: int, last: int) -> np.ndarray:
        """(N, 2) where the robot was from one scan to another, both included."""
        way: np.ndarray = self._poses[first : last + 1, :2]
        return way

    def last_events(self, scan: int, most: int) -> list[AnyEvent]:
        """The last events until then that say something new to a person, the latest first."""
        n = bisect_right(self.events, scan, key=lambda e: e.scan)
        found: list[AnyEvent] = []
        for event in reversed(self.events[:n]):
            if len(found) == most:
                break
            if not isinstance(event, told.RegionLeft):  # what comes after it says it
                found.append(event)
        return found


def words(event: AnyEvent) -> str:
    """An event in words for a person."""
    if isinstance(event, told.GatewayEntered):
        return f"entered gateway {event.gateway}" + ("" if event.known else ", which is new")
    if isinstance(event, told.GatewayLeft):
        return f"left gateway {event.gateway}, in {event.region}"
    if isinstance(event, told.RegionFound):
        return f"found region {event.region}"
    if isinstance(event, told.RegionRecognised):
        return f"recognised {event.region}"
    if isinstance(event, told.RegionClassed):
        return f"{event.region} looks like {event.class_} ({100 * event.score:.0f} %)"
    if isinstance(event, told.RegionsJoined):
        return f"{event.region} is part of {event.into}"
    if isinstance(event, told.MapBent):
        return f"closed a loop: {event.scans:,} poses moved by up to {event.distance:.2f} m"
    return f"left {event.region}"


def clock(seconds: float) -> str:
    """``2:03``, ``1:02:03``."""
    whole = int(seconds)
    hours, minutes = whole // 3600, whole // 60 % 60
    return f"{hours}:{minutes:02}:{whole % 60:02}" if hours else f"{minutes}:{whole % 60:02}"
