"""Clustering by k-medoids on joint pose and appearance (Kaufman and Rousseeuw 1990)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fsel.core.compiled import exact
from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.greedy import BLOCK, locate

ROUNDING = 1e-6  # of a distance in float32
DENSE = 2048  # frames up to which all distances are kept: 16 MB

Rows = Callable[[np.ndarray], np.ndarray]
"""(b,) rows -> (b, n) float32 distances to all, symmetric, 0 to itself."""


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Return the medoids, ascending: greedy ones (BUILD of PAM), then swapped (FasterPAM)."""
    pool = problem.observed
    distance = distances(
        problem.capture.centers[pool], problem.capture.axes[pool], problem.descriptors[pool]
    )
    if len(pool) <= DENSE:
        whole = distance(np.arange(len(pool)))
        distance = whole.__getitem__
    build = locate(lambda rows: 1 - distance(rows), np.full(len(pool), np.inf), k)
    return pool[np.sort(fasterpam(distance, len(pool), build))]


def distances(centers: np.ndarray, axes: np.ndarray, described: np.ndarray) -> Rows:
    """Mean of centre distance, viewing angle and 1 - appearance similarity, each over its maximum.

    A maximum of nothing but rounding counts as one.
    """
    from scipy.spatial.distance import cdist  # here: most jobs do without, and it is slow

    described = np.ascontiguousarray(described)

    def unlike(rows: np.ndarray) -> np.ndarray:
        apart = described[rows] @ described.T
        np.subtract(1, apart, out=apart)
        np.maximum(apart, 0, out=apart)
        apart[np.arange(len(rows)), rows] = 0
        return apart

    blocks = [np.arange(i, min(i + BLOCK, len(centers))) for i in range(0, len(centers), BLOCK)]
    gap = max(cdist(centers[rows], centers).max() for rows in blocks)
    chord = max(cdist(axes[rows], axes).max() for rows in blocks)
    angle = _angle(chord) if chord > ROUNDING else 1.0
    appearance = max(max(unlike(rows).max() for rows in blocks), ROUNDING)

    def joint(rows: np.ndarray) -> np.ndarray:
        total = unlike(rows)
        for i in range(0, len(rows), BLOCK):
            part, some = total[i : i + BLOCK], rows[i : i + BLOCK]
            part /= appearance
            part += cdist(centers[some], centers) / (gap if gap > 0 else 1.0)
            part += _angle(cdist(axes[some], axes)) / angle
            part /= 3
        return total

    return joint


def _angle(chord: np.ndarray) -> np.ndarray:
    """Radians between unit vectors from the distance of their ends."""
    return 2 * np.arcsin(np.minimum(0.5 * chord, 1.0))


def fasterpam(distance: Rows, count: int, medoids: np.ndarray) -> np.ndarray:
    """Swap medoids until no single swap lowers the summed distance (Schubert and Rousseeuw 2021).

    Every candidate in turn, the most central first, is weighed against all medoids at once, and the
    best swap is made as soon as it helps. One medoid is returned as it came.

    Args:
        distance: of blocks of rows; computed anew in every round.
        count: n.
        medoids: (k,) int64 start.
    """
    if len(medoids) == 1:
        return medoids
    starts = range(0, count, BLOCK)
    everyone = np.arange(count)
    sums = [distance(everyone[i : i + BLOCK]).sum(axis=1, dtype=np.float64) for i in starts]
    # by summed distance to all, so that the order of frames has no effect
    order = np.argsort(np.concatenate(sums), kind="stable")
    medoids = medoids.copy()
    to_medoids = distance(medoids)
    since = 0
    while since < count:
        for i in starts:
            turn = order[i : i + BLOCK]
            since = _swapped(distance(turn), turn, medoids, to_medoids, since)
            if since >= count:
                break
    return medoids


@exact
def _swapped(distance, candidates, medoids, to_medoids, since):
    """Weigh (b,) candidates by their (b, n) distances; swap in place, medoids' distances too.

    Return the number of candidates weighed since the last swap.
    """
    n, k = to_medoids.shape[1], len(medoids)
    near, first, second = np.empty(n, np.int64), np.empty(n), np.empty(n)
    change = np.empty(k)  # in loss, of swapping a candidate for each medoid, less a common part
    _assign(to_medoids, near, first, second)
    for b in range(len(candidates)):
        if since >= n:
            break
        # loops: numba's `any` and assignment of a row take seconds to compile
        worst, common, free = 0, 0.0, True
        for m in range(k):
            free &= medoids[m] != candidates[b]
            change[m] = 0.0
        if free:
            for i in range(n):
                gap = distance[b, i] - first[i]
                if gap < 0:
                    common += gap
                else:
                    change[near[i]] += min(distance[b, i], second[i]) - first[i]
            for m in range(k):
                worst = m if change[m] < change[worst] else worst
            if common + change[worst] < -ROUNDING:
                medoids[worst] = candidates[b]
                for i in range(n):
                    to_medoids[worst, i] = distance[b, i]
                _assign(to_medoids, near, first, second)
                since = 0
        since += 1
    return since


@exact
def _assign(to_medoids, near, first, second):
    """Fill the place of each row's nearest medoid, and its distances to the two nearest."""
    for i in range(len(near)):
        near[i], first[i], second[i] = 0, np.inf, np.inf
    for m in range(len(to_medoids)):
        for i in range(len(near)):
            gap = to_medoids[m, i]
            if gap < first[i]:
                near[i], first[i], second[i] = m, gap, first[i]
            elif gap < second[i]:
                second[i] = gap


METHOD = Method(
    "kmedoids", "$k$-medoids", "observed", nested=False, select=select, reads=("appearance",)
)
