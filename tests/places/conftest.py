"""The small building, surveyed once straight and once turned."""

from __future__ import annotations

import pytest
from building import Building, survey


@pytest.fixture(scope="session", params=[(0.0, 0.0, 0.0), (-20.0, 7.0, 0.6)], ids=["straight", "turned"])
def building(request: pytest.FixtureRequest) -> Building:
    return survey(request.param)
