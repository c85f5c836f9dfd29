"""Methods by poses alone: farthest views, those nearest to the targets, and Long-LRM's clusters."""

from __future__ import annotations

import numpy as np

from fsel.core.geometry import centered, farthest_views, pose_distance
from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.greedy import most_central

ROUNDS = 300  # Lloyd's iterations at most
ROUNDING = 1e-9  # of distances between points of about unit size


def fvs(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Sample farthest points among the camera centres greedily (Xiao et al. 2024), from a random
    first view or from given ones."""
    pool, given = problem.observed, problem.fixed_picks
    start = given if len(given) else rng.choice(pool)
    return farthest_views(pool, problem.capture.centers, k, start).astype(np.int64)


def nearest_frames(problem: Problem, pool: np.ndarray, k: int) -> np.ndarray:
    """Return (k,) frames of a pool: each target in turn takes its closest free frame."""
    capture, targets = problem.capture, problem.targets
    distance = pose_distance(
        capture.centers[pool], capture.axes[pool], targets.centers, targets.axes
    )
    return pool[in_turn(distance, k)]


def in_turn(distance: np.ndarray, k: int) -> np.ndarray:
    """Return (k,) rows of (n, T) distances: each column in turn takes its least free row."""
    free, picks = distance.copy(), np.empty(k, dtype=np.int64)
    for turn in range(k):
        target = turn % distance.shape[1]
        picks[turn] = np.argmin(free[:, target])
        free[picks[turn]] = np.inf
    return picks


def nearest(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick the `nearest_frames` of P and O."""
    return nearest_frames(problem, problem.observed, k)


def long_lrm(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Return the nearest free frame of each mean of k-means on camera centre and viewing direction,
    Long-LRM's own selector (Ziwen et al. 2025).

    Centres are divided by their radius about their mean. The first means are a farthest-point
    sample from the most central frame.
    """
    pool = problem.observed
    centers = problem.capture.centers[pool]
    offset = centered(centers)
    radius = np.linalg.norm(offset, axis=1).max()
    points = np.hstack([offset / (radius if radius > 0 else 1.0), problem.capture.axes[pool]])
    start = farthest_views(np.arange(len(pool)), points, k, most_central(points))
    return pool[snapped(points, lloyd(points, points[start], ROUNDS))]


def lloyd(points: np.ndarray, means: np.ndarray, rounds: int) -> np.ndarray:
    """Run Lloyd's algorithm on (n, d) points and (k, d) means; an empty cluster keeps its mean."""
    from scipy.spatial.distance import cdist  # here: most jobs do without, and it is slow

    means = means.copy()
    label = np.full(len(points), -1)
    for _ in range(rounds):
        nearest = cdist(points, means, "sqeuclidean").argmin(axis=1)
        if (nearest == label).all():
            break
        label = nearest
        count = np.bincount(label, minlength=len(means))
        total = np.zeros_like(means)
        np.add.at(total, label, points)
        means[count > 0] = total[count > 0] / count[count > 0, None]
    return means


def snapped(points: np.ndarray, means: np.ndarray) -> np.ndarray:
    """Return (k,) int64 rows: the nearest one to each mean that no mean before it took.

    Of a pair that is equally near to its mean, the more central one is taken.
    """
    remote = np.linalg.norm(centered(points), axis=1)
    free = np.ones(len(points), dtype=bool)
    rows = np.empty(len(means), dtype=np.int64)
    for m, mean in enumerate(means):
        gap = np.where(free, np.linalg.norm(points - mean, axis=1), np.inf)
        rows[m] = np.argmin(np.where(gap <= gap.min() + ROUNDING, remote, np.inf))
        free[rows[m]] = False
    return rows


FVS = Method("fvs", "FVS", "observed", nested=True, seeds=3, select=fvs, begins=True)
NEAREST = Method("nearest", "Nearest", "observed", nested=True, select=nearest, aimed=True)
LONG_LRM = Method("long_lrm", "Long-LRM $k$-means", "observed", nested=False, select=long_lrm)
