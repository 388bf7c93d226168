"""Edits: what each does, that it leaves the rest alone, and what it refuses, in a sentence."""

from __future__ import annotations

import math
import re
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from two_rooms import make_run

from rgcore.errors import EditError
from rgcore.model.boxes import fit_box
from rgcore.model.checks import broken
from rgcore.model.draft import object_from_lines
from rgcore.model.edits import (
    EDITS,
    AddBackdrop,
    AddGateway,
    AddNote,
    AddObject,
    AddRegion,
    AlignBackdrop,
    AlignLines,
    AssignGateway,
    AssignLines,
    ClassifyGateway,
    ClassifyRegion,
    Confirm,
    ConfirmObject,
    DeleteBackdrop,
    DeleteGateway,
    DeleteLines,
    DeleteNote,
    DeleteObject,
    DeleteRegion,
    DrawLine,
    Edit,
    HeedFinding,
    IgnoreFinding,
    JoinLines,
    LabelObject,
    MarkClutter,
    MergeRegions,
    MoveGateway,
    MoveGatewayPoints,
    MoveLine,
    MoveNote,
    MoveObject,
    RejectObject,
    RenameGateway,
    RenameRegion,
    ReshapeRegion,
    RevertToAutomatic,
    SeedObject,
    Several,
    SplitLine,
    SplitRegion,
    Unconfirm,
    WriteNote,
    decode_edit,
)
from rgcore.model.history import KINDS, difference
from rgcore.model.rebase import Drift, carry, ids_of
from rgcore.model.records import RGMap
from rgcore.slam.trajectory import Trajectory

NEW = "ou0123abcd"
SEED = SeedObject(
    id=NEW, lines=("l6", "l7"), center=(1.6, 5.8, 0.5), size=(1.2, 0.4, 1.0), yaw=0.0, label="shelf", region="r2"
)
WIDER = ((0.0, 2.1), (4.05, 2.1), (4.05, 6.0), (0.0, 6.0))
ALCOVE = ((8.0, 0.0), (10.0, 0.0), (10.0, 2.0), (8.0, 2.0))
BOX = {"center": (7.0, 5.0, 0.4), "size": (1.0, 0.4, 0.8), "yaw": 0.2}
LAID = {"center": (4.0, 3.0), "yaw": -0.5, "length": 21.0}
GOOD: list[tuple[Edit, str, str]] = [  # edit, what it changes, its name
    (ClassifyRegion(region="r3", class_="CC"), "r3", "relabel r3 as CC"),
    (RenameRegion(region="r2", name="Labor für Öle"), "r2", "rename r2 to Labor für Öle"),
    (ReshapeRegion(region="r2", boundary=WIDER), "r2", "reshape r2"),
    (SplitRegion(region="r1", cut=((4.0, 0.5), (4.0, 1.5)), id="ru00000001"), "g2 r1 ru00000001", "split r1"),
    (MergeRegions(regions=("r2", "r1")), "g1 g2 l1 l2 r1 r2", "merge r2 and r1"),
    (AddRegion(id="ru00000001", boundary=ALCOVE, name="Alcove"), "ru00000001", "add the region Alcove"),
    (DeleteRegion(region="r3"), "g2 l12 l4 narrow-gateway:g2 o1 r3", "delete r3"),
    (ClassifyGateway(gateway="g1", class_="opening"), "g1", "relabel g1 as opening"),
    (RenameGateway(gateway="g1", name="Main door"), "g1", "rename g1 to Main door"),
    (MoveGateway(gateway="g1", posts=((1.0, 2.05), (1.8, 2.05))), "g1", "move g1"),
    (MoveGatewayPoints(gateway="g1", crossing_points=((1.9, 2.05),)), "g1", "move points of g1"),
    (
        AddGateway(id="gu00000001", posts=((4.05, 4.0), (4.05, 5.0)), regions=("r2", "r3")),
        "gu00000001",
        "add a gateway between r2 and r3",
    ),
    (AssignGateway(gateway="g1", regions=("r2", "r1")), "g1", "let g1 join r2 and r1"),
    (DeleteGateway(gateway="g2"), "g2 narrow-gateway:g2", "delete g2"),
    (DrawLine(id="lu00000001", start=(4.1, 6.0), end=(4.1, 2.1)), "lu00000001", "draw a wall"),
    (MoveLine(line="l1", start=(0.0, 0.0), end=(7.9, 0.0)), "l1", "move l1"),
    (JoinLines(lines=("l3", "l4")), "l3 l4", "join l3 and l4"),
    (SplitLine(line="l12", at=(5.0, 6.1), id="lu00000001"), "l12 lu00000001 o1", "split l12"),
    (AlignLines(lines=("l1", "l5"), direction=0.1), "l1 l5", "align l1 and l5"),
    (MarkClutter(lines=("l6", "l7", "l8")), "l6 l7 l8", "mark l6, l7 and l8 as clutter"),
    (AssignLines(lines=("l2", "l3"), region="r1"), "l3", "let l2 and l3 bound r1"),
    (DeleteLines(lines=("l12", "l8", "l6", "l7")), "l12 l6 l7 l8 o1", "delete 4 lines"),
    (SEED, NEW, "make an object of 2 lines"),
    (AddObject(id=NEW, label="plant", **BOX), NEW, "add plant"),
    (MoveObject(object="o1", **BOX), "o1", "move o1"),
    (LabelObject(object="o1", label="printer"), "o1", "label o1 as printer"),
    (ConfirmObject(object="o1"), "o1", "confirm o1"),
    (RejectObject(object="o1"), "nu00000001 o1", "reject o1"),
    (DeleteObject(object="o1"), "nu00000001 o1", "delete o1"),
    (AddNote(id="nu00000002", text="look\nagain", place=(1.0, 1.0), item="l1"), "nu00000002", "add a note on l1"),
    (WriteNote(note="nu00000001", text="is back"), "nu00000001", "change the note nu00000001"),
    (MoveNote(note="nu00000001", place=(7.0, 5.0)), "nu00000001", "move the note nu00000001"),
    (DeleteNote(note="nu00000001"), "nu00000001", "delete the note nu00000001"),
    (
        AddBackdrop(id="bu00000002", name="roof.dxf", sha256="0" * 64, form="dxf", size=(20.0, 9.5), **LAID),
        "bu00000002",
        "lay roof.dxf under the map",
    ),
    (AlignBackdrop(backdrop="bu00000001", **LAID), "bu00000001", "align plan.png"),
    (DeleteBackdrop(backdrop="bu00000001"), "bu00000001", "take plan.png away"),
    (Confirm(items=("r1", "g1", "l1", "o1")), "g1 l1 o1 r1", "confirm 4 items"),
    (Unconfirm(items=("r1",)), "", "check r1 again"),
    (RevertToAutomatic(item="r1"), "", "revert r1 to automatic"),
    (
        IgnoreFinding(code="duplicate-name", items=("r2", "r3")),
        "duplicate-name:r2:r3",
        "ignore duplicate-name of r2 and r3",
    ),
    (HeedFinding(code="narrow-gateway", items=("g2",)), "narrow-gateway:g2", "heed narrow-gateway of g2"),
    (
        Several(name="tidy up", edits=(RenameRegion(region="r2", name="Lab"), DeleteObject(object="o1"))),
        "nu00000001 o1 r2",
        "tidy up",
    ),
]
MAKES = ("Add", "Seed", "Draw", "Split")
TAKES = ("Delete", "Reject", "Merge", "Join", "Heed", "Several")


def test_every_edit_is_known_to_journal_and_scripts_and_tested_here() -> None:
    direct = Edit.__subclasses__()
    written = {e for e in (*direct, *(s for d in direct for s in d.__subclasses__())) if e.__module__[:7] == "rgcore."}
    assert set(EDITS.values()) == written == {type(e) for e, _, _ in GOOD}


@pytest.mark.parametrize(
    ("edit", "items", "title"), GOOD, ids=lambda v: type(v).__name__ if isinstance(v, Edit) else ""
)
def test_an_edit_changes_its_items_alone_and_says_what_it_does(
    noted: RGMap, edit: Edit, items: str, title: str
) -> None:
    after = edit.apply(noted)
    assert sorted(c.id for c in difference(noted, after)) == items.split()
    assert edit.title(noted) == title
    assert broken(after) == []


@pytest.mark.parametrize("edit", [e for e, _, _ in GOOD], ids=lambda e: type(e).__name__)
def test_an_edit_survives_its_json(noted: RGMap, edit: Edit) -> None:
    again = decode_edit(msgspec.json.encode(edit))
    assert again == edit
    assert again.apply(noted) == edit.apply(noted)


@pytest.mark.parametrize("edit", [e for e, _, _ in GOOD], ids=lambda e: type(e).__name__)
def test_an_edit_says_what_shall_be(noted: RGMap, edit: Edit) -> None:
    """Made twice it changes nothing more; what makes or takes away an item is refused the second time."""
    once = edit.apply(noted)
    if type(edit).__name__.startswith(MAKES + TAKES):
        with pytest.raises(EditError, match=r"there is|is not ignored"):
            edit.apply(once)
    else:
        assert edit.apply(once) is once


@pytest.mark.parametrize("edit", [e for e, _, _ in GOOD], ids=lambda e: type(e).__name__)
def test_an_edit_is_carried_to_another_run(noted: RGMap, edit: Edit) -> None:
    """On the same map unchanged; where the map moved by (1, 2), all its places do, and nothing else does."""
    poses = make_run(noted).trajectory
    moved = Trajectory(poses.stamps, poses.map_from_base + np.array([1.0, 2.0, 0.0]), poses.base_from_laser)
    ids = {id: id for kind in KINDS for id in getattr(noted, kind)}
    assert carry(edit, ids, Drift(poses, poses)) == edit  # type: ignore[arg-type]
    there = carry(edit, ids, Drift(poses, moved))  # type: ignore[arg-type]
    back = carry(there, ids, Drift(moved, poses))
    assert np.allclose(numbers(edit), numbers(back), atol=2e-6)
    assert set(np.round(np.subtract(numbers(there), numbers(edit)), 5)) <= {0.0, 1.0, 2.0}
    assert ids_of(edit) <= set(ids)


def numbers(edit: Edit) -> list[float]:
    """All numbers of an edit, in order."""
    return [float(v) for v in re.findall(r"(?<![\w\"])-?\d+\.\d+", msgspec.json.encode(edit).decode())]


def test_classes_and_names_are_set(office: RGMap) -> None:
    assert ClassifyRegion(region="r3", class_="kitchen").apply(office).regions["r3"].class_ == "kitchen"
    assert RenameRegion(region="r3", name="Lab").apply(office).regions["r3"].name == "Lab"
    assert ClassifyGateway(gateway="g1", class_="opening").apply(office).gateways["g1"].class_ == "opening"
    assert RenameGateway(gateway="g1", name="").apply(office).gateways["g1"].name == ""
    assert LabelObject(object="o1", label="printer").apply(office).objects["o1"].label == "printer"


def test_deleting_takes_the_item_away(office: RGMap) -> None:
    assert list(DeleteGateway(gateway="g1").apply(office).gateways) == ["g2"]
    assert DeleteObject(object="o1").apply(office).objects == {}


def test_the_points_of_a_gateway_follow_its_posts(office: RGMap) -> None:
    """Moved by (1, 0.1), turned by 90 degrees, one and a half times as wide."""
    g = MoveGateway(gateway="g1", posts=((3.0, 1.4), (3.0, 2.9))).apply(office).gateways["g1"]
    assert g.width == pytest.approx(1.5)
    assert g.crossing_points == ((3.0, 2.15),)
    assert np.allclose(g.gateway_points, [(3.5, 2.15), (2.5, 2.15)], atol=1e-5)
    assert np.allclose(g.traversal_directions, [math.pi, 0.0], atol=1e-5)


def test_swapping_the_posts_does_not_swap_the_sides(office: RGMap) -> None:
    old = office.gateways["g1"]
    g = MoveGateway(gateway="g1", posts=(old.posts[1], old.posts[0])).apply(office).gateways["g1"]
    assert np.allclose(g.gateway_points, old.gateway_points)
    assert np.allclose(g.crossing_points, old.crossing_points)
    assert g.traversal_directions == pytest.approx(old.traversal_directions)


def test_points_of_a_gateway_can_be_given(office: RGMap) -> None:
    edit = MoveGateway(
        gateway="g1",
        posts=((1.0, 2.0), (2.0, 2.0)),
        crossing_points=((1.4, 2.0),),
        gateway_points=((1.4, 1.0), (1.4, 3.0)),
    )
    g = edit.apply(office).gateways["g1"]
    assert (g.crossing_points, g.gateway_points) == (((1.4, 2.0),), ((1.4, 1.0), (1.4, 3.0)))


def move(**changes: Any) -> MoveObject:
    return MoveObject(**{"object": "o1", "center": (1.0, 1.0, 0.5), "size": (1.0, 1.0, 1.0), "yaw": 0.0, **changes})


def seed(**changes: Any) -> SeedObject:
    return msgspec.structs.replace(SEED, **changes)


REFUSED: list[tuple[Edit, str]] = [
    (ClassifyRegion(region="r9", class_="CC"), "there is no region r9 in this map"),
    (ClassifyRegion(region="r1", class_=""), "class must be a name of 1 to 40 characters"),
    (ClassifyRegion(region="r1", class_="x" * 41), "class must be a name of 1 to 40 characters"),
    (ClassifyRegion(region="r1", class_=" CC"), "no space around it"),
    (ClassifyRegion(region="r1", class_="a\nb"), "class must be"),
    (ClassifyRegion(region="r1", class_="CC\n"), "class must be"),
    (ClassifyRegion(region="r1", class_="\u202eCC"), "class must be"),
    (ClassifyRegion(region="r1", class_="\ud800"), "surrogates"),
    (ClassifyRegion(region="r1", class_=7), "class must be"),  # type: ignore[arg-type]
    (ClassifyRegion(region=["r1"], class_="CC"), "region must be the id of a region"),  # type: ignore[arg-type]
    (ClassifyRegion(region="r" * 50, class_="CC"), "region must be the id of a region"),
    (RenameRegion(region="r9", name="Lab"), "there is no region r9 in this map"),
    (RenameRegion(region="r1", name=""), "name must be a name of 1 to 80 characters"),
    (RenameRegion(region="r1", name="   "), "name must be a name of 1 to 80 characters"),
    (ClassifyGateway(gateway="g9", class_="opening"), "there is no gateway g9 in this map"),
    (ClassifyGateway(gateway="g1", class_=""), "class must be a name"),
    (RenameGateway(gateway="g9", name="x"), "there is no gateway g9 in this map"),
    (RenameGateway(gateway="g1", name="x" * 81), "name must be at most 80 characters"),
    (MoveGateway(gateway="g9", posts=((0.0, 0.0), (1.0, 0.0))), "there is no gateway g9 in this map"),
    (MoveGateway(gateway="g1", posts=((0.0, 0.0), (0.0, 0.01))), "less than 5 cm apart"),
    (MoveGateway(gateway="g1", posts=((math.nan, 0.0), (1.0, 0.0))), "posts must be finite metres"),
    (MoveGateway(gateway="g1", posts=((math.inf, 0.0), (1.0, 0.0))), "posts must be finite metres"),
    (MoveGateway(gateway="g1", posts=((1e9, 0.0), (1.0, 0.0))), "at most 100 km"),
    (MoveGateway(gateway="g1", posts=((0.0,), (1.0, 0.0))), "posts must be points"),  # type: ignore[arg-type]
    (MoveGateway(gateway="g1", posts=((0.0, 0.0),)), "posts must be"),  # type: ignore[arg-type]
    (
        MoveGateway(gateway="g1", posts=((0.0, 0.0), (1.0, 0.0)), gateway_points=((0.5, 1.0),)),
        "g1 needs 2 gateway-points, one a region, not 1",
    ),
    (MoveGateway(gateway="g1", posts=((0.0, 0.0), (1.0, 0.0)), crossing_points=()), "crossing_points must be 1 to 16"),
    (DeleteGateway(gateway="g9"), "there is no gateway g9 in this map"),
    (seed(id="o2"), "id must be a new id like ou3f9c02aa"),
    (seed(id="ou0123ABCD"), "id must be a new id like ou3f9c02aa"),
    (seed(lines=()), "lines must name 1 to 1000 lines"),
    (seed(lines=("l6", "l99")), "there is no line l99 in this map"),
    (seed(lines=("l6", "l6")), "a line is named twice"),
    (seed(region="r9"), "there is no region r9 in this map"),
    (seed(size=(1.0, 0.0, 1.0)), "size must be lengths above 0"),
    (seed(yaw=math.nan), "yaw must be an angle"),
    (seed(label="x" * 81), "label must be at most 80 characters"),
    (move(object="o9"), "there is no object o9 in this map"),
    (move(center=(0.0, math.nan, 0.0)), "center must be finite metres"),
    (move(size=(1.0, -1.0, 1.0)), "size must be lengths above 0"),
    (move(size=(1.0, 1.0, 2000.0)), "up to 1000 m"),
    (move(yaw=100.0), "yaw must be an angle"),
    (move(yaw="a"), "yaw must be an angle"),
    (move(yaw=object()), "no value for an edit"),
    (LabelObject(object="o9", label="x"), "there is no object o9 in this map"),
    (LabelObject(object="o1", label="a\tb"), "label must be at most 80 characters on one line"),
    (DeleteObject(object="o9"), "there is no object o9 in this map"),
]


@pytest.mark.parametrize(("edit", "words"), REFUSED)
def test_a_refusal_is_a_sentence_and_changes_nothing(office: RGMap, edit: Edit, words: str) -> None:
    before = msgspec.json.encode(office)
    with pytest.raises(EditError, match=words) as refusal:
        edit.apply(office)
    assert "\n" not in str(refusal.value)
    assert msgspec.json.encode(office) == before


def test_an_id_is_not_given_twice(office: RGMap) -> None:
    with pytest.raises(EditError, match=f"already an object {NEW}"):
        SEED.apply(SEED.apply(office))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "not JSON"),
        ("[]", "unknown edit None"),
        (b"\xff", "not JSON"),
        ('{"edit":"Explode"}', "unknown edit 'Explode'; known are ClassifyRegion"),
        ('{"edit":["RenameRegion"]}', "unknown edit"),
        ('{"edit":"RenameRegion","region":"r1"}', "RenameRegion: object missing required field `name`"),
        ('{"edit":"RenameRegion","region":"r1","name":"x","y":1}', "unknown field `y`"),
        ('{"edit":"RenameRegion","region":"r1","name":3}', "name must be"),
        ('{"edit":"MoveGateway","gateway":"g1","posts":[[1,2],[3,"4"]]}', "posts must be finite metres"),
        ('{"edit":"MoveGateway","gateway":"g1","posts":[[1,2],[3,1e999]]}', "JSON|posts must be"),
        ('{"edit":"MoveObject","object":"o1","center":[1,2,3],"size":[1,1,1],"yaw":true}', "yaw must be"),
    ],
)
def test_json_that_is_no_edit_is_refused(text: str, words: str) -> None:
    with pytest.raises(EditError, match=words):
        decode_edit(text)


@given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.text(), lambda c: st.lists(c) | st.dictionaries(st.text(), c)
    )
)
@settings(max_examples=60, deadline=None)
def test_junk_never_becomes_anything_but_a_refusal(junk: Any) -> None:
    for name in EDITS:
        fields = junk if isinstance(junk, dict) else {"region": junk}
        with pytest.raises(EditError):
            decode_edit(msgspec.json.encode({"edit": name, **fields})).apply(RGMap())


def test_values_of_a_script_may_be_numpys(office: RGMap) -> None:
    moved = MoveObject(
        object="o1", center=np.array([1, 2, 0.5]), size=tuple(np.ones(3, np.float32)), yaw=np.float64(0.5)
    )  # type: ignore[arg-type]
    assert moved.apply(office).objects["o1"].center == (1.0, 2.0, 0.5)
    assert moved.checked() == decode_edit(msgspec.json.encode(moved.checked()))


def test_numbers_are_kept_as_the_document_has_them(office: RGMap) -> None:
    edit = MoveObject(object="o1", center=(1 / 3, -1e-9, 0.5), size=(1.0, 2 / 3, 1.0), yaw=0.1 + 0.2)
    moved = edit.apply(office).objects["o1"]
    assert (str(moved.center), str(moved.size), moved.yaw) == ("(0.333333, 0.0, 0.5)", "(1.0, 0.666667, 1.0)", 0.3)


def test_a_box_is_fitted_to_lines(office: RGMap) -> None:
    made = object_from_lines(office, ["l7", "l6", "l8", "l6"], height=0.9)
    assert (made.center, made.size, made.yaw) == ((1.6, 5.8, 0.45), (1.2, 0.4, 0.9), 0.0)
    assert (made.region, made.lines) == ("r2", ("l7", "l6", "l8"))
    assert made.apply(office).objects[made.id].provenance.source == "auto"  # the history signs it


def test_a_box_over_one_line_has_two_sides(office: RGMap) -> None:
    made = object_from_lines(office, ["l6"])
    assert made.size == (1.2, 0.05, 1.0)


def test_a_box_needs_lines_of_the_map(office: RGMap) -> None:
    with pytest.raises(EditError, match="there is no line l99"):
        object_from_lines(office, ["l6", "l99"])
    with pytest.raises(EditError, match="at least one line"):
        object_from_lines(office, [])
    with pytest.raises(EditError, match="size must be"):
        object_from_lines(office, ["l6"], height=-1.0)


@given(
    yaw=st.floats(-3.1, 3.1),
    size=st.tuples(st.floats(0.3, 4.0), st.floats(0.3, 4.0)),
    center=st.tuples(st.floats(-50, 50), st.floats(-50, 50)),
    sides=st.sets(st.integers(0, 3), min_size=3),
)
def test_the_box_of_a_rectangles_sides_is_that_rectangle(
    yaw: float, size: tuple, center: tuple, sides: set[int]
) -> None:
    half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(size) / 2
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    corners = half @ turn.T + center
    ends = np.array([[corners[i], corners[(i + 1) % 4]] for i in sides])
    found, extent, angle = fit_box(ends)
    assert np.allclose(found, center, atol=1e-4)
    assert np.allclose(extent, sorted(size, reverse=True), atol=1e-4)
    if abs(size[0] - size[1]) > 1e-3:
        along = yaw if size[0] > size[1] else yaw + math.pi / 2
        assert abs(math.remainder(angle - along, math.pi)) < 1e-4
    assert -math.pi / 2 - 1e-6 <= angle <= math.pi / 2 + 1e-6


def test_a_box_stands_along_the_walls_of_its_room() -> None:
    """A noisy front, 3 degrees off the main axis: the box stands along the axis."""
    slope = math.tan(math.radians(3))
    center, size, yaw = fit_box(np.array([[[0.0, 0.0], [1.0, slope]]]), axes=(0.0, 1.570796))
    assert yaw == 0.0
    assert size == pytest.approx((1.0, slope), abs=1e-5)
    assert center == pytest.approx((0.5, slope / 2), abs=1e-5)
