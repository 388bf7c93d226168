"""The simulated robot: it goes everywhere, hits nothing, measures what is there, and writes what a reader reads."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rgcore.errors import InputError
from rgcore.geometry import se2
from rgcore.geometry.segments import distances
from rgcore.scans.drive import Driving, crosses, drive
from rgcore.scans.floor import Floor, build_floor
from rgcore.scans.plan import Door, Plan, Room
from rgcore.scans.read import read_log
from rgcore.scans.simulate import (
    Laser,
    Odometry,
    Simulated,
    Simulation,
    measure_odometry,
    read_floor,
    simulate,
    simulate_to_files,
    write_carmen,
)
from rgcore.scans.truth import truth_of
from rgviz import demo


@cache
def small() -> Floor:
    """Two offices on a hallway, joined by a door; the store is locked."""
    plan = {
        "name": "small",
        "start": [1, 1, 0],
        "rooms": [
            {"name": "Hallway", "cls": "hallway", "outline": [[0, 0], [10, 0], [10, 2], [0, 2]]},
            {"name": "West", "outline": [[0, 2], [4, 2], [4, 6], [0, 6]]},
            {"name": "East", "class": "CC", "outline": [[4, 2], [8, 2], [8, 6], [4, 6]]},
            {"name": "Store", "outline": [[8, 2], [10, 2], [10, 6], [8, 6]]},
        ],
        "doors": [
            {"at": [2, 2]},
            {"at": [6, 2], "width": 2.5, "kind": "opening"},
            {"at": [4, 4]},
            {"at": [9, 2], "open": False},
        ],
        "furniture": [
            {"label": "cabinet", "at": [5, 5.6], "size": [1.2, 0.5]},
            {"label": "table", "at": [2, 4.5], "size": [1.4, 0.8], "shape": "legs"},
        ],
    }
    return build_floor(msgspec.convert(plan, Plan))


@cache
def run() -> Simulated:
    return simulate(small())


def test_it_enters_every_open_room_passes_every_door_and_comes_back() -> None:
    path = run().map_from_base
    assert set(small().labels.at(path[:, :2]).tolist()) >= {1, 2, 3}
    assert 4 not in small().labels.at(path[:, :2])
    for door in small().doors[:3]:
        assert crosses(path[:, :2], door.posts).any()
    assert np.hypot(*(path[-1, :2] - path[0, :2])) < 0.25
    assert abs(se2.wrap(path[-1, 2] - path[0, 2])) < 0.2


def test_it_hits_nothing_and_scans_often() -> None:
    s = Driving()
    path = drive(small(), s).poses
    dense = np.concatenate([np.linspace(a, b, 4) for a, b in zip(path[:-1, :2], path[1:, :2], strict=True)])
    assert distances(dense[:, None], small().segments[None]).min() > s.radius - 0.02
    step = se2.relative(path[:-1], path[1:])
    assert np.hypot(step[:, 0], step[:, 1]).max() <= s.step + 1e-9
    assert np.abs(step[:, 2]).max() <= s.turn + 1e-9


@settings(max_examples=12, deadline=None)
@given(st.floats(2.5, 6), st.floats(2.5, 6), st.floats(0.85, 1.2), st.floats(0, 2 * np.pi), st.floats(0.2, 0.8))
def test_any_two_rooms_are_driven_through_without_touching(
    left: float, right: float, width: float, turn: float, share: float
) -> None:
    c, s = np.cos(turn), np.sin(turn)

    def at(x: float, y: float) -> tuple[float, float]:
        return (c * x - s * y, s * x + c * y)

    plan = Plan(
        name="any",
        start=(*at(-1, 1.5), 0.0),
        rooms=(
            Room(name="left", outline=(at(-left, 0), at(0, 0), at(0, 4), at(-left, 4))),
            Room(name="right", outline=(at(0, 0), at(right, 0), at(right, 4), at(0, 4))),
        ),
        doors=(Door(at=at(0, 4 * share), width=width),),
    )
    floor = build_floor(plan)
    path = drive(floor).poses[:, :2]
    assert crosses(path, floor.doors[0].posts).sum() >= 2
    assert distances(path[:, None], floor.segments[None]).min() > Driving().radius - 0.02
    middle = path[:-1][crosses(path, floor.doors[0].posts)]
    assert np.abs((middle - floor.doors[0].posts.mean(0)) @ [-s, c]).max() < 0.15


def test_it_sees_the_walls_of_the_rooms_it_enters() -> None:
    log, floor = run().log, small()
    points = np.concatenate([se2.transform(p, log.points(i, 12.0)) for i, p in enumerate(run().map_from_laser)])
    for room in (1, 2, 3):
        faces = floor.segments[floor.room == room]
        at = np.concatenate([np.linspace(a, b, int(np.hypot(*(b - a)) / 0.2) + 2)[1:-1] for a, b in faces])
        near = np.array([np.hypot(*(points - p).T).min() for p in at])
        assert (near < 0.15).mean() > 0.9


def test_ranges_are_those_of_the_floor() -> None:
    exact = simulate(small(), Simulation(laser=Laser(noise=0, drop_out=0, mixed=0)))
    scan, pose = exact.log.ranges[0], exact.map_from_laser[0]
    assert scan[90] == pytest.approx(10 - 0.07 - pose[0], abs=0.006)
    assert scan[0] == pytest.approx(pose[1] - 0.07, abs=0.006)
    noisy = run().log.ranges
    dropped = np.isinf(noisy)
    assert 0.001 < dropped.mean() < 0.004
    error = (noisy - exact.log.ranges)[~dropped]
    error = error[np.abs(error) < 0.06]  # without mixed pixels
    assert error.std() == pytest.approx(np.hypot(0.012, 0.01 / np.sqrt(6)), rel=0.03)  # and both rounded to 1 cm


def test_odometry_drifts_as_the_model_says() -> None:
    straight = np.column_stack([np.arange(0, 10, 0.2), np.zeros(50), np.zeros(50)])
    none = Odometry(**dict.fromkeys(Odometry.__struct_fields__, 0.0))
    chance = np.random.default_rng(0)
    assert measure_odometry(straight, none, chance) == pytest.approx(straight)
    assert measure_odometry(run().map_from_base, none, chance) == pytest.approx(run().map_from_base)
    long = measure_odometry(straight, msgspec.structs.replace(none, way_bias=0.1), chance)
    assert long[-1] == pytest.approx([9.8 * 1.1, 0, 0])
    ends = np.array(
        [measure_odometry(straight, msgspec.structs.replace(none, rotation_by_way=0.1), chance)[-1] for _ in range(300)]
    )
    assert ends[:, 2].mean() == pytest.approx(0, abs=0.03)
    assert ends[:, 2].std() == pytest.approx(np.sqrt(2 * 49) * 0.1 * 0.2, rel=0.15)


def test_same_seed_same_bytes_other_seed_other_noise(tmp_path: Path) -> None:
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        write_carmen(simulate(small(), Simulation(seed=seed)).log, tmp_path / f"{name}.log.gz")
    a, b, c = ((tmp_path / f"{n}.log.gz").read_bytes() for n in "abc")
    assert a == b
    assert a != c


@pytest.mark.parametrize("ending", ["log", "log.gz"])
@pytest.mark.parametrize("forward", [0.0, 0.2])
def test_what_is_written_is_what_is_read(tmp_path: Path, ending: str, forward: float) -> None:
    written = simulate(small(), Simulation(laser=Laser(forward=forward))).log
    write_carmen(written, tmp_path / f"small.{ending}")
    read = read_log(tmp_path / f"small.{ending}")
    assert np.array_equal(read.ranges, written.ranges)
    assert np.array_equal(read.stamps, written.stamps)
    assert np.allclose(read.odom_from_base, written.odom_from_base, atol=1e-9)
    assert np.allclose(read.bearings, written.bearings)
    assert np.allclose(read.base_from_laser, written.base_from_laser, atol=2e-4)


def test_the_truth_tells_rooms_gateways_and_objects(tmp_path: Path) -> None:
    truth = truth_of(run())
    assert [(r["name"], r["cls"], r["class"], r["visited"]) for r in truth["rooms"]] == [
        ("Hallway", "hallway", "CDMA", True),
        ("West", "room", "TOMA", True),
        ("East", "room", "CC", True),
        ("Store", "room", "TOMA", False),
    ]
    gateways = [(sorted(g["regions"]), g["class"], g["width"], g["passed"]) for g in truth["gateways"]]
    assert gateways == [
        ([1, 2], "narrow_passage", 0.9, True),
        ([1, 3], "opening", 2.5, True),
        ([2, 3], "narrow_passage", 0.9, True),
    ]
    assert [sorted(d["regions"]) for d in truth["closed_doors"]] == [[1, 4]]
    assert truth["objects"] == [{"kind": "cabinet", "room": 3, "center": [5.0, 5.6], "size": [1.2, 0.5], "yaw": 0.0}]
    assert [t["kind"] for t in truth["tables"]] == ["table"]


def test_the_files_beside_the_log(tmp_path: Path) -> None:
    (tmp_path / "plan.json").write_bytes(demo.PLAN.read_bytes())
    simulated = simulate_to_files(tmp_path / "plan.json", tmp_path / "run.log.gz")
    truth = json.loads((tmp_path / "run.truth.json").read_text())
    labels = cv2.imread(str(tmp_path / "run.rooms.png"), cv2.IMREAD_GRAYSCALE)[::-1]
    for room in truth["rooms"]:
        assert (labels == room["id"]).sum() * truth["resolution"] ** 2 == pytest.approx(room["area"], abs=0.01)
        assert np.array(room["polygon"]).min() > 0
    poses = np.loadtxt(tmp_path / "run.poses.tum")
    assert np.array_equal(poses[:, 0], read_log(tmp_path / "run.log.gz").stamps)
    assert poses[:, 1:3] == pytest.approx(simulated.map_from_laser[:, :2], abs=1e-4)
    shipped = read_log(demo.LOG)  # to the last digit only on one kind of processor
    assert simulated.log.ranges.shape == shipped.ranges.shape, "the plan or the simulator changed: make the demo again"
    assert (simulated.log.ranges == shipped.ranges).mean() > 0.99, (
        "the plan or the simulator changed: make the demo again"
    )
    assert truth["gateways"] == json.loads(demo.TRUTH.read_text())["gateways"]


def test_the_demo_is_the_building_it_should_be() -> None:
    truth = json.loads(demo.TRUTH.read_text())
    assert all(r["visited"] for r in truth["rooms"])
    assert all(g["passed"] for g in truth["gateways"])
    assert {j["class"] for j in truth["junctions"]} == {"junction_X", "junction_T", "junction_L"}
    assert {r["class"] for r in truth["rooms"]} == {"CDMA", "TOMA", "CC"}
    files = [demo.PLAN, demo.LOG, demo.TRUTH, demo.POSES, demo.ROOMS]
    assert demo.LOG.stat().st_size < 1_000_000
    assert sum(f.stat().st_size for f in files) < 1_500_000
    true, log = np.loadtxt(demo.POSES), read_log(demo.LOG)
    off = np.hypot(*(log.odom_from_base[:, :2] - true[:, 1:3]).T)
    assert off[0] < 0.01
    assert off[-1] > 2, "without drift the demo would show nothing"


def test_an_image_can_be_driven(tmp_path: Path) -> None:
    image = np.zeros((90, 130), np.uint8)
    image[10:80, 10:120] = 255
    image[10:60, 60:64] = 0
    cv2.imwrite(str(tmp_path / "plan.png"), image)
    run = simulate(read_floor(tmp_path / "plan.png", resolution=0.05))
    x = run.map_from_base[:, 0]
    assert x.min() < 2.5
    assert x.max() > 3.5
    assert truth_of(run)["rooms"] == []


def test_a_room_that_the_robot_cannot_enter_is_named() -> None:
    plan = {
        "name": "narrow",
        "start": [1, 1, 0],
        "rooms": [
            {"name": "A", "outline": [[0, 0], [4, 0], [4, 3], [0, 3]]},
            {"name": "B", "outline": [[4, 0], [8, 0], [8, 3], [4, 3]]},
        ],
        "doors": [{"at": [4, 1.5], "width": 0.4}],
    }
    with pytest.raises(InputError, match=r'narrow\.json: room "B": the robot cannot get in'):
        simulate(build_floor(msgspec.convert(plan, Plan), "narrow.json"))
