"""Mapping again: things are recognised by geometry, edits carried by the types of their fields, doubt is told."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Annotated

import msgspec
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec import Meta
from two_rooms import make_run

from rgcore.geometry import se2
from rgcore.model.draft import object_from_lines
from rgcore.model.edits import (
    ClassifyGateway,
    ClassifyRegion,
    DeleteObject,
    Edit,
    LabelObject,
    MoveGateway,
    MoveObject,
    RenameRegion,
    SeedObject,
)
from rgcore.model.fields import LineId, Place, RegionId
from rgcore.model.history import KINDS, Do, History, step
from rgcore.model.identify import match
from rgcore.model.outcome import Outcome
from rgcore.model.rebase import Drift, Source, Stale, carry, ids_of, rebase
from rgcore.model.records import Point, RGMap, replace
from rgcore.slam.trajectory import Trajectory

AT = "2026-01-01T00:00:00Z"


def moved_map(map: RGMap, by: tuple[float, float, float], order: dict[str, str] | None = None) -> RGMap:
    """The map as another run may make it: moved as a whole, and its things numbered otherwise (new id by old id)."""

    def p(point: Point) -> Point:
        x, y = se2.transform(np.array(by), np.array(point))
        return round(float(x), 6), round(float(y), 6)

    def name(id: str) -> str:
        return (order or {}).get(id, id)

    def names(ids: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(name(i) for i in ids)

    new = {
        "lines": [
            replace(v, id=name(v.id), start=p(v.start), end=p(v.end), regions=names(v.regions))
            for v in map.lines.values()
        ],
        "regions": [replace(v, id=name(v.id), boundary=tuple(p(q) for q in v.boundary)) for v in map.regions.values()],
        "gateways": [
            replace(v, id=name(v.id), posts=(p(v.posts[0]), p(v.posts[1])), regions=names(v.regions))
            for v in map.gateways.values()
        ],
        "objects": [
            replace(v, id=name(v.id), center=(*p(v.center[:2]), v.center[2]), lines=names(v.lines))
            for v in map.objects.values()
        ],
    }
    return RGMap(**{k: {v.id: v for v in sorted(items, key=lambda v: v.id)} for k, items in new.items()})


def all_ids(map: RGMap) -> list[str]:
    return [id for kind in KINDS for id in getattr(map, kind)]


def shuffled(map: RGMap, seed: int) -> dict[str, str]:
    rng = np.random.default_rng(seed)
    return {
        a: str(b)
        for kind in KINDS
        for a, b in zip(getattr(map, kind), rng.permutation(list(getattr(map, kind))), strict=True)
    }


def drift(by: tuple[float, float, float]) -> Drift:
    run = make_run(RGMap())
    old = run.trajectory
    return Drift(old, Trajectory(old.stamps, se2.compose(np.array(by), old.map_from_base), old.base_from_laser))


def carried_over(run: str, history: History, new: RGMap, by: Drift) -> tuple[list, list[Outcome]]:
    """The journal of the new run, and the edits that wait."""
    found = rebase(Source(run, history, by), new)
    return found.entries, [o for o in found.outcomes if o.waits]


MOTION = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-0.5, 0.5))
FIXTURE = [HealthCheck.function_scoped_fixture]


@given(by=MOTION, seed=st.integers(0, 1000))
@settings(max_examples=25, deadline=None, suppress_health_check=FIXTURE)
def test_everything_is_recognised_after_moving_and_renumbering(office: RGMap, by: tuple, seed: int) -> None:
    order = shuffled(office, seed)
    assert match(office, moved_map(office, by, order), all_ids(office), drift(by).points) == order


def test_the_two_faces_of_a_wall_are_not_mixed_up(office: RGMap) -> None:
    """l2 and l3 lie 0.1 m from each other and look away from each other."""
    swapped = {"l2": "l3", "l3": "l2"}
    assert match(office, moved_map(office, (0.05, 0.05, 0.0), swapped), ["l2", "l3"]) == swapped


def test_what_is_gone_or_doubtful_has_no_counterpart(office: RGMap) -> None:
    r2 = office.regions["r2"]
    left = replace(r2, id="r4", boundary=((0.0, 2.1), (2.0, 2.1), (2.0, 6.0), (0.0, 6.0)))
    right = replace(r2, boundary=((2.0, 2.1), (4.0, 2.1), (4.0, 6.0), (2.0, 6.0)))
    halved = replace(office, regions={"r1": office.regions["r1"], "r2": right, "r4": left})
    assert match(office, halved, ["r1", "r2", "r3"]) == {"r1": "r1"}
    twin = replace(office.gateways["g1"], id="g3", posts=((1.6, 2.05), (2.6, 2.05)))
    doubled = replace(office, gateways={**office.gateways, "g3": twin})
    assert match(office, doubled, ["g1", "g2"]) == {"g2": "g2"}
    assert match(office, RGMap(), all_ids(office)) == {}


def test_places_move_with_the_scans_near_them() -> None:
    """The second half of the drive was corrected by 1 m: places there move along, the others stay."""
    run = make_run(RGMap())
    old = run.trajectory
    new = old.map_from_base.copy()
    new[20:, 1] += 1.0
    found = Drift(old, Trajectory(old.stamps, new, old.base_from_laser)).points(np.array([[0.5, 2.0], [7.5, 2.0]]))
    assert np.allclose(found, [[0.5, 2.0], [7.5, 3.0]])


@pytest.mark.parametrize("scans", [slice(0, 25), slice(0, None, 2), slice(5, None)])
def test_scans_are_found_again_in_a_longer_shorter_or_thinned_log(scans: slice) -> None:
    old = make_run(RGMap()).trajectory
    kept = old[scans]
    new = Trajectory(kept.stamps, kept.map_from_base + np.array([0.0, 2.0, 0.0]), kept.base_from_laser)
    for a, b, sign in ((old, new, 1), (new, old, -1)):
        assert np.allclose(Drift(a, b).points(np.array([[3.0, 1.0]])), [[3.0, 1.0 + 2 * sign]])


CARRIED: list[Edit] = [
    RenameRegion(region="r2", name="Lab"),
    ClassifyRegion(region="r3", class_="CC"),
    ClassifyGateway(gateway="g2", class_="opening"),
    MoveGateway(gateway="g1", posts=((1.5, 2.05), (2.4, 2.05)), gateway_points=((2.0, 1.5), (2.0, 2.6))),
    SeedObject(
        id="ou00000001",
        lines=("l6", "l7"),
        center=(1.6, 5.8, 0.5),
        size=(1.2, 0.4, 1.0),
        yaw=0.1,
        region="r2",
        label="x",
    ),
    MoveObject(object="ou00000001", center=(1.7, 5.8, 0.5), size=(1.2, 0.5, 1.1), yaw=0.2),
    LabelObject(object="ou00000001", label="shelf"),
    DeleteObject(object="o1"),
]


@given(by=MOTION, seed=st.integers(0, 1000))
@settings(max_examples=15, deadline=None, suppress_health_check=FIXTURE)
def test_every_kind_of_edit_is_carried_to_the_same_things(office: RGMap, by: tuple, seed: int) -> None:
    """Edits carried over and made on the moved map = the edited map, moved."""
    order, history = shuffled(office, seed), History.of(office)
    for number, edit in enumerate(CARRIED, 1):
        history = step(history, Do(number=number, at=AT, by="ann", edit=edit))  # type: ignore[arg-type]
    base = moved_map(office, by, order)
    taken, lost = carried_over("0001", history, base, drift(by))
    assert lost == []
    assert [(e.number, e.at, e.by) for e in taken] == [(n, AT, "ann") for n in range(1, len(CARRIED) + 1)]
    new = History.of(base)
    for entry in taken:
        new = step(new, entry)
    expected = moved_map(history.map, by, order)
    for region in expected.regions.values():
        assert (new.map.regions[region.id].name, new.map.regions[region.id].class_) == (region.name, region.class_)
    for gateway in expected.gateways.values():
        assert np.allclose(new.map.gateways[gateway.id].posts, gateway.posts, atol=1e-4)
        assert new.map.gateways[gateway.id].class_ == gateway.class_
    (made,) = new.map.objects.values()
    (wanted,) = expected.objects.values()
    assert np.allclose(made.center, wanted.center, atol=1e-4)
    assert (made.id, made.label, made.size, made.lines) == (wanted.id, "shelf", wanted.size, wanted.lines)
    assert made.region == order["r2"]
    assert abs(math.remainder(made.yaw - 0.2 - by[2], 2 * math.pi)) < 1e-4


def test_on_the_same_map_an_edit_is_carried_unchanged(office: RGMap) -> None:
    same = drift((0.0, 0.0, 0.0))
    identity = {id: id for id in all_ids(office)}
    for edit in CARRIED:
        assert carry(edit, identity, same) == edit  # type: ignore[arg-type]


class MergeRegions(Edit, frozen=True):
    """One that is not written yet."""

    regions: tuple[RegionId, RegionId]
    along: Annotated[tuple[LineId, ...], Meta(max_length=9)] | None
    at: Place | None = None
    name: str = "r1"


def test_an_edit_of_a_future_kind_needs_no_code_here() -> None:
    edit = MergeRegions(regions=("r1", "r2"), along=("l3",), at=(1.0, 1.0))
    carried = carry(edit, {"r1": "r7", "r2": "r1", "l3": "l30"}, drift((1.0, 0.0, 0.0)))  # type: ignore[arg-type]
    assert carried == MergeRegions(regions=("r7", "r1"), along=("l30",), at=(2.0, 1.0))
    assert ids_of(edit) == {"r1", "r2", "l3"}


def test_without_a_common_scan_nothing_is_guessed(office: RGMap) -> None:
    old = make_run(RGMap()).trajectory
    other = Trajectory(old.stamps + 1000.25, old.map_from_base, old.base_from_laser)
    with pytest.raises(Stale, match="share no scan"):
        carry(CARRIED[3], {"g1": "g1"}, Drift(old, other))  # type: ignore[arg-type]
    history = step(History.of(office), Do(number=1, at=AT, edit=RenameRegion(region="r2", name="Lab")))
    taken, lost = carried_over("0001", history, office, Drift(old, other))
    assert (taken, [str(c) for c in lost]) == ([], ["rename r2 to Lab: the two runs share no scan"])


def test_one_stamp_for_all_scans_tells_nothing_unless_the_log_is_the_same() -> None:
    old = make_run(RGMap()).trajectory
    blind = Trajectory(np.zeros(40), old.map_from_base, old.base_from_laser)
    assert Drift(blind, blind, same_log=True).known
    assert not Drift(blind, blind).known
    assert not Drift(blind, blind[::2], same_log=True).known


def test_what_cannot_be_carried_is_told_and_what_follows_from_it_too(office: RGMap) -> None:
    seed = object_from_lines(office, ["l6", "l7"])
    history = History.of(office)
    for number, edit in enumerate(
        [seed, LabelObject(object=seed.id, label="shelf"), RenameRegion(region="r1", name="x")], 1
    ):
        history = step(history, Do(number=number, at=AT, edit=edit))  # type: ignore[arg-type]
    new = replace(office, lines={k: v for k, v in office.lines.items() if k != "l7"})
    taken, lost = carried_over("0003", history, new, drift((0.0, 0.0, 0.0)))
    assert [e.edit for e in taken] == [RenameRegion(region="r1", name="x")]
    assert [(c.kind, c.run, c.entry.number) for c in lost] == [("stale", "0003", 1), ("conflict", "0003", 2)]
    assert [str(c) for c in lost] == [
        "make an object of 2 lines: l7 has no clear counterpart in the new map",
        f"label {seed.id} as shelf: there is no object {seed.id} in this map",
    ]
    assert msgspec.json.decode(msgspec.json.encode(lost), type=list[Outcome]) == lost


def test_what_the_new_map_says_already_still_stands(office: RGMap) -> None:
    """A correction that the pipeline now makes by itself is kept: a third run may err again."""
    history = step(History.of(office), Do(number=1, at=AT, edit=ClassifyRegion(region="r3", class_="CC")))
    right = replace(office, regions={**office.regions, "r3": replace(office.regions["r3"], class_="CC")})
    taken, lost = carried_over("0001", history, right, drift((0.0, 0.0, 0.0)))
    assert (len(taken), lost) == (1, [])


def test_edits_survive_two_runs_on_disk(tmp_path: object, office: RGMap, run: SimpleNamespace) -> None:
    from rgcore.model.project import Project

    by = (0.3, -0.2, 0.05)
    order = {"r1": "r3", "r3": "r1"}
    again = make_run(moved_map(office, by, order))
    again.trajectory = Trajectory(
        run.trajectory.stamps, se2.compose(np.array(by), run.trajectory.map_from_base), run.trajectory.base_from_laser
    )
    with Project.create(tmp_path / "office.rg", run) as project:  # type: ignore[operator]
        project.do(RenameRegion(region="r3", name="Lab"))
        made = project.do(object_from_lines(project.map, ["l6", "l7", "l8"]))
        first = next(v for k, v in made.objects.items() if k != "o1")
        assert project.add_run(again) == ()
        assert project.map.regions["r1"].name == "Lab"
        assert project.add_run(run) == ()
        assert project.map.regions["r3"].name == "Lab"
        assert np.allclose(project.map.objects[first.id].center, first.center, atol=1e-5)
        assert project.map.objects[first.id].yaw == pytest.approx(first.yaw, abs=1e-5)
