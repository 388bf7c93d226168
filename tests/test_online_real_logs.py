"""What is told online in a furnished building, against the finished map."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rgcore.online import Mapper
from rgcore.places.automaton import RegionRecognised
from rgcore.scans.read import read_log

RUN = Path(__file__).parents[1] / "../shared/data/runs/lab-ipa-furnitures.log.gz"

pytestmark = pytest.mark.skipif(not RUN.exists(), reason="shared data absent")


def test_what_is_told_agrees_with_the_finished_map() -> None:
    log = read_log(RUN)
    mapper = Mapper.of(log)
    steps = [mapper.add(log.ranges[k], log.odom_from_base[k], log.stamps[k]) for k in range(len(log))]
    run = mapper.finish(log)
    true = run.places.labels.at(run.trajectory.map_from_base[:, :2], outside=-1)
    inside = np.flatnonzero(true >= 0)
    told = [mapper.final.get(s.region or "") for s in steps]
    assert np.mean([told[k] == f"r{true[k] + 1}" for k in inside]) > 0.75
    settled = [mapper.final.get(r or "") for r in mapper.settled()]
    assert np.mean([settled[k] == f"r{true[k] + 1}" for k in inside]) > 0.97
    returns = [e for s in steps for e in s.events if isinstance(e, RegionRecognised)]
    assert len(returns) >= 5
    assert np.mean([mapper.final.get(e.region) == f"r{true[e.scan] + 1}" for e in returns]) > 0.75
