"""What holds in every map: each rule finds its break, and a sound map has none."""

from __future__ import annotations

from typing import Any

import pytest

from rgcore.model.checks import broken
from rgcore.model.records import Ignored, Note, RGMap, replace


def test_a_sound_map_has_none(noted: RGMap) -> None:
    assert broken(noted) == []
    assert broken(RGMap()) == []


CROSSED = ((0.0, 0.0), (8.0, 2.0), (8.0, 0.0), (0.0, 2.0))
BREAKS: list[tuple[str, str, dict[str, Any], str]] = [
    ("lines", "l1", {"id": "l7"}, "l1 stands under another name"),
    ("lines", "l1", {"regions": ("r9",)}, "l1 names r9, which is not in the map"),
    ("lines", "l1", {"regions": ("r1", "r1")}, "l1 names one thing twice"),
    ("lines", "l1", {"end": (0.0, 0.0)}, "l1 has no length"),
    ("regions", "r1", {"boundary": CROSSED}, "the outline of r1 crosses itself"),
    ("regions", "r1", {"axes": (4.0,)}, "axis beyond half a turn"),
    ("gateways", "g1", {"regions": ("r1",)}, "g1 has 2 gateway-points for 1 regions"),
    ("gateways", "g1", {"regions": (), "gateway_points": ()}, "g1 belongs to no region"),
    ("gateways", "g1", {"posts": ((1.0, 1.0), (1.0, 1.0))}, "the posts of g1 are one"),
    ("gateways", "g1", {"crossing_points": ()}, "g1 is crossed nowhere"),
    ("objects", "o1", {"region": "r9"}, "o1 names r9, which is not in the map"),
    ("objects", "o1", {"lines": ("l99",)}, "o1 names l99, which is not in the map"),
    ("objects", "o1", {"size": (1.0, 0.0, 1.0)}, "o1 has no extent"),
]


@pytest.mark.parametrize(("kind", "id", "changes", "words"), BREAKS)
def test_a_break_is_found(office: RGMap, kind: str, id: str, changes: dict[str, Any], words: str) -> None:
    items = getattr(office, kind)
    (found,) = broken(replace(office, **{kind: {**items, id: replace(items[id], **changes)}}))
    assert words in found


def test_notes_and_ignored_findings_are_about_things_of_the_map(office: RGMap) -> None:
    note = Note(id="nu00000001", text="x", place=(0.0, 0.0), item="o9")
    ignored = Ignored(id="a:r9", code="a", items=("r9",))
    assert broken(replace(office, notes={note.id: note}, ignored={ignored.id: ignored})) == [
        "nu00000001 is on o9, which is not in the map",
        "a:r9 names r9, which is not in the map",
    ]
