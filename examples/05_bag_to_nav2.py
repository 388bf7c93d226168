"""From a ROS bag to a robot that knows its rooms.

Reads a bag without ROS, maps it, and writes what Nav2 loads: the grid of the walls, masks for slow and forbidden
places, and the graph of ways for its route server, with the doors by name. Says what each format could not carry.

    python examples/05_bag_to_nav2.py [FOLDER] [BAG]
"""

from __future__ import annotations

import sys
from pathlib import Path

from rgcore import pipeline
from rgcore.exports.formats import export
from rgcore.scans.read import read_log

BAG = Path(__file__).parent / "data" / "office.bag"


def main(folder: Path, bag: Path) -> None:
    log = read_log(bag)
    print(f"{log.source}: {len(log)} scans")
    for note in log.notes.splitlines():
        print(f"  {note}")
    map = pipeline.run(log).map
    for name in ("office.yaml", "office.route.geojson"):
        for lost in export(folder / name, map):
            print(f"{name} does not hold {lost}")
    print("\n".join(sorted(p.name for p in folder.iterdir())))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."), Path(sys.argv[2]) if len(sys.argv) > 2 else BAG)
