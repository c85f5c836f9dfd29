"""Farthest-view sampling of camera centres (Xiao et al. 2024)."""

from __future__ import annotations

import numpy as np

from fsel.core.geometry import farthest_views
from fsel.core.problem import Method, Problem


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Sample farthest points greedily from a random first view, or from given ones."""
    pool, given = problem.observed, problem.fixed_picks
    start = given if len(given) else rng.choice(pool)
    return farthest_views(pool, problem.capture.centers, k, start).astype(np.int64)


METHOD = Method("fvs", "FVS", "observed", nested=True, seeds=3, select=select, begins=True)
