"""Two maps laid onto one another: what is different, and how that is drawn."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from rgcore.model.diff import Diff, Frames, diff, join
from rgcore.model.difference import Difference
from rgcore.model.records import Box2, RGMap
from rgcore.slam.trajectory import Trajectory
from rgviz import theme
from rgviz.drawings import Drawings, Strokes, at, box_corners, ring
from rgviz.theme import RGB

DASH = 0.3
"""m of a dash and of the gap after it: what is gone is drawn in dashes, so that no eye needs the colour alone"""
COLORS: dict[str, RGB] = {"green": theme.ADDED, "red": theme.REMOVED, "amber": theme.CHANGED}
TITLES = {"green": "new", "red": "gone", "amber": "changed"}


@dataclass(frozen=True)
class Comparison:
    """What is different in ``new`` against ``old``; ``frames`` take places of the old map into the new one."""

    title: str
    old: RGMap
    new: RGMap
    frames: Frames
    diff: Diff

    @classmethod
    def of(
        cls, title: str, old: RGMap, new: RGMap, before: Trajectory | None = None, after: Trajectory | None = None
    ) -> Comparison:
        """Raises RgError where the two are not maps of one building."""
        frames = join(old, new, before, after)
        return cls(title, old, new, frames, diff(old, new, frames))

    @property
    def counts(self) -> dict[str, int]:
        """How many differences there are of each colour."""
        count = Counter[str](d.colour for d in self.diff.differences)
        return {colour: count[colour] for colour in COLORS}


def drawings(c: Comparison) -> Drawings:
    """Every difference in the colour of what it is, in the frame of the new map."""
    strokes: dict[str, list[np.ndarray]] = {colour: [] for colour in COLORS}
    for d in c.diff.differences:
        strokes[d.colour] += _strokes(c, d)
    out: Drawings = {}
    for colour, parts in strokes.items():
        ends = np.concatenate([np.zeros((0, 2, 2)), *parts])
        if colour == "red":
            ends = dashed(ends)
        out[colour] = Strokes(at(ends, theme.Z_CHANGE), COLORS[colour], theme.CHANGE_WIDTH)
    return out


def old_walls(c: Comparison) -> Drawings:
    """The walls of the old map where they lie in the new one, to be laid under it: what coincides is hidden."""
    ends = np.array([(v.start, v.end) for v in c.old.lines.values()]).reshape(-1, 2)
    moved = c.frames.move(ends).reshape(-1, 2, 2)
    return {"walls": Strokes(at(moved, theme.Z_BOX), theme.WAS, theme.LINE_WIDTH)}


def dashed(ends: np.ndarray) -> np.ndarray:
    """Strokes (N, 2, 2) as the dashes (M, 2, 2) that they are made of; short ones stay whole."""
    out = [np.zeros((0, 2, 2))]
    for a, b in ends:
        count = max(1, round((float(np.hypot(*(b - a))) / DASH + 1) / 2))
        share = (2 * np.arange(count)[:, None] + np.array([0, 1])) / (2 * count - 1)
        out.append(a + share[..., None] * (b - a))
    return np.concatenate(out)


def _strokes(c: Comparison, d: Difference) -> list[np.ndarray]:
    """(N, 2, 2) of one difference: what came and what changed as it is now, what went as it was."""
    if d.pieces:
        return [np.array(d.pieces)]
    side = [(c.old, id, c.frames.move) for id in d.old] if d.colour == "red" else []
    side = side or [(c.new, id, _stay) for id in d.new]
    return [_outline(getattr(map, d.kind)[id], move) for map, id, move in side]


def _outline(item: Any, move: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """(N, 2, 2) around a thing, or along it."""
    if hasattr(item, "boundary"):
        rings = [np.array(r) for r in (item.boundary, *item.holes)]
    elif hasattr(item, "center"):
        rings = [box_corners(Box2(center=item.center[:2], size=item.size[:2], yaw=item.yaw))]
    else:
        return move(np.array(item.posts if hasattr(item, "posts") else (item.start, item.end)))[None]
    return np.concatenate([ring(move(r)) for r in rings])


def _stay(points: np.ndarray) -> np.ndarray:
    return points
