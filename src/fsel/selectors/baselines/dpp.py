"""Greedy MAP of a determinantal point process over appearance (Kulesza and Taskar 2012)."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem
from fsel.features.appearance import KERNEL_JITTER


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Maximise log det of the chosen frames' similarities, one frame at a time."""
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


METHOD = Method("dpp", "DPP", "observed", nested=True, select=select, reads=("appearance",))
