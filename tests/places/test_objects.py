"""Cabinets of a building that is known."""

from __future__ import annotations

import numpy as np
import pytest
from building import BEFORE, CABINET, Building

from rgcore.config import Objects as Settings
from rgcore.geometry import se2
from rgcore.places.objects import find_objects


@pytest.mark.parametrize("cabinet", [CABINET, BEFORE])
def test_a_cabinet_at_a_wall_is_found_with_its_box(
    building: Building, cabinet: tuple[float, float, float, float]
) -> None:
    x0, y0, x1, y1 = cabinet
    middle = se2.transform(building.map_from_plan, np.array([(x0 + x1) / 2, (y0 + y1) / 2]))
    objects = find_objects(building.lines, building.places, building.free, Settings())
    nearest = min(objects, key=lambda o: float(np.hypot(*(np.array(o.center[:2]) - middle))))
    assert nearest.center[:2] == pytest.approx(middle, abs=0.12)
    assert sorted(nearest.size[:2]) == pytest.approx(sorted((x1 - x0, y1 - y0)), abs=0.15)
    assert nearest.region == building.at(2.5, 3)
    assert nearest.center[2] == pytest.approx(nearest.size[2] / 2)
    assert len(nearest.lines) >= 2


def test_no_more_objects_than_there_are(building: Building) -> None:
    assert len(find_objects(building.lines, building.places, building.free, Settings())) <= 4
