"""Classes: on synthetic rooms, and on the rooms that people labelled; what is found, and how far it can be believed.

    python tests/bench/bench_classes.py [NAME ...]

The labels only say hallway or not, so that rooms are compared by CDMA + ODMA; their table of confusion has the
annotation in its rows and the class found in its columns. ECE: expected calibration error, the mean gap between score
and share of rights over ten bands, weighted by how many lie in each.
"""

from __future__ import annotations

import json
import sys

import cv2
import numpy as np
from bench_places import DATA, log_of, scorer
from rich.console import Console
from rich.table import Table

from rgcore import pipeline
from rgcore.places.classify import CLASSES, network
from rgcore.places.train_classes import samples_of
from rgcore.scans.read import read_log

LABELS = ("hallway", "room", "lobby", "stairs")


def main(wanted: list[str]) -> None:
    inputs, true = samples_of(np.random.default_rng(2024), 4000)
    p = network().probabilities(inputs)
    confusion("synthetic rooms", CLASSES, true, p.argmax(1))
    reliability("synthetic rooms, best class", p.max(1), p.argmax(1) == true)
    runs = sorted(f.name.removesuffix(".truth.json") for f in DATA.glob("runs/*.truth.json"))
    tool = scorer()
    label, scores = map(np.concatenate, zip(*(one(n, tool) for n in runs if not wanted or n in wanted), strict=True))
    confusion("labelled rooms", LABELS, label, scores.argmax(1))
    hall = scores[:, :2].sum(1)
    sure = np.maximum(hall, 1 - hall)
    reliability("labelled rooms, hallway or not", sure, (hall > 0.5) == (label == 0))


def one(name: str, tool) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[no-untyped-def]
    """Label (K,) and class scores (K, 4) of the regions of a run that are a labelled room."""
    run = pipeline.run(read_log(log_of(name)))
    truth = json.loads((DATA / f"runs/{name}.truth.json").read_text())
    rooms = cv2.imread(str(DATA / f"runs/{name}.rooms.png"), cv2.IMREAD_GRAYSCALE)[::-1]
    t = run.trajectory
    turn, move, *_ = tool.align((t.stamps, t.map_from_base[:, :2]), tool.load_tum(f"{DATA}/runs/{name}.poses.tum"))
    ids = [
        r["id"] for r in truth["rooms"] if r["visited"] and (rooms == r["id"]).sum() * truth["resolution"] ** 2 > 1.5
    ]
    label = {r["id"]: LABELS.index(r["cls"]) for r in truth["rooms"]}
    masks = []
    for region in run.places.regions:
        mask = np.zeros(rooms.shape, np.uint8)
        for k, ring in enumerate((region.boundary, *region.holes)):
            cells = np.round((np.array(ring) @ turn.T + move) / truth["resolution"] - 0.5).astype(np.int32)
            cv2.fillPoly(mask, [cells], int(k == 0))
        masks.append((mask > 0) & (rooms > 0))
    common = np.array([[(m & (rooms == i)).sum() for i in ids] for m in masks], float)
    union = np.array([m.sum() for m in masks])[:, None] + np.array([(rooms == i).sum() for i in ids]) - common
    pairs = tool.greedy(common / np.maximum(union, 1), 0.5)
    return np.array([label[ids[j]] for _, j in pairs]), run.classes.scores[[i for i, _ in pairs]]


def confusion(title: str, rows: tuple[str, ...], true: np.ndarray, found: np.ndarray) -> None:
    table = Table(title=f"{title}: true (rows) and found", title_justify="left")
    for head in ("", *CLASSES):
        table.add_column(head, justify="right")
    for k, row in enumerate(rows):
        table.add_row(row, *(str(int(n)) for n in np.bincount(found[true == k], minlength=len(CLASSES))))
    Console(width=120).print(table)


def reliability(title: str, score: np.ndarray, right: np.ndarray) -> None:
    table = Table(title_justify="left")
    for head in ("from", "regions", "mean score", "right"):
        table.add_column(head, justify="right")
    band, gap = np.minimum((score * 10).astype(int), 9), 0.0
    for k in np.unique(band):
        s, r, n = score[band == k].mean(), right[band == k].mean(), int((band == k).sum())
        gap += abs(s - r) * n / len(score)
        table.add_row(f"{k / 10:g}", str(n), f"{s:.3f}", f"{r:.3f}")
    table.title = f"{title}: {right.mean():.3f} right, ECE {gap:.3f}"
    Console(width=120).print(table)


if __name__ == "__main__":
    main(sys.argv[1:])
