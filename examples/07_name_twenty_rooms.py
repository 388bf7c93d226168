"""Name twenty rooms by script, and list what is left to check.

The names come as a table, as an office would give them: a place in each room, its name and its use. The room is the
region at that place, so the table stays right when the map is made again. What is still doubtful goes into a CSV.

    python examples/07_name_twenty_rooms.py [FOLDER]
"""

from __future__ import annotations

import csv
import json
import math
import sys
from pathlib import Path

from rgcore import pipeline
from rgcore.exports.formats import export
from rgcore.geometry.polygons import label_place
from rgcore.model.doubt import work_list
from rgcore.model.edits import ClassifyRegion, Confirm, RenameRegion, Several
from rgcore.model.lint import lint
from rgcore.model.project import Project
from rgcore.robot.query import Query
from rgcore.scans.read import read_log
from rgviz.demo import LOG, PLAN


def around(place: tuple[float, float]) -> list[tuple[float, float]]:
    """A place and others a good metre about it: there may be a cabinet where somebody pointed to."""
    x, y = place
    return [place, *((x + 1.2 * math.cos(a), y + 1.2 * math.sin(a)) for a in range(6))]


def main(folder: Path) -> None:
    rooms = json.loads(PLAN.read_text())["rooms"]
    table = [(label_place(r["outline"], r.get("holes", ()))[0], r["name"], r.get("class", "TOMA")) for r in rooms]
    with Project.create(folder / "office.rg", pipeline.run(read_log(LOG))) as project:
        here = Query(project.map)
        named = 0
        for place, name, use in table[:20]:
            region = next(filter(None, (here.region_at(*at) for at in around(place))), None)
            if region is None:
                print(f"no region at {place} for {name}")
                continue
            steps = (RenameRegion(region=region.id, name=name), ClassifyRegion(region=region.id, class_=use))
            project.do(Several(name=f"name {name}", edits=(*steps, Confirm(items=(region.id,)))), by="script")
            named += 1
        print(f"{named} rooms named; undo would take back: {project.history.undo_title}")

        export(folder / "office.svg", project.map)
        doubts = work_list(project.map, lint(project.map))
        with (folder / "to_check.csv").open("w", newline="", encoding="utf-8") as f:
            rows = csv.writer(f)
            rows.writerow(("item", "kind", "doubt", "x", "y", "why"))
            rows.writerows((d.item, d.kind, f"{d.score:.2f}", *d.place, "; ".join(d.reasons)) for d in doubts)
        print(f"{len(doubts)} items left to check, in to_check.csv")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
