"""IndoorTraj's k-DPP: an exact sample over its joint similarity (Wang et al. 2024)."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem
from fsel.features.appearance import KERNEL_JITTER
from fsel.selectors.baselines.indoor_traj import similarities


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """A sample of k frames, each set as likely as the determinant of its similarities is large.

    Negative eigenvalues, which the joint similarity may have, count as zero; then 1e-6 is added to
    all, so that no budget exceeds the rank. Of more than 1,000 frames 1,000 evenly spread ones
    stand for all, since time grows with their cube.
    """
    pool = problem.sequence if k <= len(problem.sequence) else problem.observed
    similar = similarities(problem, pool)
    values, vectors = np.linalg.eigh(np.stack([similar(row) for row in range(len(pool))]))
    values = np.maximum(values, 0) + KERNEL_JITTER
    return pool[_projected(vectors[:, _chosen(values, k, rng)], rng)]


def _chosen(values: np.ndarray, k: int, rng: np.random.Generator) -> np.ndarray:
    """(k,) eigenvectors of a k-DPP's elementary part (Kulesza and Taskar 2012, algorithm 8)."""
    logs = np.log(values)
    total = np.full((len(values) + 1, k + 1), -np.inf)  # logarithms of symmetric polynomials
    total[:, 0] = 0.0
    for n, log in enumerate(logs, 1):
        total[n, 1:] = np.logaddexp(total[n - 1, 1:], log + total[n - 1, :-1])
    chosen: list[int] = []
    for n in range(len(values), 0, -1):
        left = k - len(chosen)
        if left == 0:
            break
        share = np.exp(logs[n - 1] + total[n - 1, left - 1] - total[n, left])
        if left == n or rng.random() < share:
            chosen.append(n - 1)
    return np.array(chosen)


def _projected(vectors: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(k,) int64 rows sampled from the projection onto (n, k) orthonormal columns, in turn."""
    count = vectors.shape[1]
    left = np.square(vectors).sum(axis=1)
    basis = np.empty((count, count))
    rows = np.empty(count, np.int64)
    for step in range(count):
        left[rows[:step]] = 0.0
        share = np.maximum(left, 0)
        rows[step] = rng.choice(len(left), p=share / share.sum())
        known = basis[:step]
        own = vectors[rows[step]] - known.T @ (known @ vectors[rows[step]])
        basis[step] = own / np.linalg.norm(own)
        left -= np.square(vectors @ basis[step])
    return rows


METHOD = Method(
    "indoor_traj_dpp",
    "IndoorTraj $k$-DPP",
    "observed",
    nested=False,
    seeds=3,
    select=select,
    reads=("appearance",),
)
