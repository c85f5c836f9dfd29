"""Random frames: prefixes of one permutation, so that budgets nest."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Return the first k of a random order of the pool."""
    return rng.permutation(problem.observed)[:k]


METHOD = Method("random", "Random", "observed", nested=True, seeds=3, select=select)
