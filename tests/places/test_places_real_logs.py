"""Places of simulated runs through real buildings, with true poses, scored by the shared tool."""

from __future__ import annotations

from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rgcore import pipeline
from rgcore.exports.formats import render
from rgcore.geometry import se2
from rgcore.scans.read import read_log
from rgcore.slam.trajectory import Trajectory

SHARED = Path(__file__).parents[2] / "../shared"
RUNS = SHARED / "data/runs"
TOOL = SHARED / "tools/score_places.py"

pytestmark = pytest.mark.skipif(not RUNS.exists() or not TOOL.exists(), reason="shared data absent")


def score(name: str, tmp_path: Path) -> dict[str, Any]:
    """The tool's verdict on what the stages make of a run."""
    log = read_log(RUNS / f"{name}.log.gz")
    truth = np.loadtxt(RUNS / f"{name}.poses.tum")
    map_from_laser = np.c_[truth[:, 1:3], 2 * np.arctan2(truth[:, 6], truth[:, 7])]
    poses = se2.compose(map_from_laser, se2.invert(log.base_from_laser))
    trajectory = Trajectory(log.stamps, poses, log.base_from_laser)
    made = pipeline.run(log, known=trajectory).map
    (tmp_path / "map.json").write_bytes(render(".json", made))
    loader = SourceFileLoader("score_places", str(TOOL))
    tool = module_from_spec(spec_from_loader("score_places", loader))  # type: ignore[arg-type]
    loader.exec_module(tool)
    return tool.score(str(tmp_path / "map.json"), str(RUNS / f"{name}.poses.tum"), str(RUNS / name))


@pytest.mark.parametrize("name", ["school-Sabadell1-furnished", "office-chewlane-furnished", "office-f-furnitures"])
def test_furnished_buildings(name: str, tmp_path: Path) -> None:
    s = score(name, tmp_path)
    assert s["room_precision"] > 0.95
    assert s["room_recall"] > 0.93
    assert s["room_f1"] > 0.9
    assert s["gateway_f1"] > 0.9
    assert s["width_error_median"] < 0.1
    assert s["hallway_agreement"] > 0.9
    if s["cabinets"]:
        assert s["cabinet_recall"] > 0.88
        found = s["cabinet_recall"] * s["cabinets"]
        assert s["objects"] - found <= s["cabinets"]  # no more false ones than true ones; tables count as false
