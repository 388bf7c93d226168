"""What the tests of the document share."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from two_rooms import make_run, two_rooms

from rgcore.model.records import Ignored, Note, RGMap, replace


@pytest.fixture
def office() -> RGMap:
    return two_rooms()


@pytest.fixture
def run(office: RGMap) -> SimpleNamespace:
    return make_run(office)


@pytest.fixture
def noted(office: RGMap) -> RGMap:
    """The office with a note on its object, and a finding that is ignored."""
    note = Note(id="nu00000001", text="moved since", place=(7.5, 5.0), item="o1")
    ignored = Ignored(id="narrow-gateway:g2", code="narrow-gateway", items=("g2",))
    return replace(office, notes={note.id: note}, ignored={ignored.id: ignored})
