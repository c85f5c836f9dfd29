"""Methods by the points that frames share: NeRF-Director, and the MVSNet view-selection score."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsel.core.geometry import centered
from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.covisibility import (
    most_shared,
    score_rows,
    score_sums,
    scores_with,
    shared_points,
    tracks,
)
from fsel.selectors.baselines.greedy import locate, most_central

ROUNDING = 1e-4  # relative error of sums in float32, at most
KEPT = 2**27  # scores that are kept for a second look, 512 MB: those of 10,000 frames


def nerf_director(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Sample farthest views by position and co-visibility together, greedily (Xiao et al. 2024):
    under |c_i - c_j| + 2 r (1 - n_ij / max n).

    n_ij counts shared points, see `covisibility.tracks`, r is the cameras' radius about their mean.
    Starts from the most central camera.
    """
    pool = problem.observed
    centers = problem.capture.centers[pool]
    radius = np.linalg.norm(centered(centers), axis=1).max()
    arrays = tracks(problem, pool).arrays
    most = max(most_shared(arrays), 1)
    gap, counts = np.full(len(pool), np.inf), np.empty(len(pool), np.int64)
    picks = np.empty(k, dtype=np.int64)
    row = most_central(centers)
    for step in range(k):
        picks[step] = row
        shared_points(row, arrays, counts)
        distance = np.linalg.norm(centers - centers[row], axis=1)
        gap = np.minimum(gap, distance + 2 * radius * (1 - counts / most))
        gap[row] = -np.inf
        row = int(np.argmax(gap))
    return pool[picks]


def mvsnet(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Return the frames whose scores with the proxies have the largest sum; ties go to the lowest.

    Scores (Yao et al. 2018) are sums over shared points, see `covisibility.tracks`.
    """
    seen = np.union1d(problem.candidates, problem.proxies)
    arrays = tracks(problem, seen).arrays
    total, scores = np.zeros(len(seen)), np.empty(len(seen))
    for row in np.searchsorted(seen, problem.proxies):
        scores_with(row, arrays, scores)
        total += scores
    best = seen[np.argsort(-total, kind="stable")]
    return best[np.isin(best, problem.observed)][:k]


def mvsnet_location(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
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


NERF_DIRECTOR = Method(
    "nerf_director", "NeRF-Director", "observed", nested=True, select=nerf_director, tracks=True
)
MVSNET = Method(
    "mvsnet", "MVSNet score", "observed", nested=True, select=mvsnet, tracks=True, aimed=True
)
MVSNET_LOCATION = replace(
    MVSNET,
    name="mvsnet_location",
    label="MVSNet, facility location",
    select=mvsnet_location,
    aimed=False,
)
