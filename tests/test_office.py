"""The demo building: what the pipeline makes of its log, against what is true of it."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from scipy.spatial.transform import Rotation
from shapely.geometry import Polygon

from rgcore.exports.formats import render
from rgcore.pipeline import Run, run
from rgviz.demo import POSES, TRUTH


@pytest.fixture(scope="module")
def truth() -> dict[str, Any]:
    return json.loads(TRUTH.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def to_truth(office: Run) -> tuple[Rotation, np.ndarray, np.ndarray]:
    """The rigid motion that lays the map on the truth, and the distance of each pose from the true one [m]."""
    table = np.loadtxt(POSES)
    mine, true = office.trajectory.map_from_laser[:, :2], table[:, 1:3]
    assert len(mine) == len(true)
    a, b = mine - mine.mean(0), true - true.mean(0)
    rotation, _ = Rotation.align_vectors(np.c_[b, np.zeros(len(b))], np.c_[a, np.zeros(len(a))])
    shift = true.mean(0) - rotation.apply([*mine.mean(0), 0])[:2]
    error = np.hypot(*(rotation.apply(np.c_[mine, np.zeros(len(mine))])[:, :2] + shift - true).T)
    return rotation, shift, error


def moved(points: Any, motion: tuple[Rotation, np.ndarray, np.ndarray]) -> np.ndarray:
    p = np.asarray(points, float).reshape(-1, 2)
    return motion[0].apply(np.c_[p, np.zeros(len(p))])[:, :2] + motion[1]


@pytest.fixture(scope="module")
def rooms(office: Run, truth: dict[str, Any], to_truth: Any) -> list[tuple[dict[str, Any], Any, float]]:
    """Each true room with the region that matches it best, one to one, and their intersection over union."""
    regions = list(office.map.regions.values())
    mine = [Polygon(moved(r.boundary, to_truth), [moved(h, to_truth) for h in r.holes]).buffer(0) for r in regions]
    true = [Polygon(r["polygon"], r.get("holes", [])) for r in truth["rooms"]]
    iou = np.array([[a.intersection(b).area / a.union(b).area for b in mine] for a in true])
    return [(truth["rooms"][i], regions[j], iou[i, j]) for i, j in zip(*linear_sum_assignment(-iou), strict=True)]


def test_the_trajectory_is_true_to_5_cm(to_truth: Any) -> None:
    assert np.sqrt((to_truth[2] ** 2).mean()) < 0.05


def test_every_room_is_found(
    rooms: list[tuple[dict[str, Any], Any, float]], truth: dict[str, Any], office: Run
) -> None:
    missed = [room["name"] for room, _, iou in rooms if iou < 0.5]
    assert not missed
    assert len(rooms) == len(truth["rooms"])
    assert len(office.map.regions) <= len(truth["rooms"]) + 1


def test_nine_rooms_in_ten_have_the_right_class(rooms: list[tuple[dict[str, Any], Any, float]]) -> None:
    hallway = {"CDMA", "ODMA"}
    wrong = [
        (room["name"], room["class"], region.class_)
        for room, region, _ in rooms
        if region.class_ != room["class"] and not {region.class_, room["class"]} <= hallway
    ]
    assert len(wrong) <= 0.1 * len(rooms), wrong


def test_every_door_is_found_and_nothing_else(office: Run, truth: dict[str, Any], to_truth: Any) -> None:
    mine = list(office.map.gateways.values())
    middles = np.array([moved(g.posts, to_truth).mean(0) for g in mine])
    true = np.array([np.mean(g["posts"], 0) for g in truth["gateways"]])
    distance = np.linalg.norm(true[:, None] - middles[None], axis=2)
    pairs = [(i, j) for i, j in zip(*linear_sum_assignment(distance), strict=True) if distance[i, j] < 0.75]
    missed = {i for i, g in enumerate(truth["gateways"]) if g["passed"]} - {i for i, _ in pairs}
    assert not missed
    assert len(mine) - len(pairs) <= 1
    width = [abs(mine[j].width - truth["gateways"][i]["width"]) for i, j in pairs]
    assert np.median(width) < 0.10
    assert [mine[j].class_ for _, j in pairs] == [truth["gateways"][i]["class"] for i, _ in pairs]


def test_each_gateway_leads_from_one_region_to_another(office: Run) -> None:
    for g in office.map.gateways.values():
        if g.class_.startswith("junction"):
            continue
        assert len(set(g.regions)) == 2
        assert len(g.gateway_points) == 2
        for region, point in zip(g.regions, g.gateway_points, strict=True):
            r = office.map.regions[region]
            assert Polygon(r.boundary, r.holes).buffer(0.1).contains(Polygon([point] * 3).centroid), (g.id, region)


def test_the_map_is_compact_and_accurate(office: Run) -> None:
    stats = office.map.stats
    assert stats.segments / len(office.map.lines) > 17
    assert stats.accuracy is not None
    assert stats.accuracy < 0.25


def test_lines_lie_on_true_walls(office: Run, truth: dict[str, Any], to_truth: Any) -> None:
    """Long lines of the map run along something that stands there: within 5 cm at both ends and the middle."""
    walls = np.array([[w["start"], w["end"]] for w in truth["lines"]])
    d = walls[:, 1] - walls[:, 0]
    far = []
    for line in office.map.lines.values():
        start, end = moved([line.start, line.end], to_truth)
        if np.hypot(*(end - start)) < 0.5:
            continue
        p = np.array([start, (start + end) / 2, end])
        t = np.einsum("pwk,wk->pw", p[:, None] - walls[None, :, 0], d) / np.maximum((d**2).sum(1), 1e-12)
        foot = walls[None, :, 0] + np.clip(t, 0, 1)[..., None] * d
        far.append(np.linalg.norm(p[:, None] - foot, axis=2).min(1).max())
    assert np.mean(np.array(far) < 0.05) > 0.97


def test_the_same_log_gives_the_same_bytes(office: Run) -> None:
    short = office.log[:250]
    first, second = run(short).map, run(short).map
    assert render(".json", first, None) == render(".json", second, None)
