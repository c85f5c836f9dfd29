"""From a set of frames to a trajectory of picks (paper, Eq. 3), and its weight (Eq. 5)."""

from __future__ import annotations

import numpy as np

EPSILON = 1e-12


def order_subset(distances: np.ndarray) -> np.ndarray:
    """Order frames so that each most reduces the views' distance to their nearest picked frame.

    Args:
        distances: (K, O) distance of each frame of the subset to each optimisation view, any unit.

    Returns:
        (K,) int64 rows of `distances` in pick order; ties go to the lowest row (paper, Eq. 3).
    """
    k = len(distances)
    remaining = np.full(distances.shape[1], np.inf)
    order = np.empty(k, dtype=np.int64)
    free = np.ones(k, dtype=bool)
    for step in range(k):
        residual = np.minimum(remaining, distances).sum(axis=1)
        order[step] = np.argmin(np.where(free, residual, np.inf))
        free[order[step]] = False
        remaining = np.minimum(remaining, distances[order[step]])
    return order


def trajectory_weights(fitness: np.ndarray) -> np.ndarray:
    """(M,) weights of mean one, softly favouring the fittest subset (paper, Eq. 5).

    Equal fitnesses give equal weights: the numerator is then exactly zero.
    """
    raw = np.exp((fitness - fitness.max()) / (fitness.std() + EPSILON))
    return raw / raw.mean()
