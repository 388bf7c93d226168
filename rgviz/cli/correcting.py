"""Verbs that change a map or carry it elsewhere and back."""

from __future__ import annotations

import argparse
import sys

from rgcore.errors import RgError
from rgviz.cli.telling import tell


def edit(args: argparse.Namespace) -> None:
    from rgcore.errors import EditError, InputError
    from rgcore.model.edits import decode_edit
    from rgcore.model.project import Project

    try:
        data = sys.stdin.buffer.read() if str(args.edits) == "-" else args.edits.read_bytes()
        lines = data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as e:
        raise InputError(args.edits, "not a text file (UTF-8); write one edit a line as JSON") from e
    with Project.open(args.project) as project:
        done = 0
        for number, line in enumerate(lines, 1):
            if not line.strip():
                continue
            try:
                project.do(decode_edit(line))
            except EditError as e:
                raise InputError(args.edits, f"{e} (the {done} edits before it are kept)", number) from e
            done += 1
        print(f"{args.project}: {done} edits applied")


def export(args: argparse.Namespace) -> None:
    from rgcore.exports.formats import export
    from rgcore.model.project import Project

    with Project.open(args.project) as project:
        options = {k: getattr(args, k) for k in ("wall_height", "resolution", "georeference")}
        lost = export(args.out, project.map, project.trajectory, **options)
    tell(args.out, [f"not in this format: {what}" for what in lost])
    print(args.out)


def import_(args: argparse.Namespace) -> None:
    from rgcore.errors import ProjectError
    from rgcore.exports.readers import read_drawing
    from rgcore.exports.returned import edits_from
    from rgcore.model.project import Project

    drawing = read_drawing(args.drawing, args.georeference)
    with Project.open(args.project) as project:
        back = edits_from(drawing, project.map)
        for why in back.refused:
            print(f"not taken over: {why}", file=sys.stderr)
        if args.apply and project.read_only:
            raise ProjectError(f"{args.project}: is being edited elsewhere; close it there first")
        for edit in back.edits:
            print(edit.title(project.map))
            if args.apply:
                project.do(edit)
    done = "applied" if args.apply else "found; --apply makes them"
    print(f"{args.drawing}: {len(back.edits)} edits {done}")


def classes(args: argparse.Namespace) -> None:
    """Prints a proposal a line; without --apply nothing is changed."""
    from rgcore.model.project import Project
    from rgcore.model.similar import own_classes, propose

    if args.apply and args.learn is None:
        raise RgError("--apply: name the class whose proposals to make edits with --learn NAME")
    others = []
    for path in args.also:
        with Project.open(path) as other:
            others.append(other.map)
    with Project.open(args.project) as project:
        if args.learn is None:
            for name, count in own_classes(project.map).items():
                print(f"{name}: {count} regions")
            return
        found = propose(project.map, args.learn, others)
        for p in found:
            print(f"{p.region} ({project.map.regions[p.region].name}): {args.learn} with {100 * p.score:.0f} %")
            if args.apply:
                project.do(p.edit)
    done = "classed" if args.apply else "proposed"
    print(f"{args.project}: {len(found)} regions {done} as {args.learn}")
