"""The command line. Imports are made inside the commands so that ``rgviz --help`` answers at once."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rgcore import __version__
from rgcore.errors import RgError, one_line

if TYPE_CHECKING:
    from rgcore.config import Config


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit code: 0 done, 1 a one-line error, 2 wrong usage, 130 stopped by Ctrl+C."""
    args = _parser().parse_args(argv)
    try:
        args.command(args)
        return 0
    except KeyboardInterrupt:
        return _stopped()
    except BrokenPipeError:
        sys.stderr.close()
        return 0
    except (RgError, OSError) as e:
        if args.debug:
            raise
        print(f"rgviz: {one_line(e)}", file=sys.stderr)
        return 1
    except MemoryError as e:
        if args.debug:
            raise
        print(f"rgviz: not enough memory ({one_line(e) or 'none left'}); close other programs", file=sys.stderr)
        return 1
    except Exception as e:
        if _by_ctrl_c(e):
            return _stopped()
        if args.debug:
            raise
        fault = f"{type(e).__name__}: {one_line(e)}"
        print(f"rgviz: a fault in rgviz: {fault}; run it again with --debug and report what it says", file=sys.stderr)
        return 1


def _stopped() -> int:
    print("stopped", file=sys.stderr)
    return 130


def _by_ctrl_c(e: BaseException | None) -> bool:
    """Whether an error only wraps a Ctrl+C: compiled kernels turn one that meets them into a SystemError."""
    while e is not None and not isinstance(e, KeyboardInterrupt):
        e = e.__cause__ or e.__context__
    return e is not None


def _parser() -> argparse.ArgumentParser:
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--debug", action="store_true", help="show the traceback of an error")

    settings = argparse.ArgumentParser(add_help=False)
    settings.add_argument(
        "--set", action="append", default=[], metavar="STAGE.NAME=VALUE", help="one setting; see `rgviz config`"
    )
    settings.add_argument("--config", type=Path, metavar="FILE.toml", help="settings from a file")

    bag = argparse.ArgumentParser(add_help=False)
    bag.add_argument("--scan-topic", metavar="TOPIC", help="of a bag with several lasers; see `rgviz info BAG`")
    bag.add_argument("--odom-topic", metavar="TOPIC", help="of a bag with several odometries")

    serving = argparse.ArgumentParser(add_help=False)
    serving.add_argument("--host", default="127.0.0.1", help="address to serve on (default: this machine only)")
    serving.add_argument(
        "--port", type=int, default=8080, help="port to serve on; the next free one is taken (default: 8080)"
    )
    serving.add_argument("--no-browser", action="store_true", help="print the link instead of opening a browser")

    p = argparse.ArgumentParser(
        prog="rgviz",
        description="RG mapping: from a robot's laser log to a compact, structured, named and correctable map.",
    )
    p.add_argument("--version", action="version", version=f"rgviz {__version__}")
    sub = p.add_subparsers(metavar="COMMAND", required=True)

    def command(name: str, run: Any, text: str, *parents: argparse.ArgumentParser) -> argparse.ArgumentParser:
        c = sub.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".", parents=[common, *parents])
        c.set_defaults(command=run)
        return c

    c = command("demo", _demo, "map the log that ships with rgviz and open it in the browser", serving)
    c.add_argument("-o", "--project", type=Path, metavar="PROJECT.rg", help="where the demo's project is kept")
    c = command("run", _run, "map a log; on an existing project: a new run that keeps the edits", settings, bag)
    c.add_argument("log", type=Path, metavar="LOG")
    c.add_argument("-o", "--project", type=Path, metavar="PROJECT.rg", help="default: the log's name, here")
    c = command("view", _view, "open a project, or map a log first, in the browser", settings, bag, serving)
    c.add_argument("path", type=Path, metavar="PROJECT.rg|LOG")
    c = command("play", _play, "watch how a log is mapped, at its own pace or faster", settings, bag, serving)
    c.add_argument("path", type=Path, metavar="LOG|PROJECT.rg")
    c.add_argument("-o", "--project", type=Path, metavar="PROJECT.rg", help="default: the log's name, here")
    c.add_argument("--speed", choices=("1", "4", "max"), default="4", help="times the log's own pace (default: 4)")
    c = command("edit", _edit, "apply edits without the browser")
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("edits", type=Path, metavar="EDITS.jsonl", help="one edit a line; - for standard input")
    c = command("export", _export, "write the corrected map; the format goes by the ending")
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("out", type=Path, metavar="OUT.EXT")
    c.add_argument("--wall-height", type=float, default=2.5, metavar="M", help="height of walls in .glb (default: 2.5)")
    c.add_argument("--resolution", type=float, default=0.05, metavar="M", help="cells of the grid in .yaml (0.05)")
    c.add_argument(
        "--georeference",
        type=_georeference,
        metavar="LAT,LON[,DEGREES]",
        help="where the origin lies (WGS 84), and the x axis against east; for .geojson .fg.json .osm",
    )
    c = command("report", _report, "write a page on how compact and how true the map is, with all its figures")
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("-o", "--out", type=Path, metavar="OUT.html", help="default: the project's name, here")
    c = command("import", _import, "edits out of a map that was edited elsewhere: .geojson .fg.json .dxf .osm .json")
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("drawing", type=Path, metavar="FILE")
    c.add_argument("--apply", action="store_true", help="make the edits; without it they are listed only")
    c.add_argument(
        "--georeference", type=_georeference, metavar="LAT,LON[,DEGREES]", help="the one that it was exported with"
    )
    c = command("measure", _measure, "counts, reduction factor, accuracy by region and for the map")
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("--json", action="store_true", help="as JSON")
    g = c.add_argument_group("accuracy of the trajectory by known relative poses (Kuemmerle et al. 2009)")
    g.add_argument(
        "--relations", type=Path, metavar="FILE", help="`t1 t2 x y z roll pitch yaw` or `EDGE2 i j x y theta`"
    )
    g.add_argument("--odometry", type=Path, metavar="CSV", help="raw odometry, for relations between the scans' times")
    g.add_argument("--rows", type=_two_numbers, metavar="FIRST,STEP", help="relations name rows of the odometry")
    g.add_argument(
        "--forward", type=float, default=0.0, metavar="M", help="their frame lies this far ahead of the laser"
    )
    g.add_argument("--loops", action="store_true", help="of a graph, only the relations after #LOOP EDGES")
    c = command("lint", _lint, "what looks wrong in a map: gateways, regions and walls that a person should look at")
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("--robot-width", type=float, metavar="M", help="width of the robot (default: that of places)")
    c.add_argument("--all", action="store_true", help="findings that a person lets stand as well")
    c.add_argument("--json", action="store_true", help="as JSON, a remedy as an edit for `rgviz edit`")
    c = command("find", _find, "items of a map by a search like 'class:TOMA accuracy>0.2 edited:yes'")
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("search", metavar="SEARCH")
    c = command("classes", _classes, "classes that people gave, and other regions that are like them")
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("--learn", metavar="NAME", help="propose regions like those that a person classed NAME")
    c.add_argument("--also", type=Path, action="append", default=[], metavar="OTHER.rg", help="learn from its too")
    c.add_argument("--apply", action="store_true", help="make the proposals edits of the project")
    c = command("diff", _diff, "what is different in map B: regions, gateways, walls, objects")
    for name in "ab":
        text = "a project, one of its runs (PROJECT.rg/runs/0001) or an exported map"
        c.add_argument(name, type=Path, metavar=f"{name.upper()}.rg|RUN|{name.upper()}.json", help=text)
    form = c.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="as JSON, with ids, places and colours")
    form.add_argument("--markdown", action="store_true", help="as Markdown")
    c = command("simulate", _simulate, "drive a simulated robot through a floor plan")
    c.add_argument("plan", type=Path, metavar="PLAN", help="floor plan: JSON, or an image with --resolution")
    c.add_argument(
        "-o", "--log", type=Path, required=True, metavar="LOG", help="CARMEN log to write; the truth goes beside it"
    )
    c.add_argument("--resolution", type=float, metavar="M", help="size of a pixel of a floor-plan image")
    c.add_argument("--seed", type=int, default=0, help="of noise and odometry drift (default: 0)")
    c = command("info", _info, "what is in a log, a bag, a grid map or a map, without mapping it")
    c.add_argument("file", type=Path, metavar="FILE")
    c.add_argument("--json", action="store_true", help="as JSON")
    command("config", _config, "every setting with default, unit and reason, as TOML", settings)
    command("compile", _compile, "compile the numeric kernels ahead of the first run")
    return p


def _load_config(args: argparse.Namespace) -> Config:
    from rgcore.config import load

    return load(args.config, args.set)


def _demo(args: argparse.Namespace) -> None:
    import platformdirs

    from rgviz import app
    from rgviz.demo import LOG

    project = args.project or Path(platformdirs.user_data_dir("rgviz", appauthor=False)) / "demo.rg"
    project.parent.mkdir(parents=True, exist_ok=True)
    mapped = app.view(LOG, host=args.host, port=args.port, open_browser=not args.no_browser, project_path=project)
    sys.exit(0 if mapped else 1)


def _topics(args: argparse.Namespace) -> Any:
    from rgcore.scans.bags import Topics

    return Topics(args.scan_topic, args.odom_topic)


def _view(args: argparse.Namespace) -> None:
    from rgviz import app

    serving = {"host": args.host, "port": args.port, "open_browser": not args.no_browser}
    mapped = app.view(args.path, config=_load_config(args), topics=_topics(args), **serving)
    sys.exit(0 if mapped else 1)


def _play(args: argparse.Namespace) -> None:
    from rgviz import app

    serving = {"host": args.host, "port": args.port, "open_browser": not args.no_browser}
    speed: Any = "max" if args.speed == "max" else f"{args.speed}x"
    mapped = app.view(
        args.path, project_path=args.project, config=_load_config(args), topics=_topics(args), play=speed, **serving
    )
    sys.exit(0 if mapped else 1)


def _run(args: argparse.Namespace) -> None:
    config = _load_config(args)
    from rgcore.scans.read import read_log
    from rgviz.mapping import map_into
    from rgviz.progress import progress_bar

    log = read_log(args.log, _topics(args))
    _tell(args.log, log.notes.splitlines())
    path = args.project or Path(args.log.name.split(".")[0] + ".rg")
    with progress_bar() as watch:
        project = map_into(path, log, config, watch)
    with project:
        _tell(args.log, project.trajectory.notes)
        _report_outcomes(project)
        _summary(project)


def _tell(log: Path, notes: Sequence[str]) -> None:
    for note in notes:
        print(f"{log}: {note}", file=sys.stderr)


def _report_outcomes(project: Any) -> None:
    """What became of the edits in the new run: how many, and each that a person should look at."""
    for o in project.outcomes:
        if o.kind == "shifted":
            print(f"edit shifted: {o}", file=sys.stderr)
    for o in project.conflicts:
        remedies = ", ".join(r.name for r in o.remedies)
        print(f"edit not carried over: {o}{f' ({remedies})' if remedies else ''}", file=sys.stderr)
    if project.outcomes:
        kinds = [o.kind for o in project.outcomes]
        counts = [f"{kinds.count(k)} {k}" for k in ("applied", "shifted", "conflict", "stale") if k in kinds]
        print(f"{project.path}: {len(kinds)} edits carried to run {project.run_name}: {', '.join(counts)}")


def _summary(project: Any) -> None:
    m, s = project.map, project.map.stats
    factor = s.segments / max(len(m.lines), 1)
    print(
        f"{project.path}: {s.scans} scans, {s.points} points, {s.segments} segments -> {len(m.lines)} lines"
        f" (factor {factor:.1f}), {len(m.regions)} regions, {len(m.gateways)} gateways, {len(m.objects)} objects"
    )


def _edit(args: argparse.Namespace) -> None:
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


def _export(args: argparse.Namespace) -> None:
    from rgcore.exports.formats import export
    from rgcore.model.project import Project

    with Project.open(args.project) as project:
        options = {k: getattr(args, k) for k in ("wall_height", "resolution", "georeference")}
        lost = export(args.out, project.map, project.trajectory, **options)
    _tell(args.out, [f"not in this format: {what}" for what in lost])
    print(args.out)


def _report(args: argparse.Namespace) -> None:
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


def _import(args: argparse.Namespace) -> None:
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


def _measure(args: argparse.Namespace) -> None:
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


def _georeference(text: str) -> Any:
    import math

    from rgcore.exports.options import Georeference

    try:
        latitude, longitude, *turn = (float(word) for word in text.split(","))
        if len(turn) > 1 or not all(map(math.isfinite, (latitude, longitude, *turn))):
            raise ValueError
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not LAT,LON or LAT,LON,DEGREES") from None
    return Georeference(latitude, longitude, math.radians(turn[0]) if turn else 0.0)


def _two_numbers(text: str) -> tuple[int, int]:
    first, _, step = text.partition(",")
    return int(first), int(step)


def _simulate(args: argparse.Namespace) -> None:
    from rgcore.scans.simulate import simulate_to_files

    simulated = simulate_to_files(args.plan, args.log, resolution=args.resolution, seed=args.seed)
    print(f"{args.log}: {len(simulated.log)} scans")


def _lint(args: argparse.Namespace) -> None:
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


def _find(args: argparse.Namespace) -> None:
    from rgcore.model.find import find
    from rgcore.model.project import Project

    with Project.open(args.project) as project:
        for id in find(project.map, args.search):
            print(id)


def _classes(args: argparse.Namespace) -> None:
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


def _diff(args: argparse.Namespace) -> None:
    """Prints the differences; the exit code stays 0: a difference is no error."""
    from rgcore.model.diff import diff, join
    from rgcore.model.diff_text import as_json, as_markdown, as_text

    (old, before), (new, after) = _compared(args.a), _compared(args.b)
    found = diff(old, new, join(old, new, before, after))
    form = as_json if args.json else as_markdown if args.markdown else as_text
    print(form(found).rstrip())


def _compared(path: Path) -> tuple[Any, Any]:
    """The corrected map and the trajectory (None if unknown) of a project, a run of one, or an exported map."""
    from rgcore.exports.rgjson import read_json
    from rgcore.model import folder
    from rgcore.model.rerun import read_run

    if path.suffix == ".json" or path.is_file():
        return read_json(path), None
    if path.parent.name == "runs" and (path / "base.json").exists():
        folder.check(path.parent.parent)
    else:
        folder.check(path)
        path = path / "runs" / folder.current(path)
    history, trajectory = read_run(path)
    return history.map, trajectory


def _info(args: argparse.Namespace) -> None:
    from rgviz.info import describe, print_description

    found = describe(args.file)
    if args.json:
        import json

        print(json.dumps(found, indent=1, sort_keys=True))
    else:
        print_description(found)


def _config(args: argparse.Namespace) -> None:
    from rgcore.config import as_toml

    print(as_toml(_load_config(args)), end="")


def _compile(args: argparse.Namespace) -> None:
    """Maps a few scans of the demo log: every kernel is compiled on its first call and kept on disk."""
    from rgcore import pipeline
    from rgcore.scans.read import read_log
    from rgviz.demo import LOG

    pipeline.run(read_log(LOG)[:200])


if __name__ == "__main__":
    sys.exit(main())
