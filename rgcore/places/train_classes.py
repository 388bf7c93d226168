"""Train the network of the region classes on synthetic rooms: ``python -m rgcore.places.train_classes``.

Needs scikit-learn. Writes ``classes.npz`` beside this file; the same seed gives the same weights. The training set is
the paper's (section IV-D): histograms of one Gaussian peak (hallway-like), of two peaks 90 degrees apart, the second
from a lower level up to one (TOMA), and of noise between a lower level and one (CC), all with extra noise of several
amplitudes; each with free-space measures of a room of its class. Half of the histograms come from the walls, doors and
furniture of such a room instead.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from rgcore.places.classify import CLASSES, WEIGHTS, angle_histogram
from rgcore.places.network import Network

SEED, SAMPLES, BINS = 7, 12000, 36


def gauss(rng: np.random.Generator, centre: int, height: float) -> np.ndarray:
    """A peak of random width that wraps around the half turn."""
    off = (np.arange(BINS) - centre + BINS / 2) % BINS - BINS / 2
    return height * np.exp(-0.5 * (off / rng.uniform(0.3, 1.6)) ** 2)


def printed_histogram(rng: np.random.Generator, class_: str) -> np.ndarray:
    """A histogram of the paper's kinds, with extra noise."""
    middle = BINS // 2
    if class_ == "CC":
        h = rng.uniform(rng.uniform(0.1, 0.5), 1.0, BINS)
    else:
        h = gauss(rng, middle, 1.0)
        if class_ == "TOMA":
            h = np.maximum(h, gauss(rng, 0, rng.uniform(0.35, 1.0)))
    h = np.clip(h + rng.uniform(0, rng.choice([0.02, 0.1, 0.2]), BINS), 0, None)
    return np.roll(h / h.max(), middle - int(h.argmax()))


def room(rng: np.random.Generator, class_: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lines (L, 2, 2), free-space measures (7,) and the slope of the long side of a random room of a class."""
    hall = class_ in ("CDMA", "ODMA")
    lobby = class_ == "CDMA" and rng.random() < 0.1
    furnished = hall and rng.random() < 0.25
    width = rng.uniform(1.1, 3.6) if hall else rng.uniform(1.8, 8.0)
    length = width * (np.exp(rng.uniform(np.log(3.0), np.log(25))) if hall else rng.uniform(1.0, 2.6))
    if lobby:  # between many doors
        width = rng.uniform(1.1, 2.8)
        length = width * rng.uniform(1.0, 2.8)
    if not hall and rng.random() < 0.15:
        width, length = 0.5 * width, length
    around = 2 * (length + width)
    slim = length > 2.8 * width and not hall
    doors = (
        rng.integers(2 + 2 * lobby, 3 + 2 * lobby + int(length / 3))
        if hall
        else 1
        if slim
        else rng.choice(4, p=[0.05, 0.55, 0.3, 0.1])
    )
    wide = rng.uniform(0.1, 0.5) if class_ == "ODMA" else rng.choice([0.0, rng.uniform(0, 0.06)])
    if not hall and rng.random() < 0.2:
        wide = rng.uniform(0.06, 0.3)
    opened = wide * around
    gaps = np.append(rng.uniform(0.7, 1.1, doors), [opened] * int(wide > 0))
    walls = [(length, 0.0), (length, 0.0), (width, np.pi / 2), (width, np.pi / 2)]
    lines = [(s * rng.uniform(0.6, 1.0), a) for s, a in walls]
    lines += [(rng.uniform(0.1, 0.4), np.pi / 2) for _ in range(2 * len(gaps))]
    things = rng.poisson(
        {"TOMA": 0.1, "CC": rng.uniform(0.1, 0.4)}.get(class_, 0.1 if furnished else 0.02) * min(length * width, 60)
    )
    turn = rng.uniform(0, np.pi, things) if class_ == "CC" else rng.normal(0, 0.03, things)
    for t in turn:
        lines += [(rng.uniform(0.4, 2.0), t), (rng.uniform(0.3, 0.9), t + np.pi / 2)]
    short = rng.poisson(
        {"TOMA": rng.uniform(0, 0.5), "CC": rng.uniform(0.2, 2.0)}.get(
            class_, rng.uniform(0.1, 2.0) if furnished else 0.08
        )
        * min(length * width, 80)
    )
    lines += [(rng.uniform(0.1, 0.5), t) for t in rng.uniform(0, np.pi, short)]
    size = np.array([s for s, _ in lines])
    slope = np.array([t for _, t in lines]) + rng.normal(0, 0.02, len(lines)) + rng.uniform(0, np.pi)
    step = 0.5 * size[:, None] * np.stack([np.cos(slope), np.sin(slope)], 1)
    bends = hall and rng.random() < 0.25
    fill = rng.uniform(0.25, 0.7) if bends else rng.uniform(0.75, 1.05)
    elongation = rng.uniform(1.0, 4.0) if bends else (length + 0.2) / (width + 0.2)
    area = length * width * rng.uniform(0.8, 1.0)
    few = (size < 0.6).sum() / area
    measures = [np.log(elongation), np.log(2 * area / around), np.log(area), opened / around, fill, min(few, 4.0)]
    measures.append(np.log1p(len(gaps)))
    return np.stack([-step, step], 1), np.array(measures), slope


def sample(rng: np.random.Generator) -> tuple[np.ndarray, int]:
    """Inputs and class of one synthetic region."""
    label = int(rng.integers(len(CLASSES)))
    lines, measures, _ = room(rng, CLASSES[label])
    if rng.random() < 0.5:
        histogram = printed_histogram(rng, CLASSES[label])
    else:
        histogram = angle_histogram(lines, BINS)[0]
    return np.concatenate([histogram, measures]), label


def tempered(found: Network, inputs: np.ndarray, labels: np.ndarray) -> Network:
    """The network with its last layer divided by the temperature that gives rooms it has not seen the best likelihood
    (Guo et al. 2017, "On calibration of modern neural networks"): the classes stay, the scores become honest.
    """

    def loss(log_temperature: float) -> float:
        p = scaled(float(np.exp(log_temperature))).probabilities(inputs)[np.arange(len(labels)), labels]
        return float(-np.log(np.maximum(p, 1e-12)).mean())

    def scaled(t: float) -> Network:
        weights, biases = (*found.weights[:-1], found.weights[-1] / t), (*found.biases[:-1], found.biases[-1] / t)
        return Network(found.mean, found.scale, weights, biases)

    best = minimize_scalar(loss, bounds=(-1.5, 1.5), method="bounded")
    return scaled(float(np.exp(best.x)))


def samples_of(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Inputs (K, F) and classes (K,) of so many synthetic regions."""
    x, y = zip(*(sample(rng) for _ in range(count)), strict=True)
    return np.array(x), np.array(y)


def train(seed: int = SEED, samples: int = SAMPLES) -> tuple[Network, np.ndarray]:
    """The network, and its table of confusion (true x found) on rooms it has not seen."""
    from sklearn.neural_network import MLPClassifier

    rng = np.random.default_rng(seed)
    x, y = samples_of(rng, samples)
    mean, scale = x.mean(0), x.std(0) + 0.05
    mlp = MLPClassifier((16,), activation="tanh", alpha=1e-2, early_stopping=True, max_iter=300, random_state=seed)
    mlp.fit((x - mean) / scale, y)
    found = Network(mean, scale, tuple(mlp.coefs_), tuple(mlp.intercepts_))
    found = tempered(found, *samples_of(rng, samples // 4))
    xt, yt = samples_of(rng, samples // 4)
    confusion = np.zeros((len(CLASSES), len(CLASSES)), int)
    np.add.at(confusion, (yt, found.probabilities(xt).argmax(1)), 1)
    return found, confusion


if __name__ == "__main__":
    trained, table = train()
    trained.save(WEIGHTS)
    print(CLASSES, table, sep="\n")  # noqa: T201
