"""Uniformly spaced frames in capture order."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem
from fsel.core.subsets import evenly


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick rows round(linspace(0, n - 1, k)) of the pool, in capture order."""
    pool = problem.observed
    return pool[evenly(len(pool), k)]


METHOD = Method("uniform", "Uniform", "observed", nested=False, select=select)
