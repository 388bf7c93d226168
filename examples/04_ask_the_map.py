"""Ask the map.

What a robot asks of a map, one call a question. Maps the demo and asks where the robot stands, which gateways it fits
through, what is in the rooms and how far its laser would see; then for a way between the two rooms that are farthest
apart, why a wider robot has none, and where there is still something to explore.

    python examples/04_ask_the_map.py [FOLDER]
"""

from __future__ import annotations

import sys
from itertools import combinations
from pathlib import Path

import numpy as np

from rgcore import pipeline
from rgcore.errors import NoRoute
from rgcore.exports.formats import render
from rgcore.robot.query import Query
from rgcore.scans.read import read_log
from rgviz.demo import LOG

WIDTH = 0.6


def main(folder: Path) -> None:
    run = pipeline.run(read_log(LOG))
    ask = Query(run.map)
    poses = run.trajectory.map_from_laser

    here = ask.region_at(*poses[0, :2])
    if here is not None:
        print(f"at the start: {here.name} ({here.id}, {here.class_})")
    print(f"{np.mean(ask.region_of(poses[:, :2]) >= 0):.1%} of all poses are in a region")
    gateways = ask.gateways_from(poses[0], width=WIDTH)
    print(f"{len(gateways)} gateways to go through from here: {', '.join(g.id for g in gateways)}")
    for region in list(run.map.regions)[1:4]:
        print(f"in {region}: {', '.join(o.label for o in ask.objects_in(region)) or 'nothing'}")
    ranges = ask.predicted_scan(poses[0], np.radians([-90, 0, 90]), max_range=50.0)
    print(f"a laser here would see {ranges[0]:.2f} m right, {ranges[1]:.2f} m ahead, {ranges[2]:.2f} m left")

    route = max((ask.route(a, b, WIDTH) for a, b in combinations(run.map.regions, 2)), key=lambda r: r.length)
    print(f"{' > '.join(route.regions)} through {', '.join(route.gateways)}: {route.length:.1f} m")
    print(f"{len(route.waypoints)} waypoints, the first at {route.waypoints[0].round(2).tolist()}")
    try:
        ask.route(route.regions[0], route.regions[-1], width=1.2)
    except NoRoute as error:
        print(error)
    print(f"not yet passed: {', '.join(g.id for g in ask.unexplored()) or 'none'}")

    picture = render(".svg", run.map).decode()
    way = " ".join(f"{x:.2f},{-y:.2f}" for x, y in route.waypoints)  # a drawing's y runs down
    line = f'<polyline points="{way}" fill="none" stroke="#c2410c" stroke-width="0.15" stroke-dasharray="0.4 0.25"/>'
    (folder / "route.svg").write_text(picture.replace("</svg>", line + "</svg>"), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
