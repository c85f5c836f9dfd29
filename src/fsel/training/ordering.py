"""Ordering of a set of frames into a trajectory of picks (paper, Eq. 3), and its weight (Eq. 5)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.core.files import Columns
from fsel.core.geometry import pairwise_distances, pose_distance
from fsel.core.problem import Problem

EPSILON = 1e-12


def order_subset(distances: np.ndarray, apart: np.ndarray) -> np.ndarray:
    """Return (K,) int64 rows of (K, O) `distances` to views in pick order (paper, Eq. 3): each
    reduces the views' distance to their nearest pick most; ties go to the row farthest from the
    picks by (K, K) `apart`, or the scorer would learn to pick neighbours in capture order."""
    k = len(distances)
    remaining = np.full(distances.shape[1], np.inf)
    gap = np.zeros(k)
    order = np.empty(k, dtype=np.int64)
    free = np.ones(k, dtype=bool)
    for step in range(k):
        residual = np.minimum(remaining, distances).sum(axis=1)
        tied = free & (residual == residual[free].min())
        order[step] = pick = np.argmax(np.where(tied, gap, -1.0))
        free[pick] = False
        remaining = np.minimum(remaining, distances[pick])
        gap = np.minimum(gap, apart[pick]) if step else apart[pick]
    return order


def trajectory_weights(fitness: np.ndarray) -> np.ndarray:
    """Return (M,) weights of mean one, softly favouring the fittest subset (paper, Eq. 5)."""
    raw = np.exp((fitness - fitness.max()) / (fitness.std() + EPSILON))
    return raw / raw.mean()


def ordered_item(
    problem: Problem, labels: Columns, kept: int, source: str | Path = "labels"
) -> list[dict]:
    """Order and weigh the `kept` fittest subsets of a labelled problem, the fittest first;
    ValueError naming `source` for frames that are no candidates."""
    by_rank = np.argsort(labels["rank"])
    fittest = by_rank[labels["rank"][by_rank] >= 0][:kept]
    fitness = labels["fitness"][fittest]
    weights = trajectory_weights(fitness).tolist()
    rows = []
    for rank, (row, value, weight) in enumerate(zip(fittest, fitness, weights, strict=True)):
        subset = labels["subset"][row]
        others = np.setdiff1d(subset, problem.candidates)
        if len(others):
            raise ValueError(
                f"{source}: the subset of rank {rank} holds frames {others.tolist()}, which "
                "are no candidates. Hint: it was searched on another split; search again"
            )
        centers, axes = problem.capture.centers[subset], problem.capture.axes[subset]
        distances = pairwise_distances(centers, problem.capture.centers[problem.proxies])
        order = order_subset(distances, pose_distance(centers, axes, centers, axes))
        picks = subset[order].tolist()
        rows.append({"rank": rank, "fitness": value, "weight": weight, "picks": picks})
    return rows
