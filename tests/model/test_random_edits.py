"""Whatever people do, in whatever order: the map stays sound, undo is exact, and nothing is lost on the way to disk."""

from __future__ import annotations

import random
from functools import cache

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_edits import MAKERS, random_edit
from two_rooms import two_rooms

from rgcore.errors import EditError
from rgcore.exports.options import Options
from rgcore.exports.rgjson import read_json, render
from rgcore.model.base import decode_map, encode_map
from rgcore.model.checks import KINDS, broken
from rgcore.model.edits import EDITS, Edit, decode_edit
from rgcore.model.history import Do, History, Undo, replay, step
from rgcore.model.journal import Journal, encode_journal
from rgcore.model.records import Box2, Gateway, Line, Region, RGMap

AT = "2026-01-01T00:00:00Z"


@cache
def floor() -> RGMap:
    """A floor of 3 x 4 rooms that share their walls, with a pillar in the middle one, doors between neighbours."""
    regions, gateways, lines = [], [], []
    for i in range(12):
        x, y = 5.0 * (i % 4), 4.0 * (i // 4)
        ring = ((x, y), (x + 5, y), (x + 5, y + 4), (x, y + 4))
        pillar = (((x + 2, y + 2), (x + 2, y + 2.5), (x + 2.5, y + 2.5), (x + 2.5, y + 2)),) if i == 5 else ()
        box = Box2(center=(x + 2.5, y + 2), size=(4.5, 3.5), yaw=0.0)
        regions.append(
            Region(id=f"r{i + 1}", name=f"Room {i + 1}", class_="TOMA", boundary=ring, holes=pillar, box=box)
        )
        for k in range(4):
            a, b = ring[k], ring[(k + 1) % 4]
            lines.append(
                Line(id=f"l{len(lines) + 1}", start=a, end=b, regions=(f"r{i + 1}",), support=9, residual=0.01)
            )
        for other, posts in ((i + 1, ((x + 5, y + 1.5), (x + 5, y + 2.5))), (i + 4, ((x + 2, y + 4), (x + 3, y + 4)))):
            if other < 12 and (other != i + 1 or i % 4 != 3):
                across = other == i + 1
                middle = ((posts[0][0] + posts[1][0]) / 2, (posts[0][1] + posts[1][1]) / 2)
                d = (0.5, 0.0) if across else (0.0, 0.5)
                points = tuple((middle[0] + s * d[0], middle[1] + s * d[1]) for s in (-1, 1))
                gateways.append(
                    Gateway(
                        id=f"g{len(gateways) + 1}",
                        class_="narrow_passage",
                        regions=(f"r{i + 1}", f"r{other + 1}"),
                        posts=posts,
                        crossing_points=(middle,),
                        gateway_points=points,
                        traversal_directions=(0.0, 3.141593) if across else (1.570796, -1.570796),
                    )
                )
    tables = {"regions": regions, "gateways": gateways, "lines": lines}
    return RGMap(**{k: {v.id: v for v in items} for k, items in tables.items()})


def worked_on(base: RGMap, seed: int, count: int) -> tuple[History, list[Do]]:
    """A history of random edits, those that the map took."""
    rng, history, entries = random.Random(seed), History.of(base), list[Do]()
    for _ in range(count):
        try:
            edit = random_edit(history.map, base, rng).checked()
            entry = Do(number=len(entries) + 1, at=AT, by="ann", edit=edit)  # type: ignore[arg-type]
            history = step(history, entry)
        except EditError:
            continue
        entries.append(entry)
        assert broken(history.map) == [], edit
    return history, entries


def same(a: RGMap, b: RGMap) -> bool:
    return a == b and all(list(getattr(a, k)) == list(getattr(b, k)) for k in KINDS)


@pytest.mark.parametrize(
    "base", [read_json(render(two_rooms(), None, Options()).data), floor()], ids=["two rooms", "floor"]
)
@given(seed=st.integers(0, 2**32))
@settings(max_examples=20, deadline=None)
def test_random_edits_leave_a_sound_map_that_undoes_exactly_and_survives_the_disk(base: RGMap, seed: int) -> None:
    history, entries = worked_on(base, seed, 25)
    for e in entries:
        assert decode_edit(msgspec.json.encode(e.edit)) == e.edit
    again, notes = replay(base, entries)
    assert notes == []
    assert same(again.map, history.map)
    assert read_json(render(history.map, None, Options()).data) == history.map
    assert decode_map(encode_map(history.map)) == history.map
    for number in range(len(history.done)):
        history = step(history, Undo(number=1000 + number, at=AT))
    assert same(history.map, base)


def test_the_journal_gives_random_edits_back(tmp_path: object) -> None:
    history, entries = worked_on(floor(), 7, 120)
    path = tmp_path / "edits.jsonl"  # type: ignore[operator]
    path.write_bytes(encode_journal(entries))
    again, notes = replay(floor(), Journal(path).entries)
    assert notes == []
    assert same(again.map, history.map)


def test_random_edits_are_of_all_kinds() -> None:
    made: set[str] = set()
    for seed in range(60):
        _, entries = worked_on(floor(), seed, 40)
        made |= {type(e.edit).__name__ for e in entries}
        if made == set(EDITS):
            break
    assert made == set(EDITS), "what the tests here make is what a journal may hold"
    assert len(MAKERS) >= len(EDITS) - 3
    assert all(isinstance(e, type) and issubclass(e, Edit) for e in EDITS.values())
