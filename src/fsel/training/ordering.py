"""Ordering of a set of frames into a trajectory of picks (paper, Eq. 3), and its weight (Eq. 5)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.core.files import Columns
from fsel.core.geometry import pairwise_distances, pose_distance
from fsel.core.problem import Problem

EPSILON = 1e-12


def order_subset(distances: np.ndarray, apart: np.ndarray) -> np.ndarray:
    """Order frames so that each most reduces the views' distance to their nearest picked frame.

    Once every view has its nearest frame of the subset, no other reduces anything: with 4 views
    that is the case for three quarters of 20 frames, and the paper does not say which comes next.
    Here the one farthest from those picked does: in the capture's order, the scorer would learn to
    pick neighbours of picked frames.

    Args:
        distances: (K, O) distance of each frame of the subset to each optimisation view, any unit.
        apart: (K, K) distance of the frames to one another, any unit; it decides ties.

    Returns:
        (K,) int64 rows of `distances` in pick order (paper, Eq. 3); ties go to the row farthest
        from the picked ones, then to the lowest.
    """
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
    """Return (M,) weights of mean one, softly favouring the fittest subset (paper, Eq. 5).

    Equal fitnesses give equal weights: the numerator is then exactly zero.
    """
    raw = np.exp((fitness - fitness.max()) / (fitness.std() + EPSILON))
    return raw / raw.mean()


def ordered_item(
    problem: Problem, labels: Columns, kept: int, source: str | Path = "labels"
) -> list[dict]:
    """Order the fittest subsets of one labelled problem, and weigh them.

    Args:
        problem: that was labelled.
        labels: its searched subsets, see `fsel.training.labelling.search_table`.
        kept: how many of the fittest.
        source: where the labels are from, for error messages.

    Returns:
        rank, fitness, weight and picks of each, the fittest first.

    Raises:
        ValueError: for subsets that hold frames which are no candidates of the problem.
    """
    order = np.argsort(labels["rank"])
    fittest = order[labels["rank"][order] >= 0][:kept]
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
        picks = ordered(problem, subset).tolist()
        rows.append({"rank": rank, "fitness": value, "weight": weight, "picks": picks})
    return rows


def ordered(problem: Problem, subset: np.ndarray) -> np.ndarray:
    """Return (K,) frames of the subset in the order that they best cover the proxies (Eq. 3)."""
    capture = problem.capture
    centers, axes = capture.centers[subset], capture.axes[subset]
    distances = pairwise_distances(centers, capture.centers[problem.proxies])
    return subset[order_subset(distances, pose_distance(centers, axes, centers, axes))]
