"""Scorers: the paper's network (Appendix A.3), and a linear rule of a few inputs."""

from __future__ import annotations

import json
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from safetensors import SafetensorError, safe_open
from safetensors.numpy import load_file, save_file

from fsel.features.columns import FOLLOWING_INPUTS, INPUTS, NAMES, positions

WIDTH = 64
SHAPES = {
    "layer1.weight": (WIDTH, INPUTS),
    "layer1.bias": (WIDTH,),
    "layer2.weight": (WIDTH, WIDTH),
    "layer2.bias": (WIDTH,),
    "layer3.weight": (1, WIDTH),
    "layer3.bias": (1,),
}


class Scorer(ABC):
    """Scores candidates by their inputs: a `Linear` rule or a `Network`, with its provenance."""

    provenance: Mapping[str, str]

    @abstractmethod
    def scores(self, inputs: np.ndarray) -> np.ndarray:
        """Return (n,) scores of (n, 19) standardised inputs, in their precision: the plain form."""

    @abstractmethod
    def save(self, path: str | Path) -> None:
        """Write the scorer with its provenance; equal scorers are equal files."""

    @staticmethod
    def load(path: str | Path) -> Scorer:
        """Read what `save` wrote, a linear rule from JSON, a network from safetensors; ValueError
        for a file that does not hold a scorer."""
        suffix = Path(path).suffix
        if suffix not in (".json", ".safetensors"):
            raise ValueError(
                f"{path}: not a scorer; allowed: .json (a linear rule), .safetensors (a network)"
            )
        try:
            return Linear.load(path) if suffix == ".json" else Network.load(path)
        except (ValueError, TypeError, KeyError, RecursionError, SafetensorError) as error:
            raise ValueError(f"{path}: not a scorer: {error}") from error


@dataclass(frozen=True)
class Linear(Scorer):
    """The sum of a few standardised inputs, each times its coefficient.

    Attributes:
        coefficients: name of an input (`fsel.features.columns.NAMES`) -> float.
        provenance: free text fields, stored beside the coefficients.

    Raises:
        ValueError: when a name is unknown, there is none, or a coefficient is not finite.
    """

    coefficients: Mapping[str, float]
    provenance: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        unknown = [name for name in self.coefficients if name not in NAMES]
        if unknown or not self.coefficients:
            raise ValueError(
                f"a linear scorer has coefficients of {', '.join(unknown) or 'no input'}; "
                f"allowed: {', '.join(NAMES)}"
            )
        for name, value in self.coefficients.items():
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise ValueError(f"the coefficient of {name} is {value!r}, not a number")
            if not math.isfinite(value):
                raise ValueError(f"the coefficient of {name} is {value}, not finite")

    @property
    def vector(self) -> np.ndarray:
        """(19,) float64 a coefficient an input, zero where there is none."""
        full = np.zeros(INPUTS)
        full[positions(self.coefficients)] = list(self.coefficients.values())
        return full

    def scores(self, inputs: np.ndarray) -> np.ndarray:
        # einsum sums every row alike; a matrix product may part equal rows in their last bit
        return np.einsum("ni,i->n", inputs, self.vector.astype(inputs.dtype))

    def save(self, path: str | Path) -> None:
        content = {
            "coefficients": dict(self.coefficients),
            "provenance": dict(sorted(self.provenance.items())),
        }
        Path(path).write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: str | Path) -> Linear:
        """Read what `save` wrote."""
        content = json.loads(Path(path).read_text(encoding="utf-8"))
        return cls(dict(content["coefficients"]), dict(content["provenance"]))


@dataclass(frozen=True)
class Network(Scorer):
    """The paper's scorer f_theta, a 19-64-64-1 perceptron with exact GELU (Appendix A.3).

    Attributes:
        weights: float32 arrays as in `SHAPES`, 5,505 numbers.
        provenance: free text fields, stored beside the weights.

    Raises:
        ValueError: when an array is missing, misshapen or not finite.
    """

    weights: Mapping[str, np.ndarray]
    provenance: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        shapes = {name: array.shape for name, array in self.weights.items()}
        if shapes != SHAPES:
            raise ValueError(f"scorer weights have shapes {shapes}, expected {SHAPES}")
        for name, array in self.weights.items():
            if not np.isfinite(array).all():
                raise ValueError(f"scorer weights {name} are not finite")

    def scores(self, inputs: np.ndarray) -> np.ndarray:
        hidden = inputs
        for layer in ("layer1", "layer2"):
            weight = self.weights[f"{layer}.weight"].astype(inputs.dtype)
            hidden = _gelu(hidden @ weight.T + self.weights[f"{layer}.bias"])
        return hidden @ self.weights["layer3.weight"][0] + self.weights["layer3.bias"][0]

    def save(self, path: str | Path) -> None:
        # one field of JSON: safetensors writes several in an order that changes from run to run
        provenance = json.dumps(dict(self.provenance), sort_keys=True)
        save_file(dict(self.weights), str(path), metadata={"provenance": provenance})

    @classmethod
    def load(cls, path: str | Path) -> Network:
        """Read what `save` wrote."""
        with safe_open(str(path), framework="numpy") as file:
            metadata = file.metadata() or {}
        single = {name: array.astype(np.float32) for name, array in load_file(str(path)).items()}
        return cls(single, dict(json.loads(metadata.get("provenance", "{}"))))


def _gelu(z: np.ndarray) -> np.ndarray:
    from scipy.special import erf  # here: most jobs do without, and it is slow

    share = erf(z * math.sqrt(0.5))
    share += 1
    share *= z
    share *= 0.5
    return share


class Layers(NamedTuple):
    """Arrays of a network that the compiled loop needs.

    Attributes:
        narrow: in float32, (5, 64) first-layer weights of the inputs that follow the selection,
            (64, 64) second layer, transposed, its (64,) bias, and the (64,) third layer.
        wide: the arrays of `SHAPES` in float64.
    """

    narrow: tuple[np.ndarray, ...]
    wide: tuple[np.ndarray, ...]


def layers_of(network: Network) -> Layers:
    """Return a network's arrays for the compiled loop."""
    weights = network.weights
    # copies: arrays read from a file may be read-only, for which the loop would compile anew
    narrow = (
        np.ascontiguousarray(weights["layer1.weight"][:, FOLLOWING_INPUTS].T),
        np.ascontiguousarray(weights["layer2.weight"].T),
        weights["layer2.bias"].copy(),
        weights["layer3.weight"][0].copy(),
    )
    return Layers(narrow, tuple(weights[name].astype(np.float64) for name in SHAPES))
