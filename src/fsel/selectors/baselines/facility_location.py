"""Greedy facility location on appearance: every frame should resemble a selected one."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.greedy import locate

ROUNDING = 1e-4  # relative error of sums in float32, at most


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Maximise sum_i max_{j in S} (1 + f_i . f_j) over the pool's frames i, greedily."""
    pool = problem.observed
    described = np.ascontiguousarray(problem.descriptors[pool])

    def values(rows: np.ndarray) -> np.ndarray:
        return np.maximum(1 + described[rows] @ described.T, 0)

    total = len(pool) + described.astype(np.float64) @ described.sum(axis=0, dtype=np.float64)
    return pool[locate(values, total * (1 + ROUNDING), k)]


METHOD = Method(
    "facility", "Facility location", "observed", nested=True, select=select, reads=("appearance",)
)
