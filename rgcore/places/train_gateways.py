"""Train the network of the gateway hypotheses: ``python -m rgcore.places.train_gateways``.

Needs scikit-learn. Writes ``gateways.npz`` beside this file; the same seed gives the same weights. It draws random
office floors (``rgcore.places.floors``), scans them from random positions, takes the chords of the free space that the
scans leave, and labels each by the true transition that it lies on.
"""

from __future__ import annotations

import numpy as np

from rgcore.config import Places as Settings
from rgcore.places.chords import find_chords
from rgcore.places.divide import open_space
from rgcore.places.floors import Floor, random_floor, scanned
from rgcore.places.hypotheses import KINDS, WEIGHTS, features
from rgcore.places.network import Network

SEED, FLOORS, HELD_OUT = 11, 600, 30


def label(floor: Floor, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(K,) kind of each chord a - b [m], -1 where it is too near a transition to be none and too far to be one."""
    kind = np.zeros(len(a), int)
    mid, u, width = (a + b) / 2, b - a, np.hypot(*(b - a).T)
    for p, q, name in floor.gateways:
        n = q - p
        length = np.hypot(*n)
        off = np.hypot(*(mid - (p + q) / 2).T)
        lean = np.abs(u @ n) / np.maximum(width * length, 1e-9)
        depth = np.abs((mid - (p + q) / 2) @ np.array([-n[1], n[0]])) / length
        good = (depth < floor.thickness / 2 + 0.12) & (off < 0.3 + 0.1 * length) & (lean > np.cos(np.radians(10)))
        good &= np.abs(width - length) < 0.15 + 0.08 * length
        near = (off < 0.7) & (lean > 0.7)
        kind[near & (kind == 0)] = -1
        kind[good] = KINDS.index(name)
    return kind


def examples(seed: int, settings: Settings) -> tuple[np.ndarray, np.ndarray]:
    """Features and kinds of the chords of one random floor."""
    rng = np.random.default_rng(seed)
    floor = random_floor(rng)
    free = scanned(floor, rng, settings)
    chords = find_chords(open_space(free, settings)[0], free.resolution, settings)
    posts = free.origin + (chords.posts + 0.5) * free.resolution
    kind = label(floor, posts[:, 0], posts[:, 1])
    use = (kind > 0) | ((kind == 0) & (rng.random(len(kind)) < 0.25))
    return features(chords, free.resolution)[use], kind[use]


def train(seed: int = SEED, floors: int = FLOORS, held_out: int = HELD_OUT) -> tuple[Network, np.ndarray]:
    """The network, and its table of confusion (true x found) on the chords of floors that it has not seen."""
    from sklearn.neural_network import MLPClassifier

    settings = Settings()
    parts = [examples(1000 * seed + i, settings) for i in range(floors + held_out)]
    x, y = (np.concatenate(p) for p in zip(*parts[:floors], strict=True))
    mean, scale = x.mean(0), x.std(0) + 0.02
    mlp = MLPClassifier((32, 16), activation="tanh", alpha=1e-3, early_stopping=True, max_iter=120, random_state=seed)
    mlp.fit((x - mean) / scale, y)
    found = Network(mean, scale, tuple(mlp.coefs_), tuple(mlp.intercepts_))
    xt, yt = (np.concatenate(p) for p in zip(*parts[floors:], strict=True))
    confusion = np.zeros((len(KINDS), len(KINDS)), int)
    np.add.at(confusion, (yt, found.probabilities(xt).argmax(1)), 1)
    return found, confusion


if __name__ == "__main__":
    trained, table = train()
    trained.save(WEIGHTS)
    print(KINDS, table, sep="\n")  # noqa: T201
