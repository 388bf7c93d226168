"""Verbs that make maps: of logs, of simulated drives, before one's eyes."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rgviz.cli.telling import tell

if TYPE_CHECKING:
    from rgcore.config import Config


def demo(args: argparse.Namespace) -> None:
    import platformdirs

    from rgviz import app
    from rgviz.demo import LOG

    project = args.project or Path(platformdirs.user_data_dir("rgviz", appauthor=False)) / "demo.rg"
    project.parent.mkdir(parents=True, exist_ok=True)
    mapped = app.view(LOG, host=args.host, port=args.port, open_browser=not args.no_browser, project_path=project)
    sys.exit(0 if mapped else 1)


def run(args: argparse.Namespace) -> None:
    config = _load_config(args)
    from rgcore.scans.read import read_log
    from rgviz.mapping import map_into
    from rgviz.progress import progress_bar

    log = read_log(args.log, _topics(args))
    tell(args.log, log.notes.splitlines())
    path = args.project or Path(args.log.name.split(".")[0] + ".rg")
    with progress_bar() as watch:
        project = map_into(path, log, config, watch)
    with project:
        tell(args.log, project.trajectory.notes)
        _report_outcomes(project)
        _summary(project)


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


def view(args: argparse.Namespace) -> None:
    from rgviz import app

    serving = {"host": args.host, "port": args.port, "open_browser": not args.no_browser}
    shown = {"logs": args.log, "against": args.against, "backdrop": args.backdrop}
    mapped = app.view(args.path, config=_load_config(args), topics=_topics(args), **shown, **serving)
    sys.exit(0 if mapped else 1)


def play(args: argparse.Namespace) -> None:
    from rgviz import app

    serving = {"host": args.host, "port": args.port, "open_browser": not args.no_browser}
    speed: Any = "max" if args.speed == "max" else f"{args.speed}x"
    mapped = app.view(
        args.path, project_path=args.project, config=_load_config(args), topics=_topics(args), play=speed, **serving
    )
    sys.exit(0 if mapped else 1)


def simulate(args: argparse.Namespace) -> None:
    from rgcore.scans.simulate import simulate_to_files

    simulated = simulate_to_files(args.plan, args.log, resolution=args.resolution, seed=args.seed)
    print(f"{args.log}: {len(simulated.log)} scans")


def config(args: argparse.Namespace) -> None:
    from rgcore.config import as_toml

    print(as_toml(_load_config(args)), end="")


def compile(args: argparse.Namespace) -> None:
    """Maps a few scans of the demo log: every kernel is compiled on its first call and kept on disk."""
    from rgcore import pipeline
    from rgcore.scans.read import read_log
    from rgviz.demo import LOG

    pipeline.run(read_log(LOG)[:200])


def _load_config(args: argparse.Namespace) -> Config:
    from rgcore.config import load

    return load(args.config, args.set)


def _topics(args: argparse.Namespace) -> Any:
    from rgcore.scans.bags import Topics

    return Topics(args.scan_topic, args.odom_topic)
