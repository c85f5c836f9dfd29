"""The MVSNet view-selection score (Yao et al. 2018): towards the targets, or as a set function."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.covisibility import score_rows, score_sums, scores_with, tracks
from fsel.selectors.baselines.greedy import locate

ROUNDING = 1e-4  # relative error of sums in float32, at most
KEPT = 2**27  # scores that are kept for a second look, 512 MB: those of 10,000 frames


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Return the frames whose scores with the proxies have the largest sum; ties go to the lowest.

    Scores are sums over shared points, see `covisibility.tracks`.
    """
    seen = np.union1d(problem.candidates, problem.proxies)
    arrays = tracks(problem, seen).arrays
    total, scores = np.zeros(len(seen)), np.empty(len(seen))
    for row in np.searchsorted(seen, problem.proxies):
        scores_with(row, arrays, scores)
        total += scores
    best = seen[np.argsort(-total, kind="stable")]
    return best[np.isin(best, problem.observed)][:k]


def facility_location(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Maximise sum_i max_{j in S} s(i, j) over the pool's frames i, greedily."""
    pool = problem.observed
    seen = tracks(problem, pool).arrays
    bounds = score_sums(seen) * (1 + ROUNDING)
    known: dict[int, np.ndarray] = {}

    def values(rows: np.ndarray) -> np.ndarray:
        new = [row for row in rows.tolist() if row not in known]
        if (len(known) + len(new)) * len(pool) > KEPT:
            known.clear()
            new = rows.tolist()
        known.update(zip(new, score_rows(np.array(new, np.int64), seen), strict=True))
        return np.stack([known[row] for row in rows.tolist()])

    return pool[locate(values, bounds, k)]


METHOD = Method(
    "mvsnet", "MVSNet score", "observed", nested=True, select=select, tracks=True, aimed=True
)
LOCATION = replace(
    METHOD,
    name="mvsnet_location",
    label="MVSNet, facility location",
    select=facility_location,
    aimed=False,
)
