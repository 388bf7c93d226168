"""What the tests of the document share."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from two_rooms import make_run, two_rooms

from rgcore.model.records import RGMap


@pytest.fixture
def office() -> RGMap:
    return two_rooms()


@pytest.fixture
def run(office: RGMap) -> SimpleNamespace:
    return make_run(office)
