"""A small neural network, applied with plain NumPy: trained elsewhere, shipped as numbers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Network:
    """A multilayer perceptron: standardised inputs, tanh layers, softmax at the end."""

    mean: np.ndarray
    scale: np.ndarray
    weights: tuple[np.ndarray, ...]
    biases: tuple[np.ndarray, ...]

    def probabilities(self, inputs: np.ndarray) -> np.ndarray:
        """(K, C) probabilities of the classes for inputs (K, F)."""
        x = (inputs - self.mean) / self.scale
        for w, b in zip(self.weights[:-1], self.biases[:-1], strict=True):
            x = np.tanh(x @ w + b)
        x = x @ self.weights[-1] + self.biases[-1]
        if x.shape[1] == 1:
            x = np.concatenate([np.zeros_like(x), x], 1)
        e = np.exp(x - x.max(1, keepdims=True))
        return e / e.sum(1, keepdims=True)

    def save(self, path: str | Path) -> None:
        """Write the numbers (float32) that :meth:`load` reads."""
        layers = {f"{n}{i}": a for n, s in (("w", self.weights), ("b", self.biases)) for i, a in enumerate(s)}
        arrays = {"mean": self.mean, "scale": self.scale, **layers}
        np.savez_compressed(path, **{k: np.asarray(a, np.float32) for k, a in arrays.items()})  # type: ignore[arg-type]

    @classmethod
    def load(cls, path: str | Path) -> Network:
        """Read what :meth:`save` wrote."""
        with np.load(path, allow_pickle=False) as z:
            n = sum(k.startswith("w") for k in z.files)
            a = {k: z[k].astype(float) for k in z.files}
        return cls(a["mean"], a["scale"], tuple(a[f"w{i}"] for i in range(n)), tuple(a[f"b{i}"] for i in range(n)))
