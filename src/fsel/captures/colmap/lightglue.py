"""LightGlue (Lindenberger et al. 2023): matches of two images' features by attention, in NumPy."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fsel.captures.colmap.layers import EPSILON, sigmoid, softmax

LAYERS, HEADS = 9, 4
LEAST = 0.1  # probability of a match
STOP = 0.95  # share of sure features, at which further layers are saved
ROOT_HALF = np.float32(np.sqrt(0.5))

Seen = tuple[np.ndarray, np.ndarray, tuple[int, int]]
"""(n, 2) pixels of an image, (n, 128) descriptors there, and (width, height)."""


class LightGlue:
    """The network.

    Attributes:
        state: layer -> float32 weights and biases, as the authors' file names them.
    """

    def __init__(self, state: Mapping[str, np.ndarray]) -> None:
        self.state = state

    def __call__(self, one: Seen, other: Seen) -> np.ndarray:
        """(m, 2) uint32 rows of features that match."""
        if min(len(one[0]), len(other[0])) == 0:
            return np.zeros((0, 2), np.uint32)
        turns = [self._turns(points, size) for points, _, size in (one, other)]
        a, b = (self._linear(side[1], "input_proj") for side in (one, other))
        for layer in range(LAYERS):
            inside, across = (f"transformers.{layer}.{part}_attn" for part in ("self", "cross"))
            a, b = (self._attended(x, turn, inside) for x, turn in zip((a, b), turns, strict=True))
            a, b = self._crossed(a, b, across)
            if layer == LAYERS - 1 or self._sure(np.concatenate([a, b]), layer):
                break
        return self._assigned(a, b, f"log_assignment.{layer}")

    def _turns(self, points: np.ndarray, size: tuple[int, int]) -> np.ndarray:
        """(n, 32) unit complex numbers, which encode places."""
        places = (points - np.array(size, np.float32) / 2) / (max(size) / 2)
        return np.exp(1j * (places @ self.state["posenc.Wr.weight"].T)).astype(np.complex64)

    def _attended(self, x: np.ndarray, turns: np.ndarray, name: str) -> np.ndarray:
        """Features that have looked at those of their own image."""
        parts = self._linear(x, f"{name}.Wqkv").reshape(len(x), HEADS, -1, 3)
        q, k, v = np.ascontiguousarray(parts.transpose(3, 1, 0, 2))
        q, k = ((part.view(np.complex64) * turns).view(np.float32) for part in (q, k))
        likeness = q @ k.transpose(0, 2, 1) / np.float32(np.sqrt(q.shape[2]))
        return self._told(x, softmax(likeness) @ v, name, "out_proj")

    def _crossed(self, a: np.ndarray, b: np.ndarray, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Features that have looked at those of the other image."""
        (qa, va), (qb, vb) = (
            [
                self._linear(x, f"{name}.{part}").reshape(len(x), HEADS, -1).transpose(1, 0, 2)
                for part in ("to_qk", "to_v")
            ]
            for x in (a, b)
        )
        likeness = qa @ qb.transpose(0, 2, 1) / np.float32(np.sqrt(qa.shape[2]))
        there = self._told(a, softmax(likeness) @ vb, name, "to_out")
        return there, self._told(b, softmax(likeness.transpose(0, 2, 1)) @ va, name, "to_out")

    def _told(self, x: np.ndarray, heads: np.ndarray, name: str, last: str) -> np.ndarray:
        """Features with a message added, which the (4, n, 64) heads bring."""
        from scipy.special import erf  # here: slow to import, and seldom needed

        message = self._linear(heads.transpose(1, 0, 2).reshape(len(x), -1), f"{name}.{last}")
        hidden = self._linear(np.concatenate([x, message], axis=1), f"{name}.ffn.0")
        hidden -= hidden.mean(axis=1, keepdims=True)
        hidden /= np.sqrt(hidden.var(axis=1, keepdims=True) + np.float32(EPSILON))
        hidden = hidden * self.state[f"{name}.ffn.1.weight"] + self.state[f"{name}.ffn.1.bias"]
        hidden *= (1 + erf(hidden * ROOT_HALF)) / 2
        return x + self._linear(hidden, f"{name}.ffn.3")

    def _sure(self, both: np.ndarray, layer: int) -> bool:
        """Check whether further layers would change little."""
        confident = sigmoid(self._linear(both, f"token_confidence.{layer}.token.0"))
        least = 0.8 + 0.1 * np.exp(-4.0 * layer / LAYERS)
        return bool((confident >= least).mean() > STOP)

    def _assigned(self, a: np.ndarray, b: np.ndarray, name: str) -> np.ndarray:
        """(m, 2) rows that are each other's likeliest, and likely."""
        ours, theirs = (self._linear(x, f"{name}.final_proj") for x in (a, b))
        likeness = ours @ theirs.T / np.float32(np.sqrt(ours.shape[1]))
        worth = [sigmoid(self._linear(x, f"{name}.matchability")) for x in (a, b)]
        likely = softmax(likeness, 1) * softmax(likeness, 0) * worth[0] * worth[1].T
        there = likely.argmax(axis=1)
        rows = np.arange(len(a))
        kept = (likely.argmax(axis=0)[there] == rows) & (likely[rows, there] > LEAST)
        return np.stack([rows[kept], there[kept]], axis=1).astype(np.uint32)

    def _linear(self, x: np.ndarray, name: str) -> np.ndarray:
        return x @ self.state[f"{name}.weight"].T + self.state[f"{name}.bias"]
