"""Train the two networks of the object hypotheses: ``python -m rgcore.places.train_objects``.

Needs scikit-learn. Writes ``objects.npz`` and ``tables.npz`` beside this file; the same seed gives the same weights. It
surveys random furnished floors (:mod:`rgcore.places.furnished`), takes all boxes and tables that their lines suggest,
and labels each by the thing that stands there.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from rgcore.config import Config
from rgcore.places.boxes import boxes_on, features
from rgcore.places.divide import free_mask
from rgcore.places.furnished import Furnished, Survey, furnished_floor, survey
from rgcore.places.network import Network
from rgcore.places.objects import BOXES, TABLES, near_lines
from rgcore.places.tables import find_legs, tables_on

SEED, FLOORS = 5, 400
RIGHT, WRONG = 0.6, 0.35
"""intersection over union with a thing from which a hypothesis is right, and up to which it is wrong"""
INPUTS = {"boxes": 33, "tables": 10}


@dataclass(frozen=True)
class Examples:
    """Features (K, F) of hypotheses and whether each is right (1), wrong (0) or neither (-1)."""

    inputs: np.ndarray
    right: np.ndarray


def corners_of(origin: np.ndarray, u: np.ndarray, down: np.ndarray, size: np.ndarray) -> np.ndarray:
    """(K, 4, 2) corners of boxes, from the left end of the front on."""
    right, back = u * size[:, :1], down * size[:, 1:]
    return np.stack([origin, origin + right, origin + right + back, origin + back], 1)


_GRID = (np.stack(np.meshgrid(np.arange(14), np.arange(14)), -1).reshape(-1, 2) + 0.5) / 14


def common_area(boxes: np.ndarray, thing: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Areas: common to boxes (K, 4, 2) and a thing (4, 2), of the boxes, of the thing; sampled, to a few percent."""
    side, back = boxes[:, 1] - boxes[:, 0], boxes[:, 3] - boxes[:, 0]
    points = boxes[:, :1] + _GRID[:, :1] * side[:, None] + _GRID[:, 1:] * back[:, None]
    u, v = thing[1] - thing[0], thing[3] - thing[0]
    s, t = (points - thing[0]) @ u / (u @ u), (points - thing[0]) @ v / (v @ v)
    area = np.abs(side[:, 0] * back[:, 1] - side[:, 1] * back[:, 0])
    common = ((s > 0) & (s < 1) & (t > 0) & (t < 1)).mean(1) * area
    return common, area, float(abs(u[0] * v[1] - u[1] * v[0]))


def labels(boxes: np.ndarray, things: list[np.ndarray]) -> np.ndarray:
    """(K,) 1 right, 0 wrong (those over two things as well), -1 neither."""
    if not things or len(boxes) == 0:
        return np.zeros(len(boxes), int)
    both = [common_area(boxes, t) for t in things]
    union = np.max([c / (a + t - c) for c, a, t in both], 0)
    covered = np.sum([c / t > 0.5 for c, _, t in both], 0)
    return np.where(union >= RIGHT, 1, np.where((union <= WRONG) | (covered > 1), 0, -1))


def examples(f: Furnished, s: Survey, config: Config) -> dict[str, Examples]:
    """The hypotheses of one survey, labelled."""
    mask = free_mask(s.free)
    solid = [t.corners for t in f.things if t.kind != "table"]
    parts = []
    for region in range(len(s.places.regions)):
        own, near = near_lines(s.lines, region)
        boxes = boxes_on(s.lines.ends[own], s.lines.ends[near], s.free.grid(mask), config.objects)
        if boxes is not None:
            at = corners_of(boxes.origin, boxes.u, boxes.down, boxes.size)
            parts.append(Examples(features(boxes), labels(at, solid)))
    tables = tables_on(find_legs(s.free, mask), s.free, mask, config.objects)
    legs = labels(tables.corners, [t.corners for t in f.things if t.kind == "table"])
    return {"boxes": joined(parts, 33), "tables": Examples(tables.features, legs)}


def joined(parts: list[Examples], width: int) -> Examples:
    """One after the other."""
    return Examples(
        np.concatenate([p.inputs for p in parts] or [np.zeros((0, width))]),
        np.concatenate([p.right for p in parts] or [np.zeros(0, int)]),
    )


def floors(seed: int, count: int) -> list[dict[str, Examples]]:
    """Examples of so many random floors."""
    out = []
    for i in range(count):
        rng = np.random.default_rng(1000 * seed + i)
        f = furnished_floor(rng)
        out.append(examples(f, survey(f, rng, Config()), Config()))
    return out


def fit(x: Examples, hidden: tuple[int, ...], seed: int) -> Network:
    """A network on the hypotheses that are right or wrong."""
    from sklearn.neural_network import MLPClassifier

    use = x.right >= 0
    inputs = x.inputs[use].astype(np.float32)
    mean, scale = inputs.mean(0), inputs.std(0) + 0.02
    mlp = MLPClassifier(
        hidden,
        activation="tanh",
        alpha=3e-3,
        batch_size=256,
        early_stopping=True,
        n_iter_no_change=5,
        max_iter=40,
        random_state=seed,
    )
    mlp.fit((inputs - mean) / scale, x.right[use])
    return Network(mean, scale, tuple(mlp.coefs_), tuple(mlp.intercepts_))


def train(seed: int = SEED, count: int = FLOORS) -> tuple[dict[str, Network], dict[str, np.ndarray]]:
    """The networks; and of every 10th floor, which they have not seen, (K, 2) score and whether it is right."""
    parts = floors(seed, count)
    found, sure = {}, {}
    for kind, hidden in (("boxes", (32, 16)), ("tables", (12,))):
        seen = joined([p[kind] for i, p in enumerate(parts) if i % 10], INPUTS[kind])
        held = joined(_held(parts, kind), INPUTS[kind])
        found[kind] = fit(seen, hidden, seed)
        use = held.right >= 0
        sure[kind] = np.stack([found[kind].probabilities(held.inputs[use])[:, 1], held.right[use]], 1)
    return found, sure


def _held(parts: list[dict[str, Examples]], kind: str) -> list[Examples]:
    return [p[kind] for i, p in enumerate(parts) if i % 10 == 0]


if __name__ == "__main__":
    trained, judged = train()
    for kind, weights in (("boxes", BOXES), ("tables", TABLES)):
        trained[kind].save(weights)
        for low, high in itertools.pairwise((0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 1.01)):
            band = judged[kind][(judged[kind][:, 0] >= low) & (judged[kind][:, 0] < high)]
            if len(band):
                print(f"{kind} from {low:g}: {len(band)}, mean {band[:, 0].mean():.3f}, right {band[:, 1].mean():.3f}")  # noqa: T201
