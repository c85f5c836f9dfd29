"""The MVSNet view-selection score as a set function: greedy facility location."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.covisibility import score_rows, score_sums, tracks
from fsel.selectors.baselines.greedy import locate

ROUNDING = 1e-4  # relative error of sums in float32, at most


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Greedy maximisation of sum_i max_{j in S} s(i, j) over the pool's frames i.

    Scores are made for blocks of rows as needed: memory stays linear in the pool.
    """
    pool = problem.observed
    seen = tracks(problem, pool).arrays
    bounds = score_sums(seen) * (1 + ROUNDING)
    return pool[locate(lambda rows: score_rows(rows, seen), bounds, k)]


METHOD = Method(
    "mvsnet_location",
    "MVSNet, facility location",
    "observed",
    nested=True,
    select=select,
    tracks=True,
)
