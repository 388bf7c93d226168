"""From a grid map to a 3D model.

Many have no log any more, only the grid that another mapper saved. Its free cells are looked at by a virtual laser, so
the same stages find lines, rooms and doors; there is no accuracy, since nothing was measured, and the map says so.

    python examples/06_grid_to_3d.py [FOLDER] [MAP.yaml]
"""

from __future__ import annotations

import sys
from pathlib import Path

from rgcore import pipeline
from rgcore.exports.formats import export
from rgcore.scans.read import read_log

GRID = Path(__file__).parent / "data" / "office.yaml"


def main(folder: Path, grid: Path) -> None:
    map = pipeline.run(read_log(grid)).map
    print(f"{len(map.lines)} lines, {len(map.regions)} regions, {len(map.gateways)} gateways")
    for region in map.regions.values():
        accuracy = "no accuracy" if region.accuracy is None else f"{region.accuracy:.3f} m"
        print(f"  {region.id:<4} {region.name:<20} {region.class_:<5} {accuracy}")
    export(folder / "office.glb", map, wall_height=2.2)
    print(folder / "office.glb")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."), Path(sys.argv[2]) if len(sys.argv) > 2 else GRID)
