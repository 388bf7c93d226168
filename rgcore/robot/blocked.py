"""Why a robot of some width finds no way, as a sentence: too narrow gateways, none at all, or furniture."""

from __future__ import annotations

import numpy as np

from rgcore.model.records import Gateway, RGMap
from rgcore.robot.route import Roads, Stop


def why_blocked(map: RGMap, roads: Roads, start: Stop, goal: Stop) -> str:
    """What is in the way from ``start`` to ``goal``, between which ``roads`` found no route."""
    a, b = (roads.ids[s.region] for s in (start, goal))
    for called, stop in (("start", start), ("goal", goal)):
        if np.isnan(roads.floors[stop.region].enter(stop.point)).any():
            return f"a robot {roads.width:.2f} m wide does not fit into {roads.ids[stop.region]} at the {called}"
    every = list(map.gateways.values())
    if b not in _around(every, a):
        alone = next((r for r in (b, a) if len(_around(every, r)) == 1), None)
        return f"no gateway leads to {alone}" if alone else f"no chain of gateways joins {a} and {b}"
    if b not in _around(roads.gateways, a):
        return _too_narrow(every, roads, a, b)
    return _too_tight(roads, start, goal)


def _around(gateways: list[Gateway], region: str, without: frozenset[str] = frozenset()) -> frozenset[str]:
    """The regions that a chain of gateways joins to a region, itself included, never entering some."""
    found, todo = {region}, [region]
    while todo:
        here = todo.pop()
        new = {r for g in gateways if here in g.regions for r in g.regions} - found - without
        found |= new
        todo += sorted(new)
    return frozenset(found)


def _too_narrow(every: list[Gateway], roads: Roads, a: str, b: str) -> str:
    """The gateways that would have to be wider, at the end of the way where they are fewer."""
    cuts = []
    for inner, outer in ((b, a), (a, b)):
        near = _around(roads.gateways, inner)
        far = _around(every, outer, without=near)
        cuts.append([g for g in every if near & set(g.regions) and far & set(g.regions)])
    narrow = min(cuts, key=len)
    digits = 3 if any(f"{g.width:.2f}" == f"{roads.width:.2f}" for g in narrow) else 2
    widths = [f"{g.width:.{digits}f} m" for g in narrow]
    through = f"{b} can only be reached from {a} through"
    robot = f"the robot is {roads.width:.{digits}f} m wide"
    if len(narrow) == 1:
        return f"{through} {narrow[0].id}, which is {widths[0]} wide; {robot}"
    names = [f"{g.id} ({w})" for g, w in zip(narrow, widths, strict=True)]
    return f"{through} {', '.join(names[:-1])} or {names[-1]}; {robot}"


def _too_tight(roads: Roads, start: Stop, goal: Stop) -> str:
    """Wide enough gateways, and no way between two of them: the first such region on the way of a point."""
    shapes = {id: f.shape for id, f in zip(roads.ids, roads.floors, strict=True)}
    nothing = dict.fromkeys(roads.ids, np.zeros((0, 2, 2)))
    thin = Roads(shapes, nothing, roads.gateways, 0.0).route(start, goal)
    if thin is None:
        a, b = roads.ids[start.region], roads.ids[goal.region]
        return f"no way from {a} to {b}: gateway-points between them lie outside of their regions"
    reached = {roads.gateways[g].id for g in roads.gateway[roads.reached(start)] if g >= 0}
    stops = ["the start", *thin.gateways, "the goal"]
    k = next((i for i, g in enumerate(thin.gateways) if g not in reached), len(thin.gateways))
    region = thin.regions[min(k, len(thin.regions) - 1)]
    return f"in {region} there is no way {roads.width:.2f} m wide from {stops[k]} to {stops[k + 1]}"
