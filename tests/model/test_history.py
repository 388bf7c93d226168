"""History: any sequence of entries is a fold; undo is exact; provenance keeps itself."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rgcore.errors import EditError
from rgcore.model.edits import (
    ClassifyRegion,
    DeleteGateway,
    DeleteObject,
    Edit,
    LabelObject,
    MoveGateway,
    MoveObject,
    RenameRegion,
    SeedObject,
)
from rgcore.model.history import KINDS, Do, History, Redo, Undo, replay, step
from rgcore.model.records import RGMap

NAMES = st.sampled_from(["a", "Lab", "Room 1"])
COORDINATE = st.floats(-10, 10)
REGIONS, GATEWAYS = st.sampled_from(["r1", "r2", "r3", "r9"]), st.sampled_from(["g1", "g2"])
OBJECTS = st.sampled_from(["o1", "ou00000001", "ou00000002"])
POINT3 = st.tuples(COORDINATE, COORDINATE, COORDINATE)
EDIT: st.SearchStrategy[Edit] = st.one_of(
    st.builds(ClassifyRegion, region=REGIONS, class_=NAMES),
    st.builds(RenameRegion, region=REGIONS, name=NAMES),
    st.builds(MoveGateway, gateway=GATEWAYS, posts=st.tuples(st.tuples(COORDINATE, COORDINATE), st.just((11.0, 0.0)))),
    st.builds(DeleteGateway, gateway=GATEWAYS),
    st.builds(
        SeedObject,
        id=st.sampled_from(["ou00000001", "ou00000002"]),
        lines=st.just(("l6",)),
        center=POINT3,
        size=st.just((1.0, 1.0, 1.0)),
        yaw=st.just(0.0),
    ),
    st.builds(MoveObject, object=OBJECTS, center=POINT3, size=st.just((1.0, 2.0, 1.0)), yaw=st.just(0.0)),
    st.builds(LabelObject, object=OBJECTS, label=NAMES),
    st.builds(DeleteObject, object=OBJECTS),
)
ACTIONS = st.lists(st.one_of(EDIT, st.sampled_from(["undo", "redo"])), max_size=25)


def entry(number: int, action: Any, by: str | None = "ann") -> Any:
    common = {"number": number, "at": f"2026-01-01T00:00:{number % 60:02d}Z", "by": by}
    if isinstance(action, Edit):
        return Do(edit=action, **common)  # type: ignore[arg-type]
    return Undo(**common) if action == "undo" else Redo(**common)


def same(a: RGMap, b: RGMap) -> bool:
    """Equal, and their items in the same order."""
    return a == b and all(list(getattr(a, k)) == list(getattr(b, k)) for k in KINDS)


@given(actions=ACTIONS)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_any_sequence_of_entries_equals_the_fold_of_what_stands(office: RGMap, actions: list) -> None:
    """Against the plainest model: two stacks of edits, and the map always folded from the base."""
    history, kept = History.of(office), []
    done: list[Do] = []
    undone: list[Do] = []
    for number, action in enumerate(actions, 1):
        e = entry(number, action)
        try:
            history = step(history, e)
        except EditError:
            continue
        kept.append(e)
        if isinstance(e, Do):
            done, undone = [*done, e], []
        elif isinstance(e, Undo):
            undone, done = [*undone, done[-1]], done[:-1]
        else:
            done, undone = [*done, undone[-1]], undone[:-1]
    fold = History.of(office)
    for e in done:
        fold = step(fold, e)
    assert same(history.map, fold.map)
    assert [d.entry for d in history.done] == done
    assert [d.entry for d in history.undone] == undone
    again, notes = replay(office, kept)
    assert same(again.map, history.map)
    assert notes == []


@given(actions=ACTIONS)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_undoing_everything_gives_the_base_and_redoing_everything_the_map(office: RGMap, actions: list) -> None:
    history, _ = replay(office, [entry(n, a) for n, a in enumerate(actions, 1)])
    reached, number = history.map, len(actions)
    count = len(history.done)
    for _ in range(count):
        number += 1
        history = step(history, entry(number, "undo"))
    assert same(history.map, office)
    for _ in range(count):
        number += 1
        history = step(history, entry(number, "redo"))
    assert same(history.map, reached)


def test_there_may_be_nothing_to_undo_or_redo(office: RGMap) -> None:
    history = History.of(office)
    assert history.undo_title is None
    assert history.redo_title is None
    with pytest.raises(EditError, match="nothing to undo"):
        step(history, entry(1, "undo"))
    with pytest.raises(EditError, match="nothing to redo"):
        step(history, entry(1, "redo"))


def test_undo_and_redo_are_named(office: RGMap) -> None:
    history = step(History.of(office), entry(1, ClassifyRegion(region="r3", class_="CC")))
    history = step(history, entry(2, DeleteGateway(gateway="g1")))
    assert (history.undo_title, history.redo_title) == ("delete g1", None)
    history = step(history, entry(3, "undo"))
    assert (history.undo_title, history.redo_title) == ("relabel r3 as CC", "delete g1")
    history = step(history, entry(4, RenameRegion(region="r1", name="Flur")))
    assert (history.undo_title, history.redo_title) == ("rename r1 to Flur", None)


def test_untouched_items_stay_the_same_objects(office: RGMap) -> None:
    after = step(History.of(office), entry(1, ClassifyRegion(region="r3", class_="CC"))).map
    assert after.lines is office.lines
    assert after.gateways is office.gateways
    assert after.regions["r1"] is office.regions["r1"]
    assert after.regions["r3"] is not office.regions["r3"]


def test_provenance_says_who_when_and_by_which_edits(office: RGMap) -> None:
    history = step(History.of(office), entry(1, ClassifyRegion(region="r3", class_="CC")))
    history = step(history, entry(2, RenameRegion(region="r3", name="Lab"), by="bob"))
    p = history.map.regions["r3"].provenance
    assert (p.source, p.by, p.at, p.edits) == ("edited", "bob", "2026-01-01T00:00:02Z", (1, 2))
    assert history.map.regions["r1"].provenance.source == "auto"
    back = step(history, entry(3, "undo")).map.regions["r3"].provenance
    assert (back.by, back.edits) == ("ann", (1,))


def test_what_a_person_made_stays_a_persons(office: RGMap) -> None:
    seed = SeedObject(id="ou00000001", lines=("l6",), center=(1.0, 1.0, 0.5), size=(1.0, 1.0, 1.0), yaw=0.0)
    history = step(History.of(office), entry(1, seed))
    history = step(history, entry(2, LabelObject(object="ou00000001", label="shelf")))
    p = history.map.objects["ou00000001"].provenance
    assert (p.source, p.edits) == ("human", (1, 2))


def test_replay_on_a_foreign_base_tells_and_goes_on(office: RGMap) -> None:
    """A base that was exchanged by hand: the refused edit keeps its place, so that undo takes back what it did."""
    entries = [
        entry(1, RenameRegion(region="r1", name="Flur")),
        entry(2, DeleteGateway(gateway="g77")),
        entry(3, "undo"),
    ]
    history, notes = replay(office, entries)
    assert notes == ["edit 2 has no effect: there is no gateway g77 in this map"]
    assert history.map.regions["r1"].name == "Flur"
    assert history.redo_title == "delete g77"
