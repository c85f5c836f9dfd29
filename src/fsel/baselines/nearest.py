"""Round-robin over the targets, closest frame first."""

from __future__ import annotations

import numpy as np

from fsel.data.geometry import pose_distance
from fsel.data.problem import Method, Problem


def nearest(problem: Problem, pool: np.ndarray, k: int) -> np.ndarray:
    """(k,) frames of a pool: each target in turn takes its closest free frame.

    The distance is the split's own; ties go to the lowest frame.
    """
    capture, targets = problem.capture, problem.targets
    distance = pose_distance(
        capture.centers[pool], capture.axes[pool], targets.centers, targets.axes
    )
    picks = np.empty(k, dtype=np.int64)
    for turn in range(k):
        target = turn % len(targets)
        row = int(np.argmin(distance[:, target]))
        picks[turn] = pool[row]
        distance[row] = np.inf
    return picks


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick the `nearest` frames of P and O."""
    return nearest(problem, problem.observed, k)


METHOD = Method("nearest", "Nearest", "observed", nested=True, select=select)
