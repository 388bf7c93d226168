"""Loop closures: how far old keyframes may be off, and which closures belong together."""

from __future__ import annotations

import numpy as np

from rgcore.geometry import se2
from rgcore.slam.local import Match
from rgcore.slam.loops import Closure, consistent
from rgcore.slam.ways import Ways


def test_the_way_to_an_old_keyframe_grows_until_a_shortcut_is_found() -> None:
    ways = Ways()
    for _ in range(100):
        ways.advance(0.5)
    assert ways.length[0] == 49.5
    assert ways.length[-1] == 0.0
    ways.shortcut(99, 0, 1.0)
    assert ways.length[0] == 1.0
    assert ways.length[10] == 6.0, "past the shortcut and on"
    assert ways.length[60] == 19.5, "the old way is still the shorter one"
    ways.advance(0.5)
    assert ways.length[0] == 1.5


def test_closures_agree_when_they_ask_for_the_same_correction() -> None:
    nothing = Match(np.zeros(3), np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros(0), 1.0)
    at, asked = np.array([20.0, 10.0, 1.0]), np.array([0.8, -0.3, 0.05])

    def closure(number: int, correction: np.ndarray) -> Closure:
        return Closure(number, np.arange(3), nothing, correction)

    alike = [closure(k, asked + 0.001 * k) for k in range(3)]
    liar = closure(9, se2.compose(asked, np.array([1.5, 0.0, 0.0])))
    found = consistent([alike[0], liar, alike[1], alike[2]], at)
    assert [c.keyframe for c in found] == [0, 1, 2]
    assert [c.keyframe for c in consistent([*alike, liar], at)] == [9]
