"""How edits survive a re-run: real logs are mapped, edited by chance as people edit, and mapped again in other ways.

    python tests/bench/bench_rebase.py [LOG ...] [--edits 100] [--seeds 1] [--maps FOLDER] [--show]

Every edit that was carried is judged by geometry that knows nothing of the matcher: a place of the old map lies in the
new one where the scans that saw it lie; a thing is the same if most of it lies on most of the other.

right  carried, and so judged
asked  left to a person although its things are there, or made and told to lie elsewhere than the poses say
gone   left to a person, and its things are not there any more
wrong  carried to another thing, made at another place or of another shape, and not told: must be none
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import math
import random
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

sys.path.insert(0, str(Path(__file__).parents[1] / "model"))
from people import edits_by_people

from rgcore import pipeline
from rgcore.cache import Cache
from rgcore.config import load
from rgcore.geometry import polygons, se2
from rgcore.model.carry import ids_of, places_of
from rgcore.model.drift import Drift, _same_scans
from rgcore.model.edits_objects import AddObject, SeedObject
from rgcore.model.fields import is_human_id
from rgcore.model.history import Done, History
from rgcore.model.outcome import Outcome
from rgcore.model.project import Project
from rgcore.model.rebase import Source, rebase
from rgcore.model.records import Gateway, Line, MapObject, Region, RGMap
from rgcore.scans.read import read_log

DATA = Path(__file__).parents[3] / "shared" / "data" / "logs"
THRESHOLDS = ["lines.distance=0.06", "lines.gap=0.35", "lines.price=8", "places.min_confidence=0.5"]
THRESHOLDS += ["places.clutter=0.6", "places.unpassed_confidence=0.9", "places.min_area=1.2"]
SCANS = ["slam.max_range=15", "slam.spacing=0.1", "slam.keyframe_distance=0.7", "slam.local_keyframes=5"]
VARIANTS = {"thresholds": THRESHOLDS, "every 2nd scan": [], "other SLAM": [*SCANS, "slam.point_noise=0.05"]}
NEAR = 0.3
"""m: a place that lies so near to where the scans say is right"""


def main() -> None:
    p = argparse.ArgumentParser()
    p.add_argument("logs", nargs="*", default=["intel", "fr079", "aces"])
    p.add_argument("--edits", type=int, default=100)
    p.add_argument("--seeds", type=int, default=1)
    p.add_argument("--maps", type=Path, help="where the maps are kept; without, they are made anew")
    p.add_argument("--show", action="store_true", help="every edit that is asked or wrong, with the reason")
    args = p.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = args.maps or Path(scratch)
        total: Counter[str] = Counter()
        for log in args.logs:
            old = mapped(folder, log, "default", [])
            for name, settings in VARIANTS.items():
                new = mapped(folder, log, name, settings)
                count: Counter[str] = Counter()
                began = time.process_time()
                for seed in range(args.seeds):
                    count += measure(old, new, args.edits, seed, args.show)
                print(row(f"{log}, {name}", count, time.process_time() - began))
                total += count
                new.close()
            old.close()
        print(row("all", total, 0.0))


def row(title: str, count: Counter[str], seconds: float) -> str:
    made = sum(count[k] for k in ("right", "asked", "gone", "wrong"))
    there = made - count["gone"]
    told = f"{count['told right'] + count['told wrong']:3d} of them made and told ({count['told wrong']} wrongly)"
    shares = "  ".join(f"{k} {count[k]:4d}" for k in ("right", "asked", "gone", "wrong"))
    right = f"right {100 * count['right'] / max(made, 1):.1f} % of all, {100 * count['right'] / max(there, 1):.1f} %"
    return f"{title:24s} {shares}  {told}  {right} of what is there  ({seconds:.1f} s)"


def mapped(folder: Path, log: str, name: str, settings: list[str]) -> Project:
    path = folder / f"{log} {name}.rg"
    if Project.exists(path):
        return Project.open(path)
    read = read_log(DATA / f"{log}.log.gz")
    if name == "every 2nd scan":
        read = dataclasses.replace(read[::2], sha256=hashlib.sha256(read.sha256.encode()).hexdigest())
    return Project.create(path, pipeline.run(read, load(None, settings), Cache(folder / "cache")))


def measure(old: Project, new: Project, edits: int, seed: int, show: bool) -> Counter[str]:
    history = edits_by_people(old.base, random.Random(seed), edits)
    same = old.run_info.sha256 == new.run_info.sha256
    drift = Drift(old.trajectory, new.trajectory, same, (old.points, old.point_scans))
    found = rebase(Source(old.run_name, history, drift), new.base)
    judge = Judge(old, new, same, history, found.history)
    for o in found.outcomes:  # what is left out of several is an outcome of its own
        if o.waits and o.entry.edit is not None:
            judge.left[o.key] = ids_of(o.entry.edit)
    count: Counter[str] = Counter()
    for outcome in found.outcomes:
        verdict = judge(outcome)
        if outcome.kind == "shifted":
            count["told right" if verdict == "right" else "told wrong"] += 1
            verdict = "asked"
        count[verdict] += 1
        count[f"{verdict} {type(outcome.entry.edit).__name__}"] += 1
        if show and verdict != "right":
            print(f"   {verdict:6s} {outcome.kind:9s} {type(outcome.entry.edit).__name__:16s} {outcome} {judge.why}")
    return count


class Judge:
    """Whether an edit came to the right thing, by where the scans lie that saw it."""

    def __init__(self, old: Project, new: Project, same: bool, before: History, after: History) -> None:
        a, b = _same_scans(old.trajectory, new.trajectory, same)
        row = np.full(len(old.trajectory), -1)
        row[a] = np.arange(len(a))
        scan = row[old.point_scans]
        self._motion = se2.compose(new.trajectory.map_from_base[b], se2.invert(old.trajectory.map_from_base[a]))
        self._echoes, self._echo_scan = cKDTree(old.points[scan >= 0]), scan[scan >= 0]
        self._robot = cKDTree(old.trajectory.map_from_base[a, :2])
        self.old, self.new = before.base, new.base
        self.final = after.map
        self.done = {d.entry.number: d for d in before.done}
        self.made = {d.entry.number: d for d in after.done}
        self.gone: set[str] = set()
        self.left: dict[Any, set[str]] = {}
        self.why = ""

    def move(self, points: Any, seen: bool = True) -> np.ndarray:
        """Points (K, 2) of the old map in the new one: the median of the motions of the nearest scans."""
        p = np.asarray(points, float).reshape(-1, 2)
        near = self._echo_scan[self._echoes.query(p, k=5)[1]] if seen else self._robot.query(p, k=5)[1]
        return np.median(se2.transform(self._motion[near], p[:, None]), 1)

    def __call__(self, o: Outcome) -> str:
        self.why = ""
        edit = o.entry.edit
        assert edit is not None
        done = self.done[o.entry.number]
        if o.waits:
            things = [t for id in ids_of(edit) if (t := thing(self.old, id)) is not None]
            gone = not all(self.is_there(t) for t in things) or any(id in self.gone for id in ids_of(edit))
            self.gone |= {c.id for c in done.patch if c.before is None} if gone else set()
            return "gone" if gone else "asked"
        if o.edit is None:
            ok = self.holds(done, edit)
        else:
            ok = (
                self.holds(done, edit) if "itself" in o.reason or type(o.edit) is not type(edit) else self.same(o, done)
            )
        return "right" if ok else "wrong"

    def same(self, o: Outcome, done: Done) -> bool:
        assert o.entry.edit is not None
        assert o.edit is not None
        part = ids_of(o.entry.edit) - self.left.get(o.key, set())
        olds = [t for id in part if (t := thing(self.old, id)) is not None]
        news = [t for id in ids_of(o.edit) if (t := thing(self.new, id)) is not None]
        made = [c.after for d in self.done.values() for c in d.patch if is_human_id(c.id) and c.id in part]
        for n in news:  # or it is one that the new map made by itself of what a person had made
            if not stands_in(o.edit, n) and not any(
                self.alike([a], [n], one_way=isinstance(n, Line)) for a in (*olds, *made)
            ):
                self.why = f"[{n.id} is none of {sorted(part)}]"
                return False
        for a in olds:
            on = [n for n in news if type(n) is type(a)]
            if isinstance(a, Line) and o.kind == "applied" and not self.alike([a], on, covered=True):
                self.why = f"[{a.id} is not covered]"
                return False
        for p, q in zip(places_of(o.entry.edit), places_of(o.edit), strict=False):
            if min(math.dist(self.move([p], s)[0], q) for s in (True, False)) > NEAR:
                self.why = f"[{p} -> {q}, not {self.move([p])[0]}]"
                return False
        return self.shaped(done, o)

    def shaped(self, done: Done, o: Outcome) -> bool:
        """Whether the regions that the edit made or changed are of the same shape in the end."""
        after = {c.id: c for d in self.made.values() if d.entry.edit == o.edit for c in d.patch if c.kind == "regions"}
        for c in done.patch:
            n = after.get(c.id)
            made = c.kind == "regions" and is_human_id(c.id) and c.after is not None
            if made and n is not None and not self.alike([c.after], [n.after]):
                self.why = f"[{c.id} has another shape]"
                return False
        return True

    def holds(self, done: Done, edit: Any) -> bool:
        """Whether the new map is as the edit made the old one."""
        about = ids_of(edit)
        for c in done.patch:
            if c.kind not in ("lines", "regions", "gateways", "objects") or (
                c.before is not None and c.id not in about
            ):
                continue
            if c.after is not None and not self.is_there(c.after):
                self.why = f"[{c.id} is not there]"
                return False
            gone_into = [d.after for d in done.patch if d.after is not None and type(d.after) is type(c.before)]
            if c.after is None and self.is_there(c.before) and not gone_into:
                self.why = f"[{c.id} is there still]"
                return False
        return True

    def is_there(self, item: Any) -> bool:
        kinds = {Line: "lines", Region: "regions", Gateway: "gateways", MapObject: "objects"}
        return any(self.alike([item], [n]) for n in getattr(self.new, kinds[type(item)]).values())  # type: ignore[index]

    def alike(self, olds: list[Any], news: list[Any], one_way: bool = False, covered: bool = False) -> bool:
        if not news:
            return False
        a = olds[0]
        if type(a) is not type(news[0]):
            return False
        if isinstance(a, Gateway):
            mid = self.move([np.mean(a.posts, 0)], seen=False)[0]
            return math.dist(mid, np.mean(news[0].posts, 0)) < max(0.5, a.width / 3)
        if isinstance(a, MapObject):
            return math.dist(self.move([a.center[:2]])[0], news[0].center[:2]) < 0.6
        if isinstance(a, Region):
            p = inside(a)
            return _covers(self.move(p, seen=False), np.concatenate([inside(n) for n in news]), 0.25, 0.5, 0.5)
        p, u = along(a)
        q, v = (np.concatenate(x) for x in zip(*(along(n) for n in news), strict=True))
        near = self._echo_scan[self._echoes.query(p, k=5)[1]]
        turn = np.median(self._motion[near, 2], 1)
        w = np.stack(
            [np.cos(turn) * u[:, 0] - np.sin(turn) * u[:, 1], np.sin(turn) * u[:, 0] + np.cos(turn) * u[:, 1]], 1
        )
        old, new = np.hstack([self.move(p), w * 0.5]), np.hstack([q, v * 0.5])
        return _covers(old, new, 0.25, 0.0 if one_way else 0.4, 0.0 if covered else 0.5)


def _covers(a: np.ndarray, b: np.ndarray, near: float, least_a: float, least_b: float) -> bool:
    """Whether points lie on one another: these shares of either have one of the other near."""
    if len(a) == 0 or len(b) == 0:
        return False
    on_b = (cKDTree(b).query(a, distance_upper_bound=near)[0] < near).mean()
    on_a = (cKDTree(a).query(b, distance_upper_bound=near)[0] < near).mean()
    return bool(on_b >= least_a and on_a >= least_b)


def inside(region: Region) -> np.ndarray:
    """Points (K, 2) of a region, on a raster of 0.2 m."""
    shape = polygons.polygon(region.boundary, region.holes)
    low, high = np.array(shape.bounds).reshape(2, 2)
    grid = np.stack(np.meshgrid(*(np.arange(a, b, 0.2) for a, b in zip(low, high, strict=True))), -1).reshape(-1, 2)
    return grid[polygons.locate([shape], grid) == 0]


def along(line: Line) -> tuple[np.ndarray, np.ndarray]:
    """Points (K, 2) of a line, every 5 cm, and its direction at each."""
    a, b = np.array(line.start), np.array(line.end)
    length = max(math.dist(a, b), 1e-9)
    s = np.linspace(0, 1, max(3, int(length / 0.05)))[:, None]
    return a + s * (b - a), np.repeat([(b - a) / length], len(s), 0)


def stands_in(edit: Any, region: Any) -> bool:
    """Whether the region is only the room that a box which the edit makes stands in, and it does stand there."""
    if not isinstance(region, Region) or not isinstance(edit, SeedObject | AddObject):
        return False
    shape = polygons.polygon(region.boundary, region.holes)
    return bool(polygons.locate([shape], np.array([edit.center[:2]]))[0] == 0)


def thing(map: RGMap, id: str) -> Any:
    return next((t[id] for k in ("lines", "regions", "gateways", "objects") if id in (t := getattr(map, k))), None)


if __name__ == "__main__":
    main()
