"""Methods by what frames look like: diverse ones, and those that stand for the others."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fsel.core.geometry import centered
from fsel.core.problem import Method, Problem
from fsel.features.appearance import KERNEL_JITTER
from fsel.selectors.baselines.greedy import locate, most_central

ROUNDING = 1e-4  # relative error of sums in float32, at most
POSITION, ROTATION = 0.7, 0.2  # shares of the similarity; appearance has the rest
SPREAD = 0.5  # of the Gaussian over positions, in the cameras' root mean square radius


def dpp(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Maximise log det of the chosen frames' similarities, one frame at a time: greedy MAP of a
    determinantal point process (Kulesza and Taskar 2012)."""
    pool = problem.observed
    described = problem.descriptors[pool].astype(np.float64)
    length = np.linalg.norm(described, axis=1, keepdims=True)
    described = np.divide(described, length, out=np.zeros_like(described), where=length > 0)
    return pool[greedy_map(described, KERNEL_JITTER, k)]


def greedy_map(described: np.ndarray, jitter: float, k: int) -> np.ndarray:
    """Find the greedy MAP by an incremental Cholesky factor (Chen, Zhang and Zhou 2018).

    Every frame is equally good a first pick: the one most similar to all is taken. Later ties go to
    the lowest row. Once the kernel's rank is exhausted, every frame left adds the jitter alone.

    Args:
        described: (n, D) float64 rows of length one, or zero for a blank image.
        jitter: added to the kernel's diagonal.
        k: at most n.
    """
    factor = np.empty((k, len(described)))
    left = np.where(described.any(axis=1), 1 + jitter, jitter)
    picks = np.empty(k, np.int64)
    # einsum, not a product by BLAS: equal rows get equal sums wherever they stand
    likeness = np.einsum("nd,d->n", described, described.sum(axis=0))
    row = np.argmax(np.where(left > 1, likeness, -np.inf))
    for step in range(k):
        picks[step] = row
        root = np.sqrt(left[row])
        left[row] = -np.inf
        known = np.einsum("t,tn->n", factor[:step, row], factor[:step])
        factor[step] = (np.einsum("nd,d->n", described, described[row]) - known) / root
        left -= factor[step] ** 2
        row = np.argmax(left)
    return picks


def facility_location(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Maximise sum_i max_{j in S} (1 + f_i . f_j) over the pool's frames i, greedily: every
    frame should resemble a selected one."""
    pool = problem.observed
    described = np.ascontiguousarray(problem.descriptors[pool])

    def values(rows: np.ndarray) -> np.ndarray:
        return np.maximum(1 + described[rows] @ described.T, 0)

    total = len(pool) + described.astype(np.float64) @ described.sum(axis=0, dtype=np.float64)
    return pool[locate(values, total * (1 + ROUNDING), k)]


def indoor_traj(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick the frame whose greatest similarity to the selected is least, first the most central:
    IndoorTraj's max-min diversity over a joint similarity (Wang et al. 2024)."""
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


DPP = Method("dpp", "DPP", "observed", nested=True, select=dpp, reads=("appearance",))
FACILITY = Method(
    *("facility", "Facility location", "observed"),
    nested=True,
    select=facility_location,
    reads=("appearance",),
)
INDOOR_TRAJ = Method(
    *("indoor_traj", "IndoorTraj max-min", "observed"),
    nested=True,
    select=indoor_traj,
    reads=("appearance",),
)
