"""The places so far: regions and gateways of an unfinished map, which keep their names while it grows and bends.

A survey divides the free space as the batch does (:mod:`rgcore.places.regions`), but judges only chords near what has
changed since the last one. Its regions are matched with those before by witnesses, points that scans saw to be free:
they move with the scans when a loop closes, and so a place stays itself though the raster has changed under it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np

from rgcore.config import Places as Settings
from rgcore.geometry import se2
from rgcore.geometry.grid import Grid, dilate
from rgcore.places.chords import Chords, find_chords, measure_chords
from rgcore.places.divide import open_space
from rgcore.places.freespace import FreeSpace
from rgcore.places.gateways import find_gateways
from rgcore.places.hypotheses import Hypotheses, judge
from rgcore.places.places import FoundGateway
from rgcore.places.regions import divided

SAME_GATEWAY = 0.75
"""m: gateways whose middles are nearer are one."""

TILE, CHANGED, AROUND = 20, 4, 2
"""cells, cells, tiles: chords are judged anew in tiles of which so many cells have changed, and so far around them."""

PART = 0.5
"""Share of its witnesses that a region must have in another one to have become a part of it."""

TOLD = 3
"""Witnesses that a scan counts for that was told to be in a region."""


@dataclass(frozen=True)
class KnownGateway:
    """A gateway with its number; it stands where the scan ``anchor`` saw it, at ``posts_there`` (2, 2) in its frame."""

    number: int
    anchor: int
    posts_there: np.ndarray
    found: FoundGateway | None
    """None while only a single scan has told of it"""

    def posts(self, poses: np.ndarray) -> np.ndarray:
        """(2, 2) m, where scans stand at ``poses`` (N, 3)."""
        out: np.ndarray = se2.transform(poses[self.anchor], self.posts_there)
        return out


@dataclass(frozen=True)
class Seen:
    """What a survey goes by: the free space, poses (N, 3) map_from_base of all scans, the number of the region that
    each was told to be in (N,) (-1 = none), the witnesses (W, 2) m, and gateways that single scans told of."""

    free: FreeSpace
    poses: np.ndarray
    told: np.ndarray
    witnesses: np.ndarray
    guessed: tuple[KnownGateway, ...] = ()


@dataclass(frozen=True)
class PlacesSoFar:
    """What the last survey found.

    scans     how many scans it knew
    labels    raster of region *numbers*, -1 = none
    found     all hypotheses that it judged, in cells numbered from the map's origin
    open_     mask of the open space that it divided, in the frame of the labels
    witness   (W,) number of the region of each witness, -1 = none
    gateways  those that join two regions; their ``found.regions`` are numbers
    joined    numbers of regions that are no more -> what they have become a part of
    next_region: the number that comes next
    """

    scans: int = 0
    labels: Grid = field(default_factory=lambda: Grid(np.full((1, 1), -1, np.int32), np.zeros(2), 1.0))
    found: Hypotheses = field(
        default_factory=lambda: Hypotheses(
            np.zeros((0, 2, 2), np.int64), np.zeros(0), np.zeros(0, np.int64), np.zeros(0, bool)
        )
    )
    open_: np.ndarray = field(default_factory=lambda: np.zeros((1, 1), bool))
    witness: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    gateways: tuple[KnownGateway, ...] = ()
    joined: dict[int, int] = field(default_factory=dict)
    next_region: int = 2

    def now(self, region: int) -> int:
        """The region that a number stands for now."""
        while region in self.joined:
            region = self.joined[region]
        return region

    @property
    def regions(self) -> list[int]:
        """Numbers of the regions, ascending."""
        return [int(i) for i in np.unique(self.labels.values) if i >= 0]


def survey(seen: Seen, before: PlacesSoFar, settings: Settings) -> PlacesSoFar:
    """Divide the free space anew; regions and gateways that were known keep their numbers.

    New gateways are numbered -1: their numbers are given when the survey is taken up.
    """
    free, positions = seen.free, seen.poses[:, :2]
    open_, furniture = open_space(free, settings)
    found = _judged(free, open_, before, settings)
    pieces, dividing = divided(free, open_, furniture, found, positions, settings)
    numbers, next_region, joined, witness = _numbered(pieces, seen, before)
    labels = pieces.like(np.append(numbers, -1).astype(np.int32)[pieces.values])
    return PlacesSoFar(
        scans=len(positions),
        labels=labels,
        found=_shifted(found, _corner(free)),
        open_=open_,
        witness=witness,
        gateways=_gateways(labels, dividing, seen, before, settings),
        joined=joined,
        next_region=next_region,
    )


def _corner(raster: FreeSpace | Grid) -> np.ndarray:
    """(2,) number of its first cell, counted from the map's origin."""
    return np.round(np.asarray(raster.origin) / raster.resolution).astype(np.int64)


def _shifted(found: Hypotheses, by: np.ndarray) -> Hypotheses:
    return Hypotheses(found.posts + by, found.score, found.kind, found.weak)


def _judged(free: FreeSpace, open_: np.ndarray, before: PlacesSoFar, settings: Settings) -> Hypotheses:
    """The hypotheses: of all chords where the open space has changed, of the best ones so far elsewhere."""
    where = _changed(free, open_, before)
    new = find_chords(open_, free.resolution, settings, where)
    posts = before.found.posts - _corner(free)
    middle = posts.mean(1).astype(int)
    stand = dilate(~open_, 1)[posts[..., 1], posts[..., 0]].all(1)
    old = measure_chords(open_, posts[stand & ~where[middle[:, 1], middle[:, 0]]], free.resolution)
    return judge(_both(old, new), free.resolution, settings)


def _both(a: Chords, b: Chords) -> Chords:
    every = {
        f.name: getattr(a, f.name) if f.name in a.whole() else np.concatenate([getattr(a, f.name), getattr(b, f.name)])
        for f in fields(a)
    }
    return Chords(**every)


def _changed(free: FreeSpace, open_: np.ndarray, before: PlacesSoFar) -> np.ndarray:
    """Mask (H, W) of the tiles where the open space is not as it was, and those around them."""
    last = np.zeros_like(open_)
    if before.scans:
        x, y = _corner(before.labels) - _corner(free)
        h, w = before.open_.shape
        last[y : y + h, x : x + w] = before.open_
    h, w = open_.shape
    tall, wide = -(-h // TILE), -(-w // TILE)
    padded = np.zeros((tall * TILE, wide * TILE), bool)
    padded[:h, :w] = last != open_
    tiles = padded.reshape(tall, TILE, wide, TILE).sum((1, 3)) >= CHANGED
    near = dilate(tiles, AROUND)
    out: np.ndarray = np.repeat(np.repeat(near, TILE, 0), TILE, 1)[:h, :w]
    return out


def _numbered(pieces: Grid, seen: Seen, before: PlacesSoFar) -> tuple[np.ndarray, int, dict[int, int], np.ndarray]:
    """Number of each piece, the next free one, what became part of what, and the number of each witness."""
    count = int(pieces.values.max(initial=-1)) + 1
    at = pieces.at(seen.witnesses, outside=-1)
    of = np.full(len(at), -1, np.int64)
    of[: len(before.witness)] = before.witness
    here = pieces.at(seen.poses[:, :2], outside=-1)
    votes = np.zeros((before.next_region, count), np.int64)
    for of_each, piece_of_each, weight in ((of, at, 1), (seen.told, here, TOLD)):
        ok = (of_each >= 0) & (piece_of_each >= 0)
        np.add.at(votes, (of_each[ok], piece_of_each[ok]), weight)
    numbers = np.full(count, -1, np.int64)
    joined = dict(before.joined)
    for number, piece in _strongest(votes):
        if numbers[piece] < 0:
            numbers[piece] = number
            joined.pop(number, None)  # it stands alone again
        elif votes[number, piece] >= PART * votes[number].sum():
            joined[number] = int(numbers[piece])
    next_region = before.next_region
    for piece in _by_first_scan(here, count):
        if numbers[piece] < 0:
            numbers[piece] = next_region
            next_region += 1
    witness = np.where(at >= 0, np.append(numbers, -1)[at], of)
    for number, into in joined.items():
        witness[witness == number] = into
    return numbers, next_region, joined, witness


def _strongest(votes: np.ndarray) -> list[tuple[int, int]]:
    """(number, piece): each number with the piece that most of its votes are for, the most votes first."""
    best = votes.argmax(1) if votes.shape[1] else np.zeros(len(votes), int)
    most = votes.max(1, initial=0)
    order = np.argsort(-most, kind="stable")
    return [(int(n), int(best[n])) for n in order if most[n] > 0]


def _by_first_scan(here: np.ndarray, count: int) -> list[int]:
    """All pieces, in the order in which scans (N,) were taken in them; those that were only looked into last."""
    seen = list(dict.fromkeys(int(i) for i in here if i >= 0))
    return seen + [i for i in range(count) if i not in set(seen)]


def _gateways(
    labels: Grid, found: Hypotheses, seen: Seen, before: PlacesSoFar, settings: Settings
) -> tuple[KnownGateway, ...]:
    """The gateways between regions; those that were known, or told of by single scans, keep their numbers."""
    known = [*before.gateways, *seen.guessed]
    middles = np.array([g.posts(seen.poses).mean(0) for g in known]).reshape(-1, 2)
    out: list[KnownGateway] = []
    taken: set[int] = set()
    for g in find_gateways(labels, found, seen.poses[:, :2], settings):
        posts = np.array(g.posts)
        far = np.hypot(*(middles - posts.mean(0)).T)
        near = [int(i) for i in np.argsort(far, kind="stable") if far[i] < SAME_GATEWAY and i not in taken]
        number = known[near[0]].number if near else -1
        taken.update(near[:1])
        anchor = int(((seen.poses[:, :2] - posts.mean(0)) ** 2).sum(1).argmin())
        there = se2.transform(se2.invert(seen.poses[anchor]), posts)
        out.append(KnownGateway(number, anchor, there, g))
    return tuple(out)
