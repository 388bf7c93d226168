"""Damage files of every format and read them: ``tests/bench/fuzz_readers.py [--seconds S] [--seed N] [READER ...]``.

A reader may read what is left or refuse it in a line. A traceback, a hang of more than ``LONGEST`` seconds or more than
``MEMORY`` is a finding; its file is kept in the folder that is printed. Seeds are small files that rgviz makes itself.
"""

from __future__ import annotations

import argparse
import logging
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

sys.path += [str(Path(__file__).parents[1] / name) for name in ("scans", "exports")]

import make_plans
from export_maps import ROOMS
from make_bags import Bag, drive

from rgcore.errors import RgError
from rgcore.exports.formats import export
from rgcore.exports.readers import read_drawing
from rgcore.scans.backdrop import read_backdrop, read_file
from rgcore.scans.plan import read_plan
from rgcore.scans.plan_image import read_floor_image
from rgcore.scans.read import read_log
from rgcore.slam.relations import read_odometry, read_relations
from rgviz.demo import LOG, PLAN

LONGEST = 10  # s
MEMORY = 4 << 30  # bytes

Seed = Callable[[Path], Path]
Read = Callable[[Path], Any]


def seeds(folder: Path) -> dict[str, tuple[Path, Path, Read]]:
    """By reader: the path to read, the file to damage, the reader."""
    log = read_log(LOG)[:20]
    lines = LOG.read_bytes()
    import gzip

    text = b"".join(gzip.decompress(lines).splitlines(keepends=True)[:20])
    (folder / "a.log").write_bytes(text)
    (folder / "b.log.gz").write_bytes(gzip.compress(text))
    beams = " ".join(str(100 + k) for k in range(180))
    rows = (f"O {k} 0 0.1 {k / 10}\nL {k} 0 0.1 {beams} {k / 10}\n" for k in range(10))
    (folder / "wean.txt").write_text("".join(rows))
    log.save(folder / "a.npz")
    heading = ",".join(["stamp", "x", "y", "theta", *(f"range_{k}" for k in range(20))])
    cells = (",".join(["0", "0", "0", "0", *(f"{v:.2f}" for v in row[:20])]) for row in log.ranges)
    (folder / "a.csv").write_text("\n".join([heading, *cells]) + "\n")
    one, two, mcap = drive(Bag(1)).write(folder / "one.bag"), drive(Bag()).write(folder / "two"), folder / "mcap"
    drive(Bag()).write(mcap, "mcap")
    (folder / "grid").mkdir()
    export(folder / "grid" / "a.yaml", ROOMS, resolution=0.2)
    plan, image, relations, odometry = (folder / n for n in ("a.plan.json", "a.png", "a.relations", "odometry.csv"))
    plan.write_bytes(PLAN.read_bytes())
    image.write_bytes(cv2.imencode(".png", cv2.imread(str(folder / "grid" / "a.pgm")))[1].tobytes())
    plans = [folder / f"plan.{kind}" for kind in ("png", "jpg", "dxf")]
    for file, data in zip(plans, (make_plans.image(), make_plans.image(".jpg"), make_plans.drawing()), strict=True):
        file.write_bytes(data)
    relations.write_text("".join(f"{k} {k + 1} 0.5 0 0 0 0 0.1\n" for k in range(20)))
    odometry.write_text("".join(f"{k},0,{k / 2},0,0.1\n" for k in range(20)))
    found: dict[str, tuple[Path, Path, Read]] = {
        "carmen": (folder / "a.log", folder / "a.log", read_log),
        "gzip": (folder / "b.log.gz", folder / "b.log.gz", read_log),
        "wean": (folder / "wean.txt", folder / "wean.txt", read_log),
        "npz": (folder / "a.npz", folder / "a.npz", read_log),
        "csv": (folder / "a.csv", folder / "a.csv", read_log),
        "bag1": (one, one, read_log),
        "bag2-db3": (two, next(two.glob("*.db3")), read_log),
        "bag2-yaml": (two, two / "metadata.yaml", read_log),
        "mcap": (mcap, next(mcap.glob("*.mcap")), read_log),
        "grid-yaml": (folder / "grid/a.yaml", folder / "grid/a.yaml", read_log),
        "grid-image": (folder / "grid/a.yaml", folder / "grid/a.pgm", read_log),
        "plan": (plan, plan, read_plan),
        "plan-image": (image, image, lambda p: read_floor_image(p, 0.2)),
        **{f"backdrop-{p.suffix[1:]}": (p, p, lambda p: read_backdrop(read_file(p), p.name)) for p in plans},
        "relations": (relations, relations, read_relations),
        "odometry": (odometry, odometry, read_odometry),
    }
    for ending in (".json", ".geojson", ".fg.json", ".dxf", ".osm"):
        export(folder / f"map{ending}", ROOMS)
        found[ending.lstrip(".")] = (folder / f"map{ending}", folder / f"map{ending}", read_drawing)
    return found


def damaged(data: bytes, chance: random.Random) -> bytes:
    """Cut, flipped, doubled, moved about, or with numbers made huge."""
    out = bytearray(data)
    for _ in range(chance.choice((1, 1, 2, 5, 20))):
        if not out:
            break
        at, kind = chance.randrange(len(out)), chance.randrange(7)
        span = chance.choice((1, 2, 4, 8, 64, 1024))
        if kind == 0:
            del out[at:]
        elif kind == 1:
            del out[at : at + span]
        elif kind == 2:
            out[at : at + span] = bytes(chance.randrange(256) for _ in range(span))
        elif kind == 3:
            out[at] ^= 1 << chance.randrange(8)
        elif kind == 4:
            out[at : at + 8] = chance.choice(
                (b"\xff" * 8, b"\0" * 8, b"\x7f" + b"\xff" * 7, b"99999999", b"-1e308  ", b"nan     ")
            )
        elif kind == 5:
            out[at:at] = out[at : at + span]
        else:
            to = chance.randrange(len(out))
            out[to : to + span] = out[at : at + span]
    return bytes(out)


def fuzz(name: str, path: Path, file: Path, read: Read, seconds: float, seed: int, keep: Path) -> Counter[str]:
    whole, chance = file.read_bytes(), random.Random(f"{name} {seed}")
    end, count = time.monotonic() + seconds, Counter[str]()
    while time.monotonic() < end:
        data = damaged(whole, chance)
        file.write_bytes(data)
        signal.setitimer(signal.ITIMER_REAL, LONGEST)
        try:
            read(path)
            count["read"] += 1
        except RgError as e:
            count["refused" if "\n" not in str(e) else "MANY LINES"] += 1
        except BaseException as e:
            if isinstance(e, KeyboardInterrupt):
                raise
            where = traceback.extract_tb(e.__traceback__)[-1]
            what = f"{type(e).__name__} in {where.name}:{where.lineno}"
            if not count[what]:
                (keep / f"{name}-{len(count)}{file.suffix}").write_bytes(data)
                print(f"-- {name}: {what}\n{''.join(traceback.format_exc(limit=-3))}", flush=True)
            count[what] += 1
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
    file.write_bytes(whole)
    return count


class Hang(BaseException):
    """Reading took longer than ``LONGEST``."""


def _hang(*_: object) -> None:
    raise Hang


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--seconds", type=float, default=10.0, help="for each reader (default: 10)")
    asked.add_argument("--seed", type=int, default=0, help="another one makes other damage (default: 0)")
    asked.add_argument("readers", nargs="*", help="default: all")
    args = asked.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    signal.signal(signal.SIGALRM, _hang)
    np.seterr(all="ignore")
    logging.disable()  # ezdxf tells of every oddity
    folder, keep = Path(tempfile.mkdtemp()), Path(tempfile.mkdtemp(prefix="rgviz-fuzz-"))
    try:
        for name, (path, file, read) in seeds(folder).items():
            if not args.readers or name in args.readers:
                count = fuzz(name, path, file, read, args.seconds, args.seed, keep)
                peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10  # of all readers so far
                print(
                    f"{name:<12} {sum(count.values()):>7} files {peak:>5} MB  {dict(count.most_common(6))}", flush=True
                )
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    print(f"findings are in {keep}" if any(keep.iterdir()) else "no findings")


if __name__ == "__main__":
    main()
