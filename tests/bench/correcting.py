"""A person who corrects a map and knows the truth: the fewest edits from an automatic map to the true rooms and doors.

What is wrong with a map is counted as ``score_places.py`` beside the data does it: rooms that no region matches one to
one (by intersection over union), regions too many, gateways that were passed and are missing, gateways that are
none. At each step every edit that a person would think of is tried on the map with ``Edit.apply``, and the one that
takes away the most is made; of those that take away as much, the simplest. Where no single edit helps, the way is
shortest by way of the edit that makes the regions most like the rooms; steps that led nowhere are not counted.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np

from rgcore.errors import EditError
from rgcore.model import draft
from rgcore.model.edits import (
    AddGateway,
    AddRegion,
    ClassifyGateway,
    ClassifyRegion,
    DeleteGateway,
    DeleteRegion,
    Edit,
    MergeRegions,
    MoveGateway,
    ReshapeRegion,
    SplitRegion,
)
from rgcore.model.fields import new_id
from rgcore.model.records import Gateway, Point, Region, RGMap

LEAST_ROOM = 1.5
"""m2 of a room that must be found"""
LEAST_PIECE = 0.5
"""m2 of a region that counts, and of a part of one that a person would cut off"""
SAME_GATEWAY = 0.75
"""m between the middles of a gateway and the true one"""
BORDER = (0.2, 0.5)
"""m between two rooms in one region where a person would part them: at their door, or along the wall with it"""
MOVED = 3.0
"""m: from farther away a person draws a new gateway rather than move one"""
SIMPLEST = (DeleteGateway, MergeRegions, DeleteRegion, SplitRegion, MoveGateway, AddGateway, ReshapeRegion, AddRegion)
"""The kinds of edits by how little they ask of a hand: a key, a stroke, a drag, an outline. No ground is taken from a
room that can be given back to it, so merging comes before deleting."""
HALLWAYS = ("CDMA", "ODMA")
PATIENCE = 3
"""steps in a row that may take nothing away"""


class Cost(NamedTuple):
    """What is wrong with a map; compared first by the number of faults, then by how unlike the outlines are."""

    faults: int
    unlike: float
    pairs: dict[str, int]
    """true room by the region that matches it"""
    spare: tuple[str, ...]
    """regions that match none"""
    doors: dict[str, int]
    """index of the true gateway by the one that is there"""

    @property
    def order(self) -> tuple[int, float]:
        return self.faults, self.unlike


@dataclass
class Truth:
    """The true rooms and gateways of a run, and the rigid motion from the map to them."""

    rooms: np.ndarray
    resolution: float
    ids: np.ndarray
    classes: dict[int, str]
    gateways: list[dict[str, Any]]
    turn: np.ndarray
    move: np.ndarray
    alike: float = 0.5
    """intersection over union from which on a region matches a room"""
    _counted: dict[str, tuple[object, np.ndarray]] = field(default_factory=dict)

    @classmethod
    def of(cls, truth: Path, rooms: Path, turn: np.ndarray, move: np.ndarray, alike: float = 0.5) -> Truth:
        """From the files of a run and the motion ``turn @ p + move`` of a point of the map."""
        told = json.loads(truth.read_text(encoding="utf-8"))
        image, res = np.asarray(cv2.imread(str(rooms), cv2.IMREAD_GRAYSCALE))[::-1], told["resolution"]
        area = np.bincount(image.ravel(), minlength=256) * res**2
        ids = np.array([r["id"] for r in told["rooms"] if r["visited"] and area[r["id"]] >= LEAST_ROOM])
        classes = {r["id"]: r["cls"] for r in told["rooms"] if r.get("cls")}
        return cls(image, res, ids, classes, told["gateways"], turn, move, alike)

    def to_map(self, points: Any) -> list[Point]:
        """Points of the truth in the frame of the map."""
        p = (np.asarray(points, float).reshape(-1, 2) - self.move) @ self.turn
        return [(round(float(x), 3), round(float(y), 3)) for x, y in p]

    def to_truth(self, points: Any) -> np.ndarray:
        return np.asarray(points, float).reshape(-1, 2) @ self.turn.T + self.move

    def mask(self, region: Region) -> np.ndarray:
        """Pixels of rooms that a region covers."""
        image = np.zeros(self.rooms.shape, np.uint8)
        for ring, value in ((region.boundary, 1), *((h, 0) for h in region.holes)):
            cv2.fillPoly(image, [np.round(self.to_truth(ring) / self.resolution - 0.5).astype(np.int32)], value)
        return (image > 0) & (self.rooms > 0)

    def covered(self, region: Region) -> np.ndarray:
        """(256,) m2 that a region covers of the room of each label."""
        kept = self._counted.get(region.id)
        if kept is None or kept[0] is not region.boundary:
            area = np.bincount(self.rooms[self.mask(region)], minlength=256) * self.resolution**2
            kept = self._counted[region.id] = (region.boundary, area)
        return kept[1]

    def outline(self, room: int) -> list[Point]:
        """The corners that a person would click around a room, in the frame of the map."""
        found, _ = cv2.findContours((self.rooms == room).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        ring = cv2.approxPolyDP(max(found, key=cv2.contourArea), 0.1 / self.resolution, closed=True)
        return self.to_map((ring.reshape(-1, 2) + 0.5) * self.resolution)

    def cost(self, map_: RGMap) -> Cost:
        area = {r.id: self.covered(r) for r in map_.regions.values()}
        counts = {id: a for id, a in area.items() if a.sum() >= LEAST_PIECE and a.argmax() in self.ids}
        names, rooms = list(counts), np.bincount(self.rooms.ravel(), minlength=256)[self.ids] * self.resolution**2
        got = np.array([counts[id] for id in names]).reshape(-1, 256)
        shared = got[:, self.ids]
        alike = shared / np.maximum(got.sum(1)[:, None] + rooms - shared, 1e-9)
        pairs = {names[i]: int(self.ids[j]) for i, j in best_pairs(alike, self.alike)}
        unlike = len(rooms) - alike.max(0, initial=0).sum() + 0.1 * len(names)  # of as good ones the fewer regions
        doors = self.doors(map_)
        passed = {n for n, g in enumerate(self.gateways) if g["passed"]}
        false = len(map_.gateways) - len(doors)
        faults = len(names) + len(rooms) - 2 * len(pairs) + false + len(passed - set(doors.values()))
        return Cost(faults, float(unlike), pairs, tuple(n for n in names if n not in pairs), doors)

    def doors(self, map_: RGMap) -> dict[str, int]:
        """Index of the true gateway by the id of the one that stands there, one to one."""
        mine = self.to_truth([np.mean(g.posts, 0) for g in map_.gateways.values()])
        true = np.array([np.mean(g["posts"], 0) for g in self.gateways]).reshape(-1, 2)
        far = np.linalg.norm(mine[:, None] - true[None], axis=2)
        names = list(map_.gateways)
        return {names[i]: j for i, j in best_pairs(-far, -SAME_GATEWAY)}


def best_pairs(score: np.ndarray, least: float) -> Iterator[tuple[int, int]]:
    """Pairs of rows and columns one to one, the best first, as the tool beside the data chooses them."""
    left = score.copy()
    while left.size and left.max() >= least:
        i, j = np.unravel_index(int(left.argmax()), left.shape)
        yield int(i), int(j)
        left[i], left[:, j] = -np.inf, -np.inf


@dataclass
class Corrected:
    """What a person made of a map: the ``edits`` of shapes, then those of ``classes``."""

    map: RGMap
    edits: list[Edit]
    classes: list[Edit]
    before: Cost
    after: Cost


def correct(map_: RGMap, truth: Truth) -> Corrected:
    """The map with the fewest greedy edits that make its regions and gateways the true ones."""
    before = here = truth.cost(map_)
    now, done, since = map_, [], 0
    best, kept = map_, 0
    while here.faults and since < PATIENCE:
        step = _best_step(now, truth, here)
        if step is None:
            break
        edit, now, new = step
        done.append(edit)
        since = 0 if new.faults < truth.cost(best).faults else since + 1
        if since == 0:
            best, kept = now, len(done)
        here = new
    classes = list(class_edits(best, truth))
    after = best
    for edit in classes:
        after = edit.apply(after)
    return Corrected(after, done[:kept], classes, before, truth.cost(after))


def _best_step(map_: RGMap, truth: Truth, here: Cost) -> tuple[Edit, RGMap, Cost] | None:
    """The edit that takes away the most faults, else makes the outlines most alike; None if none does either."""
    best = None
    for edit in _thought_of(map_, truth, here):
        try:
            after = edit.apply(map_)
        except EditError:
            continue
        cost = truth.cost(after)
        order = (cost.faults, SIMPLEST.index(type(edit)) if cost.faults < here.faults else 0, cost.unlike)
        if cost.order < here.order and (best is None or order < best[0]):
            best = order, (edit, after, cost)
    return None if best is None else best[1]


def _thought_of(map_: RGMap, truth: Truth, here: Cost) -> Iterator[Edit]:
    """The edits that a person may think of who sees map and truth."""
    area = {r.id: truth.covered(r) for r in map_.regions.values()}
    for draw in (_splits, _merges, _outlines):
        yield from draw(map_, truth, here, area)
    yield from _gateways(map_, truth, here)


def _splits(map_: RGMap, truth: Truth, here: Cost, area: dict[str, np.ndarray]) -> Iterator[Edit]:
    """Regions that reach over several rooms: a cut at the door between two, or where they meet."""
    for id, got in area.items():
        rooms = np.flatnonzero(got >= LEAST_PIECE)
        if len(rooms) < 2:
            continue
        for cut, door in _cuts(truth, map_.regions[id], rooms):
            for gateway in (door, False) if door else (False,):
                draw = partial(draft.split_region, map_, id, cut, gateway=gateway)
                yield from _possible(draw)


def _cuts(truth: Truth, region: Region, rooms: np.ndarray) -> Iterator[tuple[list[Point], bool]]:
    """Strokes between rooms within a region, and whether a gateway belongs there."""
    inside = np.where(truth.mask(region), truth.rooms, 0)
    for g in truth.gateways:
        if set(g["regions"]) <= set(rooms.tolist()):
            yield truth.to_map(g["posts"]), True
    for room, apart in itertools.product(rooms, BORDER):
        mine, others = inside == room, (inside > 0) & (inside != room)
        reach = 2 * round(apart / truth.resolution) + 1
        near = cv2.dilate(mine.astype(np.uint8), np.ones((reach, reach), np.uint8)) > 0
        y, x = np.nonzero(near & others)
        if len(x) < 2:
            continue
        points = (np.stack([x, y], 1) + 0.5) * truth.resolution
        middle, along = points.mean(0), np.linalg.svd(points - points.mean(0), full_matrices=False)[2][0]
        s = (points - middle) @ along
        ends = [middle + s.min() * along, middle + s.max() * along]
        if math.dist(*ends) > 0.1:
            yield truth.to_map(ends), False


def _merges(map_: RGMap, truth: Truth, here: Cost, area: dict[str, np.ndarray]) -> Iterator[Edit]:
    """Regions that share a room: all of them as one, and each spare one with each that it touches."""
    for room in truth.ids:
        there = [id for id, got in area.items() if got[room] > 0.5 * got.sum() > 0]
        there.sort(key=lambda id: -area[id][room])
        if len(there) > 1:
            yield MergeRegions(regions=tuple(there))
        yield from (MergeRegions(regions=(there[0], id)) for id in there[1:] if len(there) > 2)


def _outlines(map_: RGMap, truth: Truth, here: Cost, area: dict[str, np.ndarray]) -> Iterator[Edit]:
    """Rooms that no region matches: the outline of the nearest one anew, or a new region; and regions that are none."""
    for id in here.spare:
        yield DeleteRegion(region=id)
    for room in set(truth.ids.tolist()) - set(here.pairs.values()):
        ring = tuple(truth.outline(room))
        for id in (id for id in here.spare if area[id].argmax() == room):
            yield ReshapeRegion(region=id, boundary=ring)
        yield AddRegion(id=new_id(map_, "regions"), boundary=ring)


def _gateways(map_: RGMap, truth: Truth, here: Cost) -> Iterator[Edit]:
    false = [g for g in map_.gateways.values() if g.id not in here.doors]
    yield from (DeleteGateway(gateway=g.id) for g in false)
    for n, g in enumerate(truth.gateways):
        if g["passed"] and n not in here.doors.values():
            a, b = truth.to_map(g["posts"])
            yield from (MoveGateway(gateway=f.id, posts=(a, b)) for f in false if _near(f, a, b))
            yield from _possible(partial(draft.add_gateway, map_, (a, b)))


def _near(gateway: Gateway, a: Point, b: Point) -> bool:
    return math.dist(np.mean(gateway.posts, 0), np.mean([a, b], 0)) < MOVED


def _possible(draw: Any) -> Iterator[Edit]:
    """The edit that a gesture means, if it means one."""
    try:
        yield draw()
    except EditError:
        return


def class_edits(map_: RGMap, truth: Truth) -> Iterator[Edit]:
    """The relabels of regions and gateways whose class the truth tells, where it is another one.

    The truth of a run says whether a room is a hallway, and whether a gateway is a door or an opening.
    """
    cost = truth.cost(map_)
    for id, room in cost.pairs.items():
        hallway = truth.classes.get(room)
        if hallway is not None and (map_.regions[id].class_ in HALLWAYS) != (hallway == "hallway"):
            yield ClassifyRegion(region=id, class_="CDMA" if hallway == "hallway" else "TOMA")
    for id, n in cost.doors.items():
        wanted = {"door": "narrow_passage", "opening": "opening"}.get(truth.gateways[n].get("kind", ""))
        if wanted is not None and map_.gateways[id].class_ != wanted:
            yield ClassifyGateway(gateway=id, class_=wanted)
