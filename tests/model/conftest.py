"""What the tests of the document share."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from two_rooms import make_run, two_rooms

from rgcore.model.records import Backdrop, Ignored, Note, RGMap, replace


@pytest.fixture
def office() -> RGMap:
    return two_rooms()


@pytest.fixture
def run(office: RGMap) -> SimpleNamespace:
    return make_run(office)


@pytest.fixture
def noted(office: RGMap) -> RGMap:
    """The office with a note on its object, a finding that is ignored, and a floor plan under it."""
    note = Note(id="nu00000001", text="moved since", place=(7.5, 5.0), item="o1")
    ignored = Ignored(id="narrow-gateway:g2", code="narrow-gateway", items=("g2",))
    plan = Backdrop(
        id="bu00000001", name="plan.png", sha256="a" * 64, form="png", size=(80, 60), center=(4, 3), length=8
    )
    return replace(office, notes={note.id: note}, ignored={ignored.id: ignored}, backdrops={plan.id: plan})
