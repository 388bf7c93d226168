"""What one key does to a selection becomes the right edit, and one undo step."""

from __future__ import annotations

import pytest
from office_map import office_map

from rgcore.errors import EditError
from rgcore.model.edits import (
    ClassifyGateway,
    ClassifyRegion,
    Confirm,
    DeleteLines,
    DeleteObject,
    LabelObject,
    MergeRegions,
    RejectObject,
    RenameRegion,
    Several,
)
from rgcore.model.history import Do, History, step
from rgviz import actions
from rgviz.commands import ANY, BY_NAME, COMMANDS, fitting, split_key, spoken
from rgviz.picking import Item

MAP = office_map(4, 1, 2)
ROOMS = tuple(Item("region", r) for r in ("r3", "r4", "r5"))
PIECES = tuple(Item("line", v.id) for v in MAP.lines.values() if v.regions == ("r2",))


def test_edits_of_each_kind() -> None:
    assert actions.relabel((Item("region", "r4"),), "  my   kitchen ") == ClassifyRegion(
        region="r4", class_="my kitchen"
    )
    assert actions.relabel((Item("gateway", "g1"),), "opening") == ClassifyGateway(gateway="g1", class_="opening")
    assert actions.rename(Item("region", "r4"), " Lab 2 ") == RenameRegion(region="r4", name="Lab 2")
    assert actions.rename(Item("object", "o1"), "printer") == LabelObject(object="o1", label="printer")
    for refused in (
        lambda: actions.relabel((Item("line", "l1"),), "x"),
        lambda: actions.rename(Item("line", "l1"), "x"),
        lambda: actions.merge(ROOMS[:1]),
        lambda: actions.join(ROOMS),
        lambda: actions.revert(MAP, ROOMS),
    ):
        with pytest.raises(EditError):
            refused()


def test_digits_mean_the_classes_of_what_is_selected() -> None:
    edit = actions.relabel_by_digit(ROOMS, 4)
    assert isinstance(edit, Several)
    assert {edit.apply(MAP).regions[i.id].class_ for i in ROOMS} == {"CC"}
    assert edit.title(MAP) == "relabel 3 regions as CC"
    gate = actions.relabel_by_digit((Item("gateway", "g1"),), 5)
    assert gate.apply(MAP).gateways["g1"].class_ == "opening"
    with pytest.raises(EditError, match="4 classes"):
        actions.relabel_by_digit(ROOMS, 5)


def test_anything_can_be_deleted_in_one_step() -> None:
    for items in (ROOMS[:1], ROOMS, PIECES, (Item("gateway", "g1"), Item("gateway", "g2"))):
        after = actions.delete(MAP, items).apply(MAP)
        assert not {i.id for i in items} & {*after.regions, *after.lines, *after.gateways}
    many = tuple(Item("line", f"l{n}") for n in range(2500))
    split = actions.delete(MAP, many)
    assert isinstance(split, Several)
    assert [len(e.lines) for e in split.edits if isinstance(e, DeleteLines)] == [1000, 1000, 500]


def test_a_guess_is_rejected_and_an_own_object_deleted() -> None:
    assert actions.delete(MAP, (Item("object", "o1"),)) == RejectObject(object="o1")
    lines = tuple(Item("line", v) for v in MAP.objects["o1"].lines)
    seeded = actions.box(MAP, lines, 1.5)
    history = step(History.of(MAP), Do(number=1, at="2026-01-01T00:00:00Z", edit=seeded))  # type: ignore[arg-type]
    made = next(o for o in history.map.objects.values() if o.provenance.source == "human")
    assert made.size[2] == 1.5
    assert actions.delete(history.map, (Item("object", made.id),)) == DeleteObject(object=made.id)


def test_merge_keeps_the_first_and_clutter_goes_both_ways() -> None:
    edit = actions.merge((ROOMS[1], Item("region", "r2")))
    assert edit == MergeRegions(regions=("r4", "r2"))
    assert "r2" not in edit.apply(MAP).regions
    things = actions.clutter(MAP, PIECES).apply(MAP)
    assert all(things.lines[i.id].clutter for i in PIECES)
    assert not any(actions.clutter(things, PIECES).apply(things).lines[i.id].clutter for i in PIECES)


def test_confirming_revoking_and_reverting() -> None:
    assert actions.confirm(ROOMS) == Confirm(items=("r3", "r4", "r5"))
    sure = actions.confirm((Item("object", "o1"),)).apply(MAP)
    assert sure.objects["o1"].confidence == 1.0
    assert sure.objects["o1"].provenance.confirmed
    again = actions.unconfirm((Item("object", "o1"),)).apply(sure)
    assert not again.objects["o1"].provenance.confirmed
    entry = Do(number=1, at="2026-01-01T00:00:00Z", edit=actions.relabel(ROOMS[:2], "CC"))  # type: ignore[arg-type]
    history = step(History.of(MAP), entry)
    back = actions.revert(history.map, ROOMS)
    assert back.title(history.map) == "revert 2 regions to automatic"
    assert back.apply(history.map, MAP).regions["r4"].class_ == MAP.regions["r4"].class_


def test_no_two_commands_share_a_key_and_none_flies_the_camera() -> None:
    keys = [k for c in COMMANDS for k in c.keys]
    assert len(keys) == len(set(keys))
    assert len(BY_NAME) == len(COMMANDS)
    assert all(c.title and c.group for c in COMMANDS)
    flying = {"W", "A", "S", "D", "Q", "E", "arrowup", "arrowdown", "arrowleft", "arrowright"}
    assert not [k for k in keys if split_key(k)[0] in flying]
    assert split_key("cmd/ctrl+shift+Z") == ("Z", "cmd/ctrl+shift")
    assert spoken("cmd/ctrl+shift+Z") == "Ctrl+Shift+Z"


def test_commands_know_what_they_work_on() -> None:
    names = {c.name for c in fitting(ROOMS[:1])}
    assert {"class-1", "rename", "delete", "reshape", "lines", "confirm"} <= names
    assert not names & {"merge", "join", "box", "class-5"}
    assert "merge" in {c.name for c in fitting(ROOMS)}
    assert {"join", "align", "clutter", "box"} <= {c.name for c in fitting(PIECES)}
    assert "class-5" in {c.name for c in fitting((Item("gateway", "g1"),))}
    assert fitting(()) == []
    assert set(ANY) >= {k for c in COMMANDS for k in c.kinds}
