"""The points of a gateway follow its posts."""

from __future__ import annotations

import math

import numpy as np

from rgcore.model.records import Point, rounded


class Follow:
    """Takes points along when the posts move: stretched along the opening, rigid across it."""

    def __init__(self, old: tuple[Point, Point], new: tuple[Point, Point]) -> None:
        a, b = np.array(old), np.array(new)
        self.mid, self.new_mid = a.mean(0), b.mean(0)
        u, v = a[1] - a[0], b[1] - b[0]
        self.stretch = float(np.hypot(*v) / max(np.hypot(*u), 1e-9))
        turn = math.atan2(v[1], v[0]) - math.atan2(u[1], u[0])
        # two posts have no order: by at most a quarter turn, so that no gateway-point changes sides
        self.turn = math.pi / 2 - (math.pi / 2 - turn) % math.pi
        self.along = u / max(np.hypot(*u), 1e-9)

    def points(self, points: tuple[Point, ...]) -> tuple[Point, ...]:
        c, s = math.cos(self.turn), math.sin(self.turn)
        out = []
        for p in points:
            d = np.array(p) - self.mid
            d = d + (self.stretch - 1) * (d @ self.along) * self.along
            x, y = self.new_mid + np.array([c * d[0] - s * d[1], s * d[0] + c * d[1]])
            out.append((rounded(x), rounded(y)))
        return tuple(out)

    def directions(self, angles: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(rounded(math.remainder(a + self.turn, 2 * math.pi)) for a in angles)
