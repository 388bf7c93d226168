"""Map a log.

Reads the log that ships with rgviz, runs the whole pipeline on it, prints what the map holds and writes it in three
formats: the map itself (JSON), a drawing (SVG) and a 3D model (glTF).

    python examples/01_map_a_log.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

from rgcore import pipeline
from rgcore.exports.formats import export
from rgcore.scans.read import read_log
from rgviz.demo import LOG


def main(folder: Path) -> None:
    log = read_log(LOG)
    print(f"{log.source}: {len(log)} scans of {len(log.bearings)} beams")

    run = pipeline.run(log)
    map = run.map
    for stage, seconds in run.seconds.items():
        print(f"  {stage:<10} {seconds:6.2f} s")
    print(f"{map.stats.segments} segments became {len(map.lines)} lines")

    for region in map.regions.values():
        doors = len(map.gateways_of(region.id))
        print(f"  {region.id:<4} {region.class_:<5} {len(map.lines_of(region.id)):4} lines {doors:3} gateways")

    for ending in (".json", ".svg", ".glb"):
        export(folder / f"office{ending}", map, run.trajectory)
        print(folder / f"office{ending}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
