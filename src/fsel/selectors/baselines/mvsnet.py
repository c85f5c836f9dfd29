"""The MVSNet view-selection score towards the target views, top K (Yao et al. 2018)."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.covisibility import scores_with, tracks


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """The frames whose scores with the proxies have the largest sum; ties go to the lowest.

    Scores are sums over shared sparse points (without any, predicted ones: see
    `covisibility.tracks`).
    """
    seen = np.union1d(problem.candidates, problem.proxies)
    arrays = tracks(problem, seen).arrays
    total, scores = np.zeros(len(seen)), np.empty(len(seen))
    for row in np.searchsorted(seen, problem.proxies):
        scores_with(row, arrays, scores)
        total += scores
    best = seen[np.argsort(-total, kind="stable")]
    return best[np.isin(best, problem.observed)][:k]


METHOD = Method("mvsnet", "MVSNet score", "observed", nested=True, select=select, tracks=True)
