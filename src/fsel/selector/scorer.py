"""The scorer f_theta: a 19-64-64-1 perceptron with exact GELU (paper, Appendix A.3)."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from safetensors import safe_open
from safetensors.numpy import load_file, save_file

INPUTS = 19  # the 18 features, and a column that the paper holds at zero
WIDTH = 64
SHAPES = {
    "layer1.weight": (WIDTH, INPUTS),
    "layer1.bias": (WIDTH,),
    "layer2.weight": (WIDTH, WIDTH),
    "layer2.bias": (WIDTH,),
    "layer3.weight": (1, WIDTH),
    "layer3.bias": (1,),
}
PARAMETERS = sum(int(np.prod(shape)) for shape in SHAPES.values())
TURN = 0.62891  # GELU's slope is within this of one half


@dataclass(frozen=True)
class Scorer:
    """Weights and where they came from.

    Attributes:
        weights: float32 arrays as in `SHAPES`, 5,505 numbers.
        provenance: free text fields, stored beside the weights.

    Raises:
        ValueError: when an array is missing, misshapen or not finite.
    """

    weights: dict[str, np.ndarray]
    provenance: dict[str, str]

    def __post_init__(self) -> None:
        shapes = {name: array.shape for name, array in self.weights.items()}
        if shapes != SHAPES:
            raise ValueError(f"scorer weights have shapes {shapes}, expected {SHAPES}")
        for name, array in self.weights.items():
            if not np.isfinite(array).all():
                raise ValueError(f"scorer weights {name} are not finite")

    def scores(self, inputs: np.ndarray) -> np.ndarray:
        """(n,) scores of (n, 19) standardised inputs, in their precision: the plain form."""
        hidden = inputs
        for layer in ("layer1", "layer2"):
            weight = self.weights[f"{layer}.weight"].astype(inputs.dtype)
            hidden = _gelu(hidden @ weight.T + self.weights[f"{layer}.bias"])
        return hidden @ self.weights["layer3.weight"][0] + self.weights["layer3.bias"][0]

    def save(self, path: str | Path) -> None:
        """Write a safetensors file with the provenance as metadata.

        It is one field of JSON: safetensors writes several fields in an order that changes from
        run to run, and equal weights must be equal files.
        """
        provenance = json.dumps(self.provenance, sort_keys=True)
        save_file(self.weights, str(path), metadata={"provenance": provenance})

    @classmethod
    def load(cls, path: str | Path) -> Scorer:
        """Read what `save` wrote."""
        weights = load_file(str(path))
        with safe_open(str(path), framework="numpy") as file:
            metadata = file.metadata() or {}
        return cls(weights, json.loads(metadata.get("provenance", "{}")))


def _gelu(z: np.ndarray) -> np.ndarray:
    from scipy.special import erf  # here: most jobs do without, and it is slow

    share = erf(z * math.sqrt(0.5))
    share += 1
    share *= z
    share *= 0.5
    return share


def change_bounds(first: np.ndarray, second: np.ndarray, third: np.ndarray) -> np.ndarray:
    """What a change d of the inputs that follow the selection can add to a score, at most.

    With the slopes of both layers written as 1/2 + e, |e| <= 0.629, the score's gradient is
    w3 (1/2 + e2) W2 (1/2 + e1) W1: an exact part and two kinds of remainder. A score grows by at
    most a.d + |B d| + |C d|.

    Args:
        first: (64, 5) columns of W1; second: (64, 64) W2; third: (64,) w3, float64.

    Returns:
        (11, 5) float64: a, and upper triangular factors of B and C.
    """
    both = second @ first
    size = np.linalg.norm(third)
    loose = TURN / 2 * np.linalg.norm(third @ second) + TURN**2 * size * _stretch(second)
    parts = (TURN / 2 * size * both, loose * first)
    return np.vstack([third @ both / 4, *(np.linalg.qr(part, mode="r") for part in parts)])


def _stretch(matrix: np.ndarray) -> float:
    """No less than the largest singular value, and at most a seventh more; a decomposition would
    take longer than a selection from a small pool."""
    size = np.linalg.norm(matrix)
    if size == 0:
        return 0.0
    gram = matrix.T @ matrix / size**2
    for _ in range(3):
        gram = gram @ gram
    return size * np.linalg.norm(gram) ** (1 / 16)
