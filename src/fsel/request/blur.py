"""Blurred picks are exchanged for sharp frames beside them.

Not in the paper, whose sharpness is one input of many. Motion blurs single frames of a video, and
those beside them serve the same views. What it gains is in docs/experiments.md, "Blur".
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fsel.geometry import pose_distance
from fsel.problem import Problem

NEAR = 4  # frames closest to a pick by pose
SHARPER = 2.5  # times a pick's sharpness that one of them has where the pick is blurred

SharpnessOf = Callable[[np.ndarray], np.ndarray]
"""(n,) int64 frames -> (n,) sharpness of each, comparable within a call."""


def exchanged(problem: Problem, picks: np.ndarray, sharpness_of: SharpnessOf) -> np.ndarray:
    """Picks, of which each blurred one is exchanged for the sharpest of the frames beside it.

    A pick is blurred where one of the four candidates closest to it by pose is 2.5 times as sharp:
    these show much the same. Frames that are always to be selected stay.

    Args:
        problem: the selection problem; no frame comes but its candidates.
        picks: (K,) int64 candidates.
        sharpness_of: asked once, for the picks and the frames beside them.

    Returns:
        (K,) int64: a frame that comes has the place of the one that left.
    """
    pool, near = problem.candidates, _near(problem, picks)
    rows = np.searchsorted(pool, picks)
    asked = np.union1d(rows, near)
    sharpness = np.full(len(pool), np.nan)
    sharpness[asked] = sharpness_of(pool[asked])
    least = np.maximum(SHARPER * sharpness[rows], np.finfo(float).tiny)
    out = picks.copy()
    for at in np.flatnonzero(~np.isin(picks, problem.given)):
        free = near[at][~np.isin(pool[near[at]], out)]
        if len(free) and sharpness[free].max() >= least[at]:
            out[at] = pool[free[np.argmax(sharpness[free])]]
    return out


def _near(problem: Problem, picks: np.ndarray) -> np.ndarray:
    """(K, n) rows of the candidates closest to each pick by pose, itself left out."""
    capture, pool = problem.capture, problem.candidates
    distance = pose_distance(
        capture.centers[picks], capture.axes[picks], capture.centers[pool], capture.axes[pool]
    )
    distance[np.arange(len(picks)), np.searchsorted(pool, picks)] = np.inf
    return np.argsort(distance, axis=1, kind="stable")[:, : min(NEAR, len(pool) - 1)]
