"""Plans of their own: wide doors with a pillar between them, hallways that cross."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from building import Building, along, block, chain, survey

from rgcore.config import Config, Places
from rgcore.geometry import se2

TURNS = [(0.0, 0.0, 0.0), (3.0, -8.0, 0.5)]


def closed(*corners: tuple[float, float]) -> list[list[tuple[float, float]]]:
    return chain(*corners, corners[0])


@cache
def beside_a_pillar(frame: tuple[float, float, float]) -> Building:
    """A hallway and a room, joined by two doors of 1.2 m with a pillar of 0.4 m between them."""
    walls = [
        *chain((5.6, 2.0), (12, 2), (12, 0), (0, 0), (0, 2), (2.8, 2), (2.8, 2.2), (1, 2.2), (1, 7), (8, 7), (8, 2.2)),
        *chain((8, 2.2), (5.6, 2.2), (5.6, 2)),
        *block(4.0, 1.9, 4.4, 2.3),
        *block(1.0, 5.0, 1.5, 6.2),
        *block(7.4, 5.0, 8.0, 6.0),
    ]
    way = along((1, 1), (11, 1), (3.4, 1), (3.4, 3.5), (2, 4), (6, 6), (7, 3.5), (5.0, 3.4), (5.0, 1), (9, 1))
    return survey(frame, walls=np.array(walls, float), poses=way)


@pytest.mark.parametrize("frame", TURNS)
def test_a_pillar_makes_two_doors_of_a_wide_one(frame: tuple[float, float, float]) -> None:
    b = beside_a_pillar(frame)
    plan_from_map = se2.invert(b.map_from_plan)
    posts = sorted(np.sort(se2.transform(plan_from_map, np.array(g.posts))[:, 0]).tolist() for g in b.places.gateways)
    assert len(posts) == 2
    assert posts[0] == pytest.approx([2.8, 4.0], abs=0.12)
    assert posts[1] == pytest.approx([4.4, 5.6], abs=0.12)
    assert {g.regions for g in b.places.gateways} == {(0, 1)}
    assert all(g.passed for g in b.places.gateways)


CROSSINGS = {
    "junction_T": [(0, 0), (7, 0), (7, -8), (9, -8), (9, 0), (16, 0), (16, 2), (0, 2)],
    "junction_L": [(0, 0), (10, 0), (10, -8), (12, -8), (12, 2), (0, 2)],
    "junction_X": [
        (0, 0),
        (7, 0),
        (7, -8),
        (9, -8),
        (9, 0),
        (16, 0),
        (16, 2),
        (9, 2),
        (9, 10),
        (7, 10),
        (7, 2),
        (0, 2),
    ],
}
WAYS = {
    "junction_T": ((1, 1), (15, 1), (8, 1), (8, -7), (8, 1)),
    "junction_L": ((1, 1), (11, 1), (11, -7), (11, 1)),
    "junction_X": ((1, 1), (15, 1), (8, 1), (8, -7), (8, 9), (8, 1)),
}


@cache
def crossing(kind: str, split: bool) -> Building:
    config = Config(places=Places(split_hallways=split))
    return survey((2.0, 1.0, 0.3), config, np.array(closed(*CROSSINGS[kind]), float), along(*WAYS[kind]))


@pytest.mark.parametrize("kind", CROSSINGS)
def test_hallways_that_bend_or_cross_stay_one_region(kind: str) -> None:
    b = crossing(kind, False)
    assert len(b.places.regions) == 1
    assert not b.places.gateways


@pytest.mark.parametrize("kind", CROSSINGS)
def test_split_hallways_cuts_them_at_junctions_of_the_right_letter(kind: str) -> None:
    b = crossing(kind, True)
    assert len(b.places.regions) >= 2
    assert {g.class_ for g in b.places.gateways} == {kind}
