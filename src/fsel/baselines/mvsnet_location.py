"""The MVSNet view-selection score as a set function: greedy facility location."""

from __future__ import annotations

import numpy as np

from fsel.baselines.covisibility import all_scores, tracks
from fsel.baselines.greedy import locate
from fsel.problem import Method, Problem


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Greedy maximisation of sum_i max_{j in S} s(i, j) over the pool's frames i."""
    pool = problem.observed
    scores = all_scores(tracks(problem, pool).arrays)
    return pool[locate(lambda rows: scores[rows], np.full(len(pool), np.inf), k)]


METHOD = Method(
    "mvsnet_location",
    "MVSNet, facility location",
    "observed",
    nested=True,
    seeds=1,
    select=select,
)
