"""Round-robin over the targets, closest frame first."""

from __future__ import annotations

import numpy as np

from fsel.core.geometry import pose_distance
from fsel.core.problem import Method, Problem


def nearest(problem: Problem, pool: np.ndarray, k: int) -> np.ndarray:
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


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick the `nearest` frames of P and O."""
    return nearest(problem, problem.observed, k)


METHOD = Method("nearest", "Nearest", "observed", nested=True, select=select, aimed=True)
