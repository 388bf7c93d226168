"""The work list of a review and the search of the lists."""

from __future__ import annotations

import pytest

from rgcore.errors import QueryError
from rgcore.model.doubt import next_after, work_list
from rgcore.model.edits import AddNote, ClassifyRegion, Confirm, DeleteGateway, RenameRegion
from rgcore.model.find import FIELDS, find
from rgcore.model.history import Do, History, step
from rgcore.model.lint import lint
from rgcore.model.records import RGMap, replace

AT = "2026-01-01T00:00:00Z"


@pytest.fixture
def unsure(office: RGMap) -> RGMap:
    """r1 sure, r2 between two classes, r3 badly drawn; g2 doubtful; o1 a guess; l12 rough."""
    regions = dict(office.regions)
    regions["r1"] = replace(regions["r1"], class_scores={"CDMA": 0.97, "TOMA": 0.03}, accuracy=0.05, scans=30)
    regions["r2"] = replace(regions["r2"], class_scores={"TOMA": 0.5, "CC": 0.45}, accuracy=0.06, scans=20)
    regions["r3"] = replace(regions["r3"], class_scores={"TOMA": 0.99, "CC": 0.01}, accuracy=0.4, scans=9)
    gateways = dict(office.gateways)
    gateways["g1"] = replace(gateways["g1"], confidence=0.99)
    gateways["g2"] = replace(gateways["g2"], confidence=0.7, passed=False)
    objects = {"o1": replace(office.objects["o1"], confidence=0.92)}
    lines = {**office.lines, "l12": replace(office.lines["l12"], residual=0.09)}
    return replace(office, regions=regions, gateways=gateways, objects=objects, lines=lines)


def test_the_most_doubtful_comes_first_with_its_reason(unsure: RGMap) -> None:
    listed = work_list(unsure)
    assert [d.item for d in listed] == ["r2", "r3", "g2", "l12"]
    assert [d.reasons[0] for d in listed] == [
        "TOMA (50 %) or CC (45 %)?",
        "drawn to 40 cm only",
        "a gateway with 70 % only",
        "its segments lie 9 cm off: more than one wall?",
    ]
    assert listed[2].reasons[1] == "seen but never driven through"
    assert all(0 < d.score <= 1 for d in listed)
    assert [d.score for d in listed] == sorted((d.score for d in listed), reverse=True)
    assert listed[2].place == (6.0, 2.05)


def test_what_is_confirmed_or_relabelled_is_off_the_list(unsure: RGMap) -> None:
    assert [d.item for d in work_list(Confirm(items=("r2", "l12")).apply(unsure))] == ["r3", "g2"]
    assert "r2" not in [d.item for d in work_list(ClassifyRegion(region="r2", class_="CC").apply(unsure))]


def test_findings_of_the_lint_are_reasons(unsure: RGMap) -> None:
    map = DeleteGateway(gateway="g2").apply(unsure)
    first = work_list(map, lint(map))[0]
    assert (first.item, first.reasons) == (
        "r3",
        ("r3 (Room 2) cannot be reached from the rest", "drawn to 40 cm only"),
    )


def test_everything_can_be_listed(unsure: RGMap) -> None:
    assert [d.item for d in work_list(unsure, everything=True)][-3:] == ["r1", "g1", "o1"]


def test_one_key_goes_through_the_list_and_round(unsure: RGMap) -> None:
    listed, at, seen = work_list(unsure), None, []
    for _ in range(5):
        doubt = next_after(listed, at)
        assert doubt is not None
        at = doubt.item
        seen.append(at)
    assert seen == ["r2", "r3", "g2", "l12", "r2"]
    assert next_after([], "r1") is None


def test_a_review_by_keys_empties_the_list(unsure: RGMap) -> None:
    map, count = unsure, 0
    while doubt := next_after(work_list(map, lint(map)), None):
        map, count = Confirm(items=(doubt.item,)).apply(map), count + 1
    assert count == 4


@pytest.mark.parametrize(
    ("text", "ids"),
    [
        ("", "r1 r2 r3 g1 g2 o1 l1 l2 l3 l4 l5 l6 l7 l8 l12 nu00000001"),
        ("class:TOMA accuracy>0.2", "r3"),
        ("class:toma", "r2 r3"),
        ("class:CDMA,narrow_passage", "r1 g1 g2"),
        ("kind:region -class:TOMA", "r1"),
        ("name~room", "r2 r3"),
        ('name:"Room 1 b"', "r2"),
        ("edited:yes", "r2 nu00000001"),
        ("source:edited", "r2"),
        ("state:confirmed", "r1"),
        ("kind:region state:unconfirmed", "r2 r3"),
        ("by:ann kind:region", "r1 r2"),
        ("kind:gateway width<1.5 width>=1", "g1 g2"),
        ("kind:gateway passed:no", "g2"),
        ("confidence<=0.7", "g2"),
        ("kind:line length>7.9", "l1 l2"),
        ("region:r3 kind:line", "l4 l12"),
        ('region:"room 1 b" kind:gateway', "g1"),
        ("residual>0.05", "l12"),
        ("area>15.9 kind:region", "r1"),
        ("score<0.6", "r2"),
        ("scans:9", "r3"),
        ("noted:yes", "g1"),
        ("hallway", "r1"),
        ("-hallway kind:region", "r2 r3"),
        ("shut", "nu00000001"),
        ("clutter:yes", ""),
        ("id:l1,l12", "l1 l12"),
    ],
)
def test_a_search_finds(unsure: RGMap, text: str, ids: str) -> None:
    history = History.of(unsure)
    note = AddNote(id="nu00000001", text="always shut", place=(2.0, 2.0), item="g1")
    for number, edit in enumerate((note, Confirm(items=("r1",)), RenameRegion(region="r2", name="Room 1 b")), 1):
        history = step(history, Do(number=number, at=AT, by="ann", edit=edit))  # type: ignore[arg-type]
    assert find(history.map, text) == ids.split()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hue:red", "hue:red: there is no field hue; there are accuracy, area"),
        ("acuracy>1", "there is no field acuracy; did you mean accuracy"),
        ("accuracy>much", "accuracy>much: much is no number"),
        ("accuracy>nan", "compare a number by"),
        ("accuracy~1", "compare a number by : < <= > or >="),
        ("class>3", "class>3: class is no number; use class:3 or class~3"),
        ("class:", "a value is missing after :"),
        ("kind:door", "kind is one of region, gateway, object, line, note"),
        ("edited:maybe", "edited is one of yes, no"),
        ('name:"Room', "a quote is not closed"),
    ],
)
def test_a_search_that_means_nothing_is_told(office: RGMap, text: str, words: str) -> None:
    with pytest.raises(QueryError, match=words) as e:
        find(office, text)
    assert "\n" not in str(e.value)


def test_every_field_may_be_asked_of_every_item(noted: RGMap) -> None:
    for field, (_, says) in FIELDS.items():
        value = "1" if says == "number" else (says.split() or ["x"])[0]
        assert set(find(noted, f"{field}:{value}")) | set(find(noted, f"-{field}:{value}")) == set(find(noted, ""))
