"""Simulate a building.

Writes the floor plan of two rooms and a door, lets a simulated robot drive through it, maps what it saw and compares
the map with the truth: where the robot was, and where the door is.

    python examples/02_simulate_a_building.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from rgcore import pipeline
from rgcore.exports.formats import export
from rgcore.scans.floor import build_floor
from rgcore.scans.plan import Door, Furniture, Plan, Room
from rgcore.scans.simulate import Simulation, simulate, write_carmen

PLAN = Plan(  # outlines run on the middle lines of the walls: neighbouring rooms share theirs
    name="flat",
    start=(1.0, 1.0, 0.0),
    rooms=(
        Room(name="Hall", outline=((0, 0), (12, 0), (12, 2), (0, 2)), cls="hallway"),
        Room(name="Study", outline=((0, 2), (5, 2), (5, 6), (0, 6))),
        Room(name="Studio", outline=((5, 2), (12, 2), (12, 7), (5, 7))),
    ),
    doors=(Door(at=(1.5, 2)), Door(at=(9, 2), width=1.0)),
    furniture=(
        Furniture(label="cabinet", at=(11.65, 5), size=(0.5, 1.6)),
        Furniture(label="table", at=(3, 4.5), size=(1.6, 0.8), shape="legs"),
    ),
)


def main(folder: Path) -> None:
    simulated = simulate(build_floor(PLAN), Simulation(seed=1))
    write_carmen(simulated.log, folder / "flat.log.gz")
    print(f"{folder / 'flat.log.gz'}: {len(simulated.log)} scans, {simulated.log.stamps[-1]:.0f} s of driving")

    run = pipeline.run(simulated.log)
    drift = simulated.log.odom_from_base - simulated.map_from_base
    error = run.trajectory.map_from_base - simulated.map_from_base
    off = [float(np.hypot(*poses[-1, :2])) for poses in (drift, error)]
    print(f"at the end the odometry is off by {off[0]:.2f} m, the map by {off[1]:.2f} m")

    for gateway in run.map.gateways.values():
        middle = np.mean(gateway.posts, axis=0)
        print(f"{gateway.class_} at ({middle[0]:.2f}, {middle[1]:.2f}), {gateway.width:.2f} m wide")
    export(folder / "flat.svg", run.map)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
