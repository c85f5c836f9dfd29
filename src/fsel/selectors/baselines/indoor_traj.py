"""IndoorTraj's max-min diversity over a joint similarity (Wang et al. 2024)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fsel.core.geometry import centered
from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.greedy import most_central

POSITION, ROTATION = 0.7, 0.2  # shares of the similarity; appearance has the rest
SPREAD = 0.5  # of the Gaussian over positions, in the cameras' root mean square radius


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick the frame whose greatest similarity to the selected is least, first the most central."""
    pool = problem.observed
    rows_of = similarities(problem, pool)
    nearest = np.full(len(pool), -np.inf)
    picks = np.empty(k, dtype=np.int64)
    row = most_central(problem.capture.centers[pool])
    for step in range(k):
        picks[step] = row
        nearest = np.maximum(nearest, rows_of(row))
        nearest[row] = np.inf
        row = int(np.argmin(nearest))
    return pool[picks]


def similarities(problem: Problem, pool: np.ndarray) -> Callable[[int], np.ndarray]:
    """Make what gives (n,) similarities of one row of a pool with all.

    Similarity is a Gaussian of the centres' distance, the cosine of the relative rotation and that
    of the descriptors.
    """
    centers = problem.capture.centers[pool]
    turns = problem.capture.world_to_camera[pool, :, :3].reshape(len(pool), 9)
    described = problem.descriptors[pool].astype(np.float64)
    variance = np.square(centered(centers)).sum(axis=1).mean()
    scale = 2 * SPREAD**2 * (variance if variance > 0 else 1.0)

    def of(row: int) -> np.ndarray:
        square = np.square(centers - centers[row]).sum(axis=1)
        cosine = (np.einsum("ni,i->n", turns, turns[row]) - 1) / 2
        alike = np.einsum("nd,d->n", described, described[row])
        total = POSITION * np.exp(-square / scale) + ROTATION * (cosine + 1) / 2
        return total + (1 - POSITION - ROTATION) * alike

    return of


METHOD = Method(
    *("indoor_traj", "IndoorTraj max-min", "observed"),
    nested=True,
    select=select,
    reads=("appearance",),
)
