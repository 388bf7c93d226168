"""Train the network of the gateway hypotheses: ``python -m rgcore.places.train_gateways``.

Needs scikit-learn. Writes ``gateways.npz`` beside this file; the same seed gives the same weights. It draws random
office floors (``rgcore.places.floors``), scans them from random positions, takes the chords of the free space that the
scans leave, and labels each by the true transition that it lies on.
"""

from __future__ import annotations

import itertools

import numpy as np

from rgcore.config import Places as Settings
from rgcore.places.chords import find_chords
from rgcore.places.divide import open_space
from rgcore.places.floor_scans import scanned
from rgcore.places.floors import Floor, random_floor
from rgcore.places.hypotheses import KINDS, WEIGHTS, features
from rgcore.places.network import Network

SEED, FLOORS = 11, 450


def label(floor: Floor, a: np.ndarray, b: np.ndarray, kinds: tuple[str, ...] = KINDS) -> np.ndarray:
    """(K,) which of ``kinds`` each chord a - b [m] is, -1 where it is too near a transition to be none and too far to
    be one. Transitions of other kinds are none; ``junction`` stands for all junctions."""
    kind = np.zeros(len(a), int)
    mid, u, width = (a + b) / 2, b - a, np.hypot(*(b - a).T)
    for p, q, name in floor.gateways:
        name = name if name in kinds else name.split("_")[0]
        if name not in kinds:
            continue
        n = q - p
        length = np.hypot(*n)
        off = np.hypot(*(mid - (p + q) / 2).T)
        lean = np.abs(u @ n) / np.maximum(width * length, 1e-9)
        depth = np.abs((mid - (p + q) / 2) @ np.array([-n[1], n[0]])) / length
        good = (depth < floor.thickness / 2 + 0.12) & (off < 0.3 + 0.1 * length) & (lean > np.cos(np.radians(10)))
        good &= np.abs(width - length) < 0.15 + 0.08 * length
        near = (off < 0.7) & (lean > 0.7)
        kind[near & (kind == 0)] = -1
        kind[good] = kinds.index(name)
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
    chords = chords[use]
    x = [features(chords, free.resolution, t, m) for t in (False, True) for m in (False, True)]
    view = rng.integers(4, size=len(chords))
    return np.stack(x)[view, np.arange(len(chords))], kind[use]


def train(seed: int = SEED, floors: int = FLOORS) -> tuple[Network, np.ndarray, np.ndarray]:
    """The network, and what it makes of the chords of every 15th floor, which it has not seen: its table of confusion
    (true x found), and (chord, 2) its score as a gateway and whether one is there.
    """
    settings = Settings()
    parts = [examples(1000 * seed + i, settings) for i in range(floors)]
    x, y = (np.concatenate(p) for p in zip(*parts, strict=True))
    held = np.repeat(np.arange(floors) % 15 == 0, [len(p[1]) for p in parts])
    found = fitted(x[~held], y[~held], (48, 24), seed)
    chance, true = found.probabilities(x[held]), y[held]
    confusion = np.zeros((len(KINDS), len(KINDS)), int)
    np.add.at(confusion, (true, chance.argmax(1)), 1)
    return found, confusion, np.stack([chance[:, 1:3].sum(1), np.isin(true, (1, 2))], 1)


def fitted(x: np.ndarray, y: np.ndarray, hidden: tuple[int, ...], seed: int) -> Network:
    """A network on inputs (K, F) and their kinds (K,)."""
    from sklearn.neural_network import MLPClassifier

    x = x.astype(np.float32)
    mean, scale = x.mean(0), x.std(0) + 0.02
    mlp = MLPClassifier(
        hidden,
        activation="tanh",
        alpha=1e-3,
        batch_size=512,
        early_stopping=True,
        validation_fraction=0.05,
        n_iter_no_change=6,
        max_iter=40,
        random_state=seed,
    )
    mlp.fit((x - mean) / scale, y)
    return Network(mean, scale, tuple(mlp.coefs_), tuple(mlp.intercepts_))


if __name__ == "__main__":
    trained, table, sure = train()
    trained.save(WEIGHTS)
    print(KINDS, table, sep="\n")  # noqa: T201
    for low, high in itertools.pairwise((0, 0.1, 0.3, 0.6, 0.8, 0.9, 0.97, 1.01)):
        band = sure[(sure[:, 0] >= low) & (sure[:, 0] < high)]
        print(f"score from {low:g}: {len(band)} chords, mean {band[:, 0].mean():.3f}, right {band[:, 1].mean():.3f}")  # noqa: T201
