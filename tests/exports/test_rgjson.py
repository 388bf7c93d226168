"""The map as JSON: described by its schema, the same bytes for the same map, read back without loss."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import msgspec
import pytest
from export_maps import HOSTILE, ROOMS, any_map
from hypothesis import HealthCheck, given, settings

from rgcore.errors import InputError
from rgcore.exports.formats import render
from rgcore.exports.rgjson import DECIMALS, read_json, schema
from rgcore.model.records import RGMap, replace

VALIDATOR = jsonschema.Draft202012Validator(schema())


def near(a: Any, b: Any) -> bool:
    """Equal up to the format's precision."""
    if isinstance(a, float) and isinstance(b, float):
        return abs(a - b) <= 0.51 * 10.0**-DECIMALS
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(near(v, b[k]) for k, v in a.items())
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(near(x, y) for x, y in zip(a, b, strict=True))
    return bool(a == b)


def test_the_schema_is_one() -> None:
    jsonschema.Draft202012Validator.check_schema(schema())


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(any_map)
def test_any_map_comes_back_as_it_was(map_: RGMap) -> None:
    data = render(".json", map_)
    back = read_json(data)
    assert near(msgspec.to_builtins(map_), msgspec.to_builtins(back))
    assert render(".json", back) == data
    assert read_json(render(".json", back)) == back  # numbers as the document has them: the very same map
    VALIDATOR.validate(json.loads(data))


def test_the_contract() -> None:
    tree = json.loads(render(".json", ROOMS))
    assert (tree["format"], tree["version"]) == ("rgmap", "1.0")
    assert tree["frame"] == {"name": "map", "units": "m"}
    assert tree["source"]["settings"] == {"slam.max_range": 12.0}
    counted = {"scans": 100, "points": 18000, "segments": 900, "lines": 5, "regions": 2, "gateways": 1, "objects": 1}
    assert tree["stats"] == counted | {"accuracy": 0.05, "accuracy_penalty": 1.0}
    lab, hall = tree["regions"]
    assert (lab["id"], lab["name"], lab["class"]) == ("r1", HOSTILE, "TOMA")
    assert lab["lines"] == ["l1", "l2", "l10"]
    assert (lab["gateways"], lab["objects"], hall["objects"]) == (["g1"], ["o1"], [])
    assert tree["gateways"][0]["width"] == 1.0
    assert [line["id"] for line in tree["lines"]] == ["l1", "l2", "l10", "l11", "l12"]
    assert all("provenance" in item for kind in ("lines", "regions", "gateways", "objects") for item in tree[kind])


def test_one_record_a_line_and_sorted_keys() -> None:
    text = render(".json", ROOMS).decode()
    assert sum(line.startswith('{"') for line in text.splitlines()) == 5 + 2 + 1 + 1
    moved = replace(ROOMS, lines=ROOMS.lines | {"l2": replace(ROOMS.lines["l2"], support=3)})
    after = render(".json", moved).decode()
    assert sum(a != b for a, b in zip(text.splitlines(), after.splitlines(), strict=True)) == 1
    tree = json.loads(text)
    assert list(tree) == sorted(tree)
    assert all(list(r) == sorted(r) for r in tree["regions"])


def test_the_order_in_which_items_were_made_does_not_show() -> None:
    turned = replace(ROOMS, **{k: dict(reversed(getattr(ROOMS, k).items())) for k in ("lines", "regions")})
    assert render(".json", turned) == render(".json", ROOMS)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: b"{", "not a JSON file"),
        (lambda t: b"\xff\xfe", "not a JSON file"),
        (lambda t: b"[1, 2]", "not an RG map"),
        (lambda t: t | {"format": "osm"}, "not an RG map"),
        (lambda t: t | {"version": "2.0"}, r"map version 2\.0, this software reads 1\.0"),
        (lambda t: {k: v for k, v in t.items() if k != "lines"}, "damaged map: .*lines"),
        (lambda t: t | {"lines": [{"id": "l1", "start": [0], "end": [1, 2]}]}, "damaged map: .*start"),
        (lambda t: t | {"lines": t["lines"] * 2}, "damaged map: two lines have the id l1"),
    ],
)
def test_what_is_no_map_gets_one_line(tmp_path: Path, change: Any, message: str) -> None:
    content = change(json.loads(render(".json", ROOMS)))
    path = tmp_path / "office.json"
    path.write_bytes(content if isinstance(content, bytes) else json.dumps(content).encode())
    with pytest.raises(InputError, match=message) as e:
        read_json(path)
    assert str(e.value).startswith(str(path))
    assert "\n" not in str(e.value)


def test_a_missing_file() -> None:
    with pytest.raises(InputError, match="cannot be read: No such file"):
        read_json("nowhere.json")


def test_a_later_minor_version_with_more_fields_is_read() -> None:
    tree = json.loads(render(".json", ROOMS)) | {"version": "1.7", "weather": "fine"}
    tree["lines"][0]["color"] = "red"
    assert read_json(json.dumps(tree).encode()) == read_json(render(".json", ROOMS))
