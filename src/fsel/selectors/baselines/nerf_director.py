"""NeRF-Director: farthest views by position and co-visibility together (Xiao et al. 2024)."""

from __future__ import annotations

import numpy as np

from fsel.core.geometry import centered
from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.covisibility import most_shared, shared_points, tracks
from fsel.selectors.baselines.greedy import most_central


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Sample farthest points greedily under |c_i - c_j| + 2 r (1 - n_ij / max n).

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


METHOD = Method(
    "nerf_director", "NeRF-Director", "observed", nested=True, select=select, tracks=True
)
