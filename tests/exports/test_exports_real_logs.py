"""A real log, mapped and written in every format, where the logs are present."""

from __future__ import annotations

import io
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import trimesh

from rgcore.exports.formats import render
from rgcore.exports.rgjson import read_json, schema
from rgcore.pipeline import Run, run
from rgcore.scans.read import read_log

DATA = Path(__file__).parents[2] / "../shared/data"
pytestmark = pytest.mark.skipif(not DATA.exists(), reason="shared data absent")


@pytest.fixture(scope="module")
def seattle() -> Run:
    return run(read_log(DATA / "logs/seattle.log.gz"))


def test_json_obeys_the_schema_and_comes_back(seattle: Run) -> None:
    data = render(".json", seattle.map)
    tree = json.loads(data)
    jsonschema.Draft202012Validator(schema()).validate(tree)
    assert tree["source"]["sha256"] == seattle.log.sha256
    assert tree["stats"]["lines"] == len(seattle.map.lines) > 50
    assert render(".json", read_json(data)) == data


def test_tum_has_a_line_for_each_scan_in_the_logs_order(seattle: Run) -> None:
    table = np.loadtxt(io.BytesIO(render(".tum", seattle.map, seattle.trajectory)))
    np.testing.assert_allclose(table[:, 0], seattle.log.stamps, atol=1e-6)
    np.testing.assert_allclose(table[:, 1:3], seattle.trajectory.map_from_laser[:, :2], atol=1e-6)


def test_glb_has_the_extents_of_the_map(seattle: Run) -> None:
    scene = trimesh.load(io.BytesIO(render(".glb", seattle.map, wall_height=3.0)), file_type="glb")
    points = np.array([p for line in seattle.map.lines.values() for p in (line.start, line.end)])
    low, high = scene.bounds
    assert (low[[0, 2]] <= [points[:, 0].min() + 1e-4, -points[:, 1].max() + 1e-4]).all()
    assert (high[[0, 2]] >= [points[:, 0].max() - 1e-4, -points[:, 1].min() - 1e-4]).all()
    assert (low[1], high[1]) == pytest.approx((0.0, 3.0))
