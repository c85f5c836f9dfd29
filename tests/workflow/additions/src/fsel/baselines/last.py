"""The last frames that may be used."""

from __future__ import annotations

import numpy as np

from fsel.problem import Method, Problem


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """The last frame first."""
    return problem.observed[::-1][:k]


METHOD = Method("last", "Last frames", "observed", nested=True, seeds=1, select=select)
