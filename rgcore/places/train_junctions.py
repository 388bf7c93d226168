"""Train the network of the junctions: ``python -m rgcore.places.train_junctions``.

Needs scikit-learn. Writes ``junctions.npz`` beside this file; the same seed gives the same weights. The chords are
those of crossings of hallways with rooms beside them, and of whole random floors, as for the doors
(:mod:`rgcore.places.train_gateways`); their labels are the letters of the junctions.
"""

from __future__ import annotations

import numpy as np

from rgcore.config import Places as Settings
from rgcore.places.chords import find_chords
from rgcore.places.divide import open_space
from rgcore.places.floor_scans import scanned
from rgcore.places.floors import Floor, leaves, random_floor
from rgcore.places.junctions import KINDS, WEIGHTS, features
from rgcore.places.network import Network
from rgcore.places.train_gateways import fitted, label

SEED, FLOORS = 17, 500


def examples(seed: int, settings: Settings) -> tuple[np.ndarray, np.ndarray]:
    """Features and kinds of the chords of one random floor: all that lie on junctions, some of the others."""
    rng = np.random.default_rng(seed)
    floor = crossing(rng) if rng.random() < 0.7 else random_floor(rng)
    free = scanned(floor, rng, settings)
    chords = find_chords(open_space(free, settings)[0], free.resolution, settings)
    posts = free.origin + (chords.posts + 0.5) * free.resolution
    kind = label(floor, posts[:, 0], posts[:, 1], KINDS)
    use = (kind > 0) | ((kind == 0) & (rng.random(len(kind)) < 0.15))
    chords = chords[use]
    x = [features(chords, free.resolution, t, m) for t in (False, True) for m in (False, True)]
    view = rng.integers(4, size=len(chords))
    return np.stack(x)[view, np.arange(len(chords))], kind[use]


def crossing(rng: np.random.Generator) -> Floor:
    """Two, three or four hallways that meet at right angles, with rooms along those in the direction of x."""
    t = float(rng.choice([0.06, 0.15, 0.25]))
    floor = Floor(t, float(rng.uniform(0, np.pi / 2)))
    tall = float(rng.uniform(1.2, 3.2))
    wide = tall * float(rng.uniform(0.75, 1.3))
    floor.rooms.append((0.0, 0.0, wide, tall))
    first, count = int(rng.integers(4)), int(rng.integers(2, 5))
    name = f"junction_{'LTX'[count - 2]}"
    for k in range(first, first + count):
        long = float(rng.uniform(3, 10))
        if k % 2:
            edge, sign = (tall, 1) if k % 4 == 1 else (0.0, -1)
            y = sorted((edge - 0.05 * sign, edge + sign * long))
            floor.rooms.append((0.0, y[0], wide, y[1]))
            floor.transition((0.0, edge), (wide, edge), name)
            continue
        edge, sign = (wide, 1) if k % 4 == 0 else (0.0, -1)
        x = sorted((edge - 0.05 * sign, edge + sign * long))
        floor.rooms.append((x[0], 0.0, x[1], tall))
        floor.transition((edge, 0.0), (edge, tall), name)
        for side in (1, -1):
            _rooms_along(floor, rng, (edge, sign, long), tall if side > 0 else 0.0, side)
    leaves(floor, rng)
    return floor


def _rooms_along(floor: Floor, rng: np.random.Generator, arm: tuple[float, int, float], wall: float, side: int) -> None:
    """Rooms with doors beside an arm that leaves x = ``arm[0]`` in the direction ``arm[1]`` for ``arm[2]`` metres."""
    (edge, sign, long), t, at = arm, floor.thickness, 2.0 * floor.thickness
    deep = float(rng.uniform(1.5, 4.0))
    while long - at > 1.6 and rng.random() < 0.8:
        size = float(rng.uniform(1.5, min(4.0, long - at)))
        x0, x1 = sorted((edge + sign * at, edge + sign * (at + size)))
        y0, y1 = sorted((wall + side * t, wall + side * (t + deep)))
        floor.rooms.append((x0, y0, x1, y1))
        gap = float(rng.uniform(0.65, 1.2))
        door = x0 + float(rng.uniform(0, size - gap))
        floor.door((door, wall + side * t / 2), (door + gap, wall + side * t / 2))
        at += size + t


def train(seed: int = SEED, floors: int = FLOORS) -> tuple[Network, np.ndarray]:
    """The network, and its table of confusion (true x found) on every 10th floor, which it has not seen."""
    settings = Settings()
    parts = [examples(1000 * seed + i, settings) for i in range(floors)]
    x, y = (np.concatenate(p) for p in zip(*parts, strict=True))
    held = np.repeat(np.arange(floors) % 10 == 0, [len(p[1]) for p in parts])
    found = fitted(x[~held], y[~held], (24,), seed)
    confusion = np.zeros((len(KINDS), len(KINDS)), int)
    np.add.at(confusion, (y[held], found.probabilities(x[held]).argmax(1)), 1)
    return found, confusion


if __name__ == "__main__":
    trained, table = train()
    trained.save(WEIGHTS)
    print(KINDS, table, sep="\n")  # noqa: T201
