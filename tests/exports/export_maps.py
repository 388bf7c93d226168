"""Maps to export: two rooms and a door as a person would draw them, and any map at all."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from rgcore.model.records import (
    Backdrop,
    Box2,
    Gateway,
    Ignored,
    Line,
    MapObject,
    Note,
    Provenance,
    Region,
    RGMap,
    Source,
    Stats,
)
from rgcore.slam.trajectory import Trajectory

HOSTILE = 'Käpt\'n "Nemo" <Lab> & ]]> 東京\x07'

LAB = Region(
    id="r1",
    name=HOSTILE,
    class_="TOMA",
    class_scores={"TOMA": 0.75, "CC": 0.25},
    boundary=((0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)),
    holes=(((2.0, 1.0), (2.0, 2.0), (3.0, 2.0), (3.0, 1.0)),),
    box=Box2(center=(3.0, 2.0), size=(5.5, 3.5), yaw=0.0),
    axes=(0.0, 1.570796),
    accuracy=0.034,
    scans=12,
)
HALL = Region(
    id="r2",
    name="Hallway",
    class_="CDMA",
    class_scores={"CDMA": 1.0},
    boundary=((6.1, 0.0), (8.1, 0.0), (8.1, 10.0), (6.1, 10.0)),
    box=Box2(center=(7.1, 5.0), size=(9.5, 1.5), yaw=1.570796),
    axes=(1.570796,),
    provenance=Provenance(source="edited", by="ana", at="2026-01-02T03:04:05Z", edits=(4, 7)),
)
DOOR = Gateway(
    id="g1",
    name="Door",
    class_="narrow_passage",
    confidence=0.9,
    regions=("r1", "r2"),
    posts=((6.05, 1.5), (6.05, 2.5)),
    crossing_points=((6.05, 2.0),),
    gateway_points=((5.5, 2.0), (6.6, 2.0)),
    traversal_directions=(0.0, 3.141593),
    passed=True,
)
CABINET = MapObject(
    id="o1",
    label="cabinet",
    center=(1.0, 3.0, 0.6),
    size=(2.0, 0.5, 1.2),
    yaw=0.523599,
    lines=("l2", "l10"),
    region="r1",
    confidence=0.5,
)
LINES = (
    Line(id="l1", start=(0.0, 0.0), end=(6.0, 0.0), regions=("r1",), support=20, residual=0.011),
    Line(id="l2", start=(6.0, 0.0), end=(6.0, 1.5), regions=("r1",)),
    Line(id="l10", start=(6.1, 1.5), end=(6.1, 0.0), regions=("r2", "r1")),
    Line(id="l11", start=(8.1, 0.0), end=(8.1, 10.0), regions=("r2",)),
    Line(id="l12", start=(-1.0, 12.0), end=(0.0, 12.0)),
)
ROOMS = RGMap(
    source=Source(log="office.log", sha256="ab" * 32, format="carmen", settings={"slam.max_range": 12.0}),
    stats=Stats(scans=100, points=18000, segments=900, accuracy=0.05, accuracy_penalty=1.0),
    lines={line.id: line for line in LINES},
    regions={"r2": HALL, "r1": LAB},
    gateways={"g1": DOOR},
    objects={"o1": CABINET},
)
TRAJECTORY = Trajectory(
    stamps=np.array([976053945.94984, 976053945.94984, 976053944.5, 976053946.125]),
    map_from_base=np.array([[0.0, 0.0, 0.0], [1.0, 2.0, np.pi / 2], [1.0, 2.0, np.pi], [-1e-9, 0.0, -3.0]]),
    base_from_laser=np.array([0.25, 0.0, 0.0]),
)

_metre = st.floats(-1e4, 1e4)
_size = st.floats(0, 1e3)
_part = st.floats(0, 1)
_point = st.tuples(_metre, _metre)
_points = st.lists(_point, max_size=4).map(tuple)
_ring = st.lists(_point, min_size=3, max_size=6).map(tuple)
_id = st.from_regex(r"[lrgou][0-9a-z]{1,6}", fullmatch=True)
_text = st.text(max_size=20)
_maybe = st.none() | _size
_by = st.builds(
    Provenance,
    source=st.sampled_from(["auto", "human", "edited"]),
    by=st.none() | _text,
    at=st.none() | _text,
    edits=st.lists(st.integers(0, 1000), max_size=3).map(tuple),
    confirmed=st.booleans(),
)
_some_ids = st.lists(_id, max_size=3, unique=True).map(tuple)
_line = st.builds(
    Line,
    id=_id,
    start=_point,
    end=_point,
    regions=_some_ids,
    support=st.integers(0, 10**6),
    residual=_maybe,
    deviation=st.none() | st.tuples(_size, _size),
    clutter=st.booleans(),
    provenance=_by,
)
_region = st.builds(
    Region,
    id=_id,
    name=_text,
    class_=_text,
    class_scores=st.dictionaries(_text, _part, max_size=4),
    boundary=_ring,
    holes=st.lists(_ring, max_size=2).map(tuple),
    box=st.builds(Box2, center=_point, size=st.tuples(_size, _size), yaw=st.floats(-4, 4)),
    axes=st.lists(_part, max_size=2).map(tuple),
    accuracy=_maybe,
    scans=st.integers(0, 10**6),
    provenance=_by,
)
_gateway = st.builds(
    Gateway,
    id=_id,
    name=_text,
    class_=_text,
    confidence=_part,
    regions=_some_ids,
    posts=st.tuples(_point, _point),
    crossing_points=_points,
    gateway_points=_points,
    traversal_directions=st.lists(st.floats(-4, 4), max_size=4).map(tuple),
    passed=st.booleans(),
    provenance=_by,
)
_object = st.builds(
    MapObject,
    id=_id,
    label=_text,
    center=st.tuples(_metre, _metre, _metre),
    size=st.tuples(_size, _size, _size),
    yaw=st.floats(-4, 4),
    lines=_some_ids,
    region=st.none() | _id,
    confidence=_part,
    provenance=_by,
)
_note = st.builds(Note, id=_id, text=_text, place=_point, item=st.none() | _id, provenance=_by)
_ignored = st.builds(Ignored, id=_id, code=_text, items=_some_ids, provenance=_by)
_backdrop = st.builds(
    Backdrop,
    id=_id,
    name=_text,
    sha256=st.integers(0, 2**256 - 1).map(lambda n: f"{n:064x}"),
    form=st.sampled_from(["png", "jpg", "dxf"]),
    size=st.tuples(_size, _size),
    center=_point,
    yaw=st.floats(-4, 4),
    length=st.floats(0.01, 1e5),
    provenance=_by,
)


def _by_id(items: st.SearchStrategy) -> st.SearchStrategy:
    return st.lists(items, max_size=4, unique_by=lambda item: item.id).map(lambda found: {i.id: i for i in found})


any_map = st.builds(
    RGMap,
    source=st.builds(
        Source,
        log=_text,
        sha256=_text,
        settings=st.dictionaries(_text, st.integers(-9, 9) | st.booleans() | _text, max_size=3),
        software=_text,
    ),
    stats=st.builds(
        Stats,
        scans=st.integers(0, 10**9),
        points=st.integers(0, 10**9),
        segments=st.integers(0, 10**9),
        accuracy=_maybe,
        accuracy_penalty=_maybe,
    ),
    lines=_by_id(_line),
    regions=_by_id(_region),
    gateways=_by_id(_gateway),
    objects=_by_id(_object),
    notes=_by_id(_note),
    ignored=_by_id(_ignored),
    backdrops=_by_id(_backdrop),
)
"""Any map: the ids in it need not name anything, texts hold whatever people type."""
