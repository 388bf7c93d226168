"""Relabel by script.

What a person does in the browser a script can do as well: it makes the same edits, in the same journal. Makes a project
of the first rooms of the demo, renames and relabels a region, takes one edit back, tries one that the map refuses, and
opens the project again: the corrections are still there.

    python examples/03_relabel_by_script.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

from rgcore import pipeline
from rgcore.errors import EditError
from rgcore.exports.formats import export
from rgcore.model.edits import ClassifyRegion, RenameRegion
from rgcore.model.project import Project
from rgcore.scans.read import read_log
from rgviz.demo import LOG


def main(folder: Path) -> None:
    run = pipeline.run(read_log(LOG)[:500])
    path = folder / "rooms.rg"

    with Project.create(path, run) as project:
        first = next(iter(project.map.regions))
        project.do(RenameRegion(region=first, name="Entrance"), by="script")
        project.do(ClassifyRegion(region=first, class_="LOBBY"), by="script")
        print(f"{first} is {project.map.regions[first].name}, class {project.map.regions[first].class_}")
        project.undo(by="script")
        print(f"after undo: class {project.map.regions[first].class_}; redo would {project.history.redo_title}")
        try:
            project.do(RenameRegion(region="r999", name="Attic"))
        except EditError as error:
            print(f"refused: {error}")

    with Project.open(path) as project:
        region = project.map.regions[first]
        print(f"reopened: {region.name}, {region.provenance.source} by {region.provenance.by}")
        export(folder / "rooms.svg", project.map)
        print((path / "runs" / project.run_name / "edits.jsonl").read_text(), end="")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
