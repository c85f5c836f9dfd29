"""The scoring network f_theta: 19 inputs, two hidden layers of 64, one score (section 3.3)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from safetensors import SafetensorError, safe_open
from safetensors.numpy import load_file, save_file
from scipy.special import erf

INPUTS = 19
WIDTH = 64
SHAPES = {
    "layer1.weight": (WIDTH, INPUTS),
    "layer1.bias": (WIDTH,),
    "layer2.weight": (WIDTH, WIDTH),
    "layer2.bias": (WIDTH,),
    "layer3.weight": (1, WIDTH),
    "layer3.bias": (1,),
}
PARAMETERS = 5505


@dataclass(frozen=True)
class Scorer:
    """The network's weights and where they come from.

    Attributes:
        weights: float32 arrays, keys and shapes as `SHAPES`: 5,505 finite parameters in all.
        provenance: how the weights were made, in words.

    Raises:
        ValueError: for weights of another network.
    """

    weights: dict[str, np.ndarray]
    provenance: dict[str, str]

    def __post_init__(self) -> None:
        check_weights(self.weights, "scorer")

    def scores(self, inputs: np.ndarray) -> np.ndarray:
        """(n,) float64 scores of (n, 19) standardised inputs, computed in float64."""
        hidden = np.asarray(inputs, np.float64)
        for layer in ("layer1", "layer2"):
            hidden = gelu(hidden @ self._wide(f"{layer}.weight").T + self._wide(f"{layer}.bias"))
        return hidden @ self._wide("layer3.weight")[0] + self._wide("layer3.bias")[0]

    def _wide(self, name: str) -> np.ndarray:
        return self.weights[name].astype(np.float64)

    def save(self, path: str | Path) -> None:
        """Write the weights as safetensors with their provenance."""
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        arrays = {name: np.ascontiguousarray(self.weights[name]) for name in SHAPES}
        save_file(arrays, path, metadata=self.provenance)

    @classmethod
    def load(cls, path: str | Path) -> Scorer:
        """Read what `save` wrote.

        Raises:
            FileNotFoundError: when there is no such file.
            ValueError: when the file is no safetensors file or holds another network.
        """
        if not Path(path).is_file():
            raise FileNotFoundError(f"{path}: no weights file; train a selector first")
        try:
            weights = load_file(str(path))
        with safe_open(str(path), framework="numpy") as file:
            return cls(weights, dict(file.metadata() or {}))


def _gelu(z: np.ndarray) -> np.ndarray:
    return 0.5 * z * (1 + erf(z / np.sqrt(2)))
