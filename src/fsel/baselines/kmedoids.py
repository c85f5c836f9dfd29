"""k-medoids on joint pose and appearance (Kaufman and Rousseeuw 1990)."""

from __future__ import annotations

import math

import numba
import numpy as np

from fsel.baselines.greedy import locate
from fsel.problem import Method, Problem

ROUNDING = 1e-6  # of a distance in float32

_jit = numba.njit(cache=True, nogil=True)
_fast = numba.njit(cache=True, nogil=True, fastmath=True)


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
    likeness = described @ described.T
    _combine(np.ascontiguousarray(centers), np.ascontiguousarray(axes), likeness)
    return likeness


@_fast
def _combine(centers, axes, out):
    """Turn (n, n) similarities into joint distances, in place."""
    n = len(out)
    top_gap, top_chord, least = 0.0, 0.0, np.float32(1)
    for i in range(n):
        for j in range(i):
            least = min(least, out[i, j])
            top_gap = max(top_gap, _chord(centers, i, j))
            top_chord = max(top_chord, _chord(axes, i, j))
    per_gap = 1 / (3 * top_gap) if top_gap > 0 else 0.0
    per_angle = 1 / (3 * _angle(top_chord)) if top_chord > ROUNDING else 0.0
    per_unlike = 1 / (3 * (1 - least)) if 1 - least > ROUNDING else 0.0
    for i in range(n):
        out[i, i] = 0
        for j in range(i):
            value = per_gap * _chord(centers, i, j) + per_angle * _angle(_chord(axes, i, j))
            value += per_unlike * max(1 - out[i, j], np.float32(0))
            out[i, j] = out[j, i] = np.float32(value)


@_fast
def _chord(points, i, j):
    square = 0.0
    for a in range(3):
        square += (points[i, a] - points[j, a]) ** 2
    return math.sqrt(square)


@_fast
def _angle(chord):
    return 2 * math.asin(min(1.0, 0.5 * chord))


@_jit
def fasterpam(distance, medoids):
    """Swap medoids until no single swap lowers the summed distance (Schubert and Rousseeuw 2021).

    Every candidate in turn, the most central first, is weighed against all medoids at once in
    O(n + k), and the best swap is made as soon as it helps.

    Args:
        distance: (n, n) float32, symmetric.
        medoids: (k,) int64 start.

    Returns:
        (k,) int64 medoids. One medoid is returned as it came: BUILD's first is the best.
    """
    n, k = len(distance), len(medoids)
    medoids = medoids.copy()
    if k == 1:
        return medoids
    taken = np.zeros(n, np.bool_)
    taken[medoids] = True
    near, first, second = _assigned(distance, medoids)
    order = _central_first(distance)
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
def _central_first(distance):
    """Rows by their summed distance to all: an order that the frames' own has no say in."""
    total = np.zeros(len(distance))
    for i in range(len(distance)):
        for value in distance[i]:
            total[i] += value
    return np.argsort(total, kind="mergesort")


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


METHOD = Method("kmedoids", "$k$-medoids", "observed", nested=False, seeds=1, select=select)
