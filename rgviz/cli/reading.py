"""Verbs that tell about a log or a map and change nothing."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from rgcore.errors import RgError


def info(args: argparse.Namespace) -> None:
    from rgviz.info import describe, print_description

    found = describe(args.file)
    if args.json:
        import json

        print(json.dumps(found, indent=1, sort_keys=True))
    else:
        print_description(found)


def report(args: argparse.Namespace) -> None:
    from rgcore.exports.report import report
    from rgcore.model.disk import replace_file
    from rgcore.model.project import Project

    with Project.open(args.project) as project:
        out = args.out or Path(f"{args.project.stem}.html")
        page = report(project)
    try:
        replace_file(out, page.encode())
    except OSError as e:
        raise RgError(f"{out}: cannot be written: {e.strerror or e}; choose another place") from e
    print(out)


def measure(args: argparse.Namespace) -> None:
    from rgcore.model.project import Project
    from rgviz.measure import figures, print_tables

    with Project.open(args.project) as project:
        result = figures(project)
        if args.relations is not None:
            result["relations"] = _relation_figures(project, args)
    if args.json:
        import json

        print(json.dumps(result, indent=1, sort_keys=True))
    else:
        print_tables(result)


def _relation_figures(project: Any, args: argparse.Namespace) -> dict[str, float]:
    from rgcore.slam.relations import read_odometry, read_relations, relation_error
    from rgviz.measure import relation_figures

    if args.rows is not None and args.odometry is None:
        raise RgError("--rows: names rows of the odometry; give that with --odometry CSV")
    relations = read_relations(args.relations, args.loops)
    odometry = read_odometry(args.odometry) if args.odometry is not None else None
    return relation_figures(relation_error(project.trajectory, relations, odometry, args.rows, args.forward))


def lint(args: argparse.Namespace) -> None:
    """Prints a finding a line; the exit code stays 0: a finding is for a person to judge."""
    import json

    import msgspec

    from rgcore.model.lint import ROBOT_WIDTH, lint
    from rgcore.model.project import Project

    width = ROBOT_WIDTH if args.robot_width is None else args.robot_width
    if not 0 <= width < 100:
        raise RgError(f"--robot-width {width:g}: must be metres, 0 or more")
    with Project.open(args.project) as project:
        found = lint(project.map, width, args.all)
    if args.json:
        rows = [
            {
                "id": f.id,
                "code": f.code,
                "items": f.items,
                "text": f.text,
                "place": f.place,
                "remedy": msgspec.to_builtins(f.remedy) if f.remedy is not None else None,
            }
            for f in found
        ]
        print(json.dumps(rows, indent=1))
        return
    for f in found:
        print(f"{f.code}: {f.text} (at {f.place[0]:.2f}, {f.place[1]:.2f})")


def find(args: argparse.Namespace) -> None:
    from rgcore.model.find import find
    from rgcore.model.project import Project

    with Project.open(args.project) as project:
        for id in find(project.map, args.search):
            print(id)


def diff(args: argparse.Namespace) -> None:
    """Prints the differences; the exit code stays 0: a difference is no error."""
    from rgcore.model.diff import diff, join
    from rgcore.model.diff_text import as_json, as_markdown, as_text
    from rgviz.again.others import read_map

    (old, before), (new, after) = read_map(args.a), read_map(args.b)
    found = diff(old, new, join(old, new, before, after))
    form = as_json if args.json else as_markdown if args.markdown else as_text
    print(form(found).rstrip())
