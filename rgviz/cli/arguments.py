"""What can be written after ``rgviz``: the verbs with their arguments, and what of them reads as what."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from rgcore import __version__
from rgviz.cli import correcting, making, reading


def parser() -> argparse.ArgumentParser:
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

    c = command("demo", making.demo, "map the log that ships with rgviz and open it in the browser", serving)
    c.add_argument("-o", "--project", type=Path, metavar="PROJECT.rg", help="where the demo's project is kept")
    c = command("run", making.run, "map a log; on an existing project: a new run that keeps the edits", settings, bag)
    c.add_argument("log", type=Path, metavar="LOG")
    c.add_argument("-o", "--project", type=Path, metavar="PROJECT.rg", help="default: the log's name, here")
    c = command("view", making.view, "open a project, or map a log first, in the browser", settings, bag, serving)
    c.add_argument("path", type=Path, metavar="PROJECT.rg|LOG")
    c.add_argument("--backdrop", type=Path, metavar="PLAN", help="a floor plan to lay under the map: png, jpg or DXF")
    c.add_argument(
        "--log",
        type=Path,
        action="append",
        default=[],
        metavar="LOG",
        help="a log that may be mapped again from the page",
    )
    c.add_argument(
        "--against", type=Path, action="append", default=[], metavar="OTHER.rg|RUN|MAP.json",
        help="a map to compare with: what is different is shown in colours",
    )  # fmt: skip
    c = command("play", making.play, "watch how a log is mapped, at its own pace or faster", settings, bag, serving)
    c.add_argument("path", type=Path, metavar="LOG|PROJECT.rg")
    c.add_argument("-o", "--project", type=Path, metavar="PROJECT.rg", help="default: the log's name, here")
    c.add_argument("--speed", choices=("1", "4", "max"), default="4", help="times the log's own pace (default: 4)")
    c = command("edit", correcting.edit, "apply edits without the browser")
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("edits", type=Path, metavar="EDITS.jsonl", help="one edit a line; - for standard input")
    c = command("export", correcting.export, "write the corrected map; the format goes by the ending")
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
    c = command("report", reading.report, "write a page on how compact and how true the map is, with all its figures")
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("-o", "--out", type=Path, metavar="OUT.html", help="default: the project's name, here")
    c = command(
        "import", correcting.import_, "edits out of a map that was edited elsewhere: .geojson .fg.json .dxf .osm .json"
    )
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("drawing", type=Path, metavar="FILE")
    c.add_argument("--apply", action="store_true", help="make the edits; without it they are listed only")
    c.add_argument(
        "--georeference", type=_georeference, metavar="LAT,LON[,DEGREES]", help="the one that it was exported with"
    )
    c = command("measure", reading.measure, "counts, reduction factor, accuracy by region and for the map")
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
    c = command(
        "lint", reading.lint, "what looks wrong in a map: gateways, regions and walls that a person should look at"
    )
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("--robot-width", type=float, metavar="M", help="width of the robot (default: that of places)")
    c.add_argument("--all", action="store_true", help="findings that a person lets stand as well")
    c.add_argument("--json", action="store_true", help="as JSON, a remedy as an edit for `rgviz edit`")
    c = command("find", reading.find, "items of a map by a search like 'class:TOMA accuracy>0.2 edited:yes'")
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("search", metavar="SEARCH")
    c = command("classes", correcting.classes, "classes that people gave, and other regions that are like them")
    c.add_argument("project", type=Path, metavar="PROJECT.rg")
    c.add_argument("--learn", metavar="NAME", help="propose regions like those that a person classed NAME")
    c.add_argument("--also", type=Path, action="append", default=[], metavar="OTHER.rg", help="learn from its too")
    c.add_argument("--apply", action="store_true", help="make the proposals edits of the project")
    c = command("diff", reading.diff, "what is different in map B: regions, gateways, walls, objects")
    for name in "ab":
        text = "a project, one of its runs (PROJECT.rg/runs/0001) or an exported map"
        c.add_argument(name, type=Path, metavar=f"{name.upper()}.rg|RUN|{name.upper()}.json", help=text)
    form = c.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="as JSON, with ids, places and colours")
    form.add_argument("--markdown", action="store_true", help="as Markdown")
    c = command("simulate", making.simulate, "drive a simulated robot through a floor plan")
    c.add_argument("plan", type=Path, metavar="PLAN", help="floor plan: JSON, or an image with --resolution")
    c.add_argument(
        "-o", "--log", type=Path, required=True, metavar="LOG", help="CARMEN log to write; the truth goes beside it"
    )
    c.add_argument("--resolution", type=float, metavar="M", help="size of a pixel of a floor-plan image")
    c.add_argument("--seed", type=int, default=0, help="of noise and odometry drift (default: 0)")
    c = command("info", reading.info, "what is in a log, a bag, a grid map or a map, without mapping it")
    c.add_argument("file", type=Path, metavar="FILE")
    c.add_argument("--json", action="store_true", help="as JSON")
    command("config", making.config, "every setting with default, unit and reason, as TOML", settings)
    command("compile", making.compile, "compile the numeric kernels ahead of the first run")
    return p


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
