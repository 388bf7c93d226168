"""The stage cache: gives back what was kept, computes whatever is doubtful, and is never the reason for a failure."""

from __future__ import annotations

import errno
import math
import pickle
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from rgcore import cache
from rgcore.cache import KEEP, Cache
from rgcore.config import Lines as LineSettings
from rgcore.config import Slam
from rgcore.geometry.grid import Grid
from rgcore.places.places import FoundGateway, FoundRegion, Places
from rgcore.slam.trajectory import Trajectory

RNG = np.random.default_rng(1)
TRAJECTORY = Trajectory(np.arange(3.0), RNG.normal(size=(3, 3)), np.array([0.1, 0.0, 0.0]))
PLACES = Places(
    Grid(RNG.integers(-1, 3, (4, 5)).astype(np.int32), np.array([-1.0, 2.0]), 0.05),
    (
        FoundRegion(
            boundary=((0.0, 0.0), (1.0, 0.0), (1.0, 1 / 3)),
            holes=(((0.1, 0.1), (0.2, 0.1), (0.1, 0.2)),),
            box_center=(0.5, 0.5),
            box_size=(1.0, 1.0),
            box_yaw=0.1,
            first_scan=np.int64(2),  # type: ignore[arg-type]
        ),
    ),
    (
        FoundGateway(
            class_="opening",
            confidence=np.float64(0.5),
            regions=(0, 1),
            posts=((0.0, 0.0), (1.0, 0.0)),
            crossing_points=(),
            gateway_points=((0.0, 1.0),),
            traversal_directions=(0.1,),
            passed=np.bool_(True),  # type: ignore[arg-type]
            first_scan=3,
        ),
    ),
)


def never() -> Any:
    raise AssertionError("this was kept and must not be computed")


def equal(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
    if isinstance(a, Trajectory | Grid | Places):
        return type(a) is type(b) and all(equal(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if isinstance(a, tuple | list):
        return type(a) is type(b) and len(a) == len(b) and all(map(equal, a, b))
    return a == b or (a != a and b != b)


VALUES = [
    TRAJECTORY,
    PLACES,
    (TRAJECTORY, np.arange(5)),
    np.array([[1.0, np.nan], [np.inf, -0.0]]),
    np.zeros((0, 2, 2)),
    PLACES.regions,
    (),
    (1, 2.5, "text", None, True, math.inf, math.nan),
    [np.array(True), np.float32([1.5])],
]


@pytest.mark.parametrize("value", VALUES, ids=lambda v: type(v).__name__)
def test_what_was_kept_comes_back(tmp_path: Path, value: Any) -> None:
    key = Cache(tmp_path).key("slam", "log")
    assert Cache(tmp_path).get("slam", key, lambda: value) is value
    assert equal(value, Cache(tmp_path).get("slam", key, never))


@given(hnp.arrays(st.sampled_from(["f8", "f4", "i4", "u1", "?"]), hnp.array_shapes(min_dims=0, max_dims=3, min_side=0)))
@settings(deadline=None, max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_array_comes_back(tmp_path: Path, array: np.ndarray) -> None:
    c = Cache(tmp_path)
    key = c.key("slam", array.tobytes().hex(), str(array.shape), str(array.dtype))
    c.get("slam", key, lambda: (array,))
    assert equal((array,), c.get("slam", key, never))


def test_arrays_of_evidence_are_read_only(tmp_path: Path) -> None:
    c = Cache(tmp_path)
    c.get("slam", "k", lambda: TRAJECTORY)
    with pytest.raises(ValueError, match="read-only"):
        c.get("slam", "k", never).map_from_base[0, 0] = 1.0


def test_without_a_folder_nothing_is_kept() -> None:
    assert Cache(None).get("slam", "k", lambda: 1) == 1
    assert Cache(None).get("slam", "k", lambda: 2) == 2


def test_the_key_tells_stage_settings_inputs_and_software_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    c = Cache(None)
    keys = [
        c.key("slam", "log", Slam()),
        c.key("slam", "log", Slam(max_range=12.0)),
        c.key("slam", "log2", Slam()),
        c.key("lines", "log", Slam()),
        c.key("lines", "log", LineSettings()),
        c.key("lines", "lo", "g", LineSettings()),
        c.key("lines", "log"),
    ]
    assert len(set(keys)) == len(keys)
    assert keys[0] == Cache(None).key("slam", "log", Slam())
    assert all(len(k) == 64 for k in keys)
    monkeypatch.setattr(cache, "software", lambda: "99")
    assert c.key("slam", "log", Slam()) != keys[0]


def test_a_damaged_file_is_computed_again(tmp_path: Path) -> None:
    c = Cache(tmp_path)
    c.get("slam", "k", lambda: TRAJECTORY)
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    again = Trajectory(np.arange(2.0), np.zeros((2, 3)), np.zeros(3))
    for damage in (b"", b"junk", whole[: len(whole) // 2], whole[:-1], whole[:200] + b"xxxx" + whole[204:]):
        file.write_bytes(damage)
        assert equal(c.get("slam", "k", lambda: again), again)
        assert equal(c.get("slam", "k", never), again)  # and is whole once more


def test_a_foreign_file_is_never_obeyed(tmp_path: Path) -> None:
    """Neither a pickle nor a type outside rgcore, nor the result of another key."""
    c = Cache(tmp_path)
    (tmp_path / "slam-k.npz").write_bytes(pickle.dumps({"tree": 1}))
    assert c.get("slam", "k", lambda: 1) == 1
    for name in (
        "subprocess:Popen",
        "rgcore.cache:Cache",
        "rgcore.errors:RgError",
        "rgcore.config:load",
        "rgcore.no:No",
    ):
        for kind in ("struct", "dataclass"):
            tree = msgspec.json.encode({"key": "k", "value": {kind: name, "value": {}}})
            np.savez(tmp_path / "slam-k.npz", tree=np.frombuffer(tree, np.uint8))
            assert c.get("slam", "k", lambda: 2) == 2
    tree = msgspec.json.encode({"key": "other", "value": 5})
    np.savez(tmp_path / "slam-k.npz", tree=np.frombuffer(tree, np.uint8))
    assert c.get("slam", "k", lambda: 3) == 3


def test_a_full_disk_or_a_file_in_the_way_does_no_harm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    assert Cache(tmp_path / "file" / "cache").get("slam", "k", lambda: 1) == 1

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    assert Cache(tmp_path / "cache").get("slam", "k", lambda: 1) == 1
    assert list((tmp_path / "cache").iterdir()) == []


def test_a_failing_stage_fails_and_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(KeyError):
        Cache(tmp_path).get("slam", "k", lambda: {}["x"])
    assert list(tmp_path.iterdir()) == []


def test_old_results_make_room(tmp_path: Path) -> None:
    c = Cache(tmp_path)
    for i in range(KEEP + 4):
        c.get("slam", f"{i:064d}"[::-1], lambda i=i: i)
    c.get("lines", "k", lambda: 0)
    assert len(list(tmp_path.glob("slam-*.npz"))) == KEEP
    assert c.get("slam", f"{KEEP + 3:064d}"[::-1], never) == KEEP + 3


def test_what_cannot_be_kept_is_a_mistake_of_ours_and_told(tmp_path: Path) -> None:
    @dataclass
    class Thing:
        f: Any

    with pytest.raises(TypeError, match="cannot be cached"):
        Cache(tmp_path).get("slam", "k", lambda: Thing(print))
    with pytest.raises(TypeError, match="cannot be cached"):
        Cache(tmp_path).get("slam", "k", lambda: np.array([print]))
