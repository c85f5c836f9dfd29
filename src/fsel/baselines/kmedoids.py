"""k-medoids on joint pose and appearance (Kaufman and Rousseeuw 1990)."""

from __future__ import annotations

import numba
import numpy as np

from fsel.baselines.greedy import BLOCK, locate
from fsel.problem import Method, Problem

ROUNDING = 1e-6  # of a distance in float32

_jit = numba.njit(cache=True, nogil=True)


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """The medoids, ascending: greedy ones (BUILD of PAM), then swapped (FasterPAM)."""
    pool = problem.observed
    distance = distances(
        problem.capture.centers[pool], problem.capture.axes[pool], problem.descriptors[pool]
    )
    build = locate(lambda rows: 1 - distance[rows], np.full(len(pool), np.inf), k)
    return pool[np.sort(fasterpam(distance, build))]


def distances(centers: np.ndarray, axes: np.ndarray, described: np.ndarray) -> np.ndarray:
    """Mean of centre distance, viewing angle and 1 - appearance similarity, each over its maximum.

    Args:
        centers, axes: (n, 3) float64; described: (n, D) float32 unit rows.

    Returns:
        (n, n) float32, 400 MB for 10,000 frames; a maximum of nothing but rounding counts as one.
    """
    from scipy.spatial.distance import cdist  # here: most jobs do without, and it is slow

    unlike = described @ described.T
    np.subtract(1, unlike, out=unlike)
    np.maximum(unlike, 0, out=unlike)
    np.fill_diagonal(unlike, 0)
    blocks = [slice(i, i + BLOCK) for i in range(0, len(centers), BLOCK)]
    gap = max(cdist(centers[rows], centers).max() for rows in blocks)
    chord = max(cdist(axes[rows], axes).max() for rows in blocks)
    angle = _angle(chord) if chord > ROUNDING else 1.0
    top = (gap if gap > 0 else 1.0, angle, max(unlike.max(), ROUNDING))
    for rows in blocks:
        joint = unlike[rows] / top[2]
        joint += cdist(centers[rows], centers) / top[0]
        joint += _angle(cdist(axes[rows], axes)) / top[1]
        unlike[rows] = joint / 3
    return unlike


def _angle(chord: np.ndarray) -> np.ndarray:
    """Radians between unit vectors from the distance of their ends."""
    return 2 * np.arcsin(np.minimum(0.5 * chord, 1.0))


def fasterpam(distance: np.ndarray, medoids: np.ndarray) -> np.ndarray:
    """Swap medoids until no single swap lowers the summed distance (Schubert and Rousseeuw 2021).

    Every candidate in turn, the most central first, is weighed against all medoids at once in
    O(n + k), and the best swap is made as soon as it helps.

    Args:
        distance: (n, n) float32, symmetric.
        medoids: (k,) int64 start.

    Returns:
        (k,) int64 medoids. One medoid is returned as it came: BUILD's first is the best.
    """
    if len(medoids) == 1:
        return medoids
    # by summed distance to all, so that the order of frames has no effect
    order = np.argsort(distance.sum(axis=1, dtype=np.float64), kind="stable")
    return _swapped(distance, medoids, order)


@_jit
def _swapped(distance, medoids, order):
    n, k = len(distance), len(medoids)
    medoids = medoids.copy()
    taken = np.zeros(n, np.bool_)
    taken[medoids] = True
    near, first, second = _assigned(distance, medoids)
    turn, since = 0, 0
    while since < n:
        candidate = order[turn]
        if not taken[candidate]:
            common, change = _changes(distance[candidate], near, first, second, k)
            worst = np.argmin(change)
            if common + change[worst] < -ROUNDING:
                taken[medoids[worst]], taken[candidate] = False, True
                medoids[worst] = candidate
                near, first, second = _assigned(distance, medoids)
                since = 0
        turn = (turn + 1) % n
        since += 1
    return medoids


@_jit
def _assigned(distance, medoids):
    """Place of each row's nearest medoid, and its distances to the nearest and second nearest."""
    n = len(distance)
    near = np.zeros(n, np.int64)
    first, second = np.full(n, np.inf), np.full(n, np.inf)
    for m in range(len(medoids)):
        row = distance[medoids[m]]
        for i in range(n):
            if row[i] < first[i]:
                near[i], first[i], second[i] = m, row[i], first[i]
            elif row[i] < second[i]:
                second[i] = row[i]
    return near, first, second


@_jit
def _changes(row, near, first, second, k):
    """Loss change of swapping a candidate for each medoid: a common part, and (k,) the rest."""
    change = np.zeros(k)
    common = 0.0
    for i in range(len(near)):
        if row[i] < first[i]:
            common += row[i] - first[i]
        else:
            change[near[i]] += min(row[i], second[i]) - first[i]
    return common, change


METHOD = Method(
    "kmedoids",
    "$k$-medoids",
    "observed",
    nested=False,
    seeds=1,
    select=select,
    reads=("appearance",),
)
