"""Long-LRM's own selector: k-means on camera centre and viewing direction (Chen et al. 2024)."""

from __future__ import annotations

import numba
import numpy as np

from fsel.baselines.greedy import most_central
from fsel.problem import Method, Problem
from fsel.search import farthest_views

ROUNDS = 300  # Lloyd's iterations at most
ROUNDING = 1e-9  # of distances between points of about unit size


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """The nearest free frame of each cluster's mean.

    Centres are divided by their radius about their mean, so that the world's unit has no say. The
    first means are a farthest-point sample from the most central frame; no chance is involved.
    """
    pool = problem.observed
    centers = problem.capture.centers[pool]
    offset = centers - centers.mean(axis=0)
    radius = np.linalg.norm(offset, axis=1).max()
    points = np.hstack([offset / (radius if radius > 0 else 1.0), problem.capture.axes[pool]])
    start = farthest_views(np.arange(len(pool)), points, k, most_central(points))
    return pool[snapped(points, lloyd(points, points[start], ROUNDS))]


@numba.njit(cache=True, nogil=True)
def lloyd(points, means, rounds):
    """Lloyd's algorithm: (n, d) points and (k, d) first means -> (k, d) means.

    Stops when no point changes its cluster; a cluster left empty keeps its mean.
    """
    n, width = points.shape
    k = len(means)
    means = means.copy()
    label = np.full(n, -1)
    for _ in range(rounds):
        moved = False
        total, count = np.zeros((k, width)), np.zeros(k)
        for i in range(n):
            best, least = 0, np.inf
            for m in range(k):
                square = 0.0
                for a in range(width):
                    square += (points[i, a] - means[m, a]) ** 2
                if square < least:
                    best, least = m, square
            moved |= label[i] != best
            label[i] = best
            count[best] += 1
            for a in range(width):
                total[best, a] += points[i, a]
        if not moved:
            break
        for m in range(k):
            if count[m] > 0:
                means[m] = total[m] / count[m]
    return means


def snapped(points: np.ndarray, means: np.ndarray) -> np.ndarray:
    """(k,) int64 rows: the nearest one to each mean that no mean before it took.

    Both members of a pair are equally near to their mean: the more central one is taken, so that
    rounding does not choose.
    """
    remote = np.linalg.norm(points - points.mean(axis=0), axis=1)
    free = np.ones(len(points), dtype=bool)
    rows = np.empty(len(means), dtype=np.int64)
    for m, mean in enumerate(means):
        gap = np.where(free, np.linalg.norm(points - mean, axis=1), np.inf)
        rows[m] = np.argmin(np.where(gap <= gap.min() + ROUNDING, remote, np.inf))
        free[rows[m]] = False
    return rows


METHOD = Method("long_lrm", "Long-LRM $k$-means", "observed", nested=False, seeds=1, select=select)
