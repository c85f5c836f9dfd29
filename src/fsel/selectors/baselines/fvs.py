"""Farthest-view sampling of camera centres (Xiao et al. 2024)."""

from __future__ import annotations

import numpy as np

from fsel.core.geometry import farthest_views
from fsel.core.problem import Method, Problem


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Sample farthest points greedily from a random first view."""
    pool = problem.observed
    return farthest_views(pool, problem.capture.centers, k, int(rng.choice(pool))).astype(np.int64)


METHOD = Method("fvs", "FVS", "observed", nested=True, seeds=3, select=select)
