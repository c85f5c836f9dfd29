"""Simple selections for a capture of which nobody says what will be rendered.

Not in the paper. Each is good on some captures and bad on others; `fsel.request.trials` lets the
capture choose.
"""

from __future__ import annotations

import numpy as np

from fsel.baselines.kmedoids import fasterpam
from fsel.data.problem import Problem
from fsel.data.subsets import evenly
from fsel.request.covisible import covisible
from fsel.request.places import scene_distances

EVEN = "uniform"  # every n-th frame, which the others are compared with
STEEP = 3  # power of the distance of the steep medoids: the farthest frames decide
SCALE = 1000.0  # of the largest distance: sums in float32 then keep what tells two swaps apart


def candidates(problem: Problem, k: int) -> dict[str, np.ndarray]:
    """A few selections by name, (k,) ascending frames each.

    Args:
        problem: of a whole capture.
        k: how many of the frames of `problem.sequence`.

    Returns:
        `uniform`: every n-th frame. `middles`: the middles of k equal stretches. `kmedoids`: the
        medoids of the frames' distances, see `fsel.request.places`. `steep_medoids`: those of the
        distances' third power. `paced_medoids`: the same where a step along the sequence counts as
        a typical step between neighbours. `covisibility`: see `fsel.request.covisible`.
    """
    pool = problem.sequence
    n = len(pool)
    distance, middles = scene_distances(problem.capture, pool), stretches(n, k)
    order = np.arange(n)
    pace = np.median(distance[order[:-1], order[1:]]) * np.abs(order[:, None] - order)
    rows = {
        EVEN: evenly(n, k),
        "middles": middles,
        "kmedoids": medoids(distance, k, 1),
        "steep_medoids": medoids(distance, k, STEEP),
        "paced_medoids": medoids(distance + pace, k, STEEP),
        "covisibility": covisible(problem, pool, k),
    }
    return {name: pool[found] for name, found in rows.items()}


def stretches(count: int, k: int) -> np.ndarray:
    """(k,) int64 the middle row of each of k equal stretches of `count` rows."""
    return ((2 * np.arange(k) + 1) * count // (2 * k)).astype(np.int64)


def medoids(distance: np.ndarray, k: int, power: float) -> np.ndarray:
    """(k,) ascending rows, swapped one by one from evenly spaced ones until no swap lowers the sum.

    Args:
        distance: (n, n), symmetric.
        k: how many.
        power: of the distance to the nearest medoid, in the sum over all rows.
    """
    largest = distance.max()
    rows = (SCALE * (distance / (largest if largest > 0 else 1.0)) ** power).astype(np.float32)
    return np.sort(fasterpam(rows.__getitem__, len(rows), evenly(len(rows), k)))
