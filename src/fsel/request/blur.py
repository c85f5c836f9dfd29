"""Blurred picks give way to sharp frames beside them.

Not in the paper, whose sharpness is one input of many. Motion blurs single frames of a video, and
those beside them serve the same views. What it gains is in docs/experiments.md, "Blur".
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fsel.geometry import pose_distance
from fsel.problem import Problem

BLURRED = 0.5  # of its neighbours' median sharpness
WINDOW = 5  # neighbours on either side
NEAR = 4  # frames closest to a pick by pose, of which the sharpest may stand in for it
SHARPER = 1.3  # times the pick's sharpness that it must have

SharpnessOf = Callable[[np.ndarray], np.ndarray]
"""(n,) int64 frames -> (n,) sharpness of each, comparable within a call."""


def relative_sharpness(sharpness: np.ndarray, rows: np.ndarray | None = None) -> np.ndarray:
    """Sharpness over the median of up to ten neighbours in the sequence; 1 where that is 0.

    Args:
        sharpness: (N,) of frames in capture order; NaN where it is not known.
        rows: (n,) of the frames that are asked for, at each of which it and a neighbour's are
            known; all N without.

    Returns:
        (n,) float64.
    """
    rows = np.arange(len(sharpness)) if rows is None else rows
    around = np.pad(sharpness.astype(float), WINDOW, constant_values=np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(around, 2 * WINDOW + 1)[rows]
    typical = np.nanmedian(np.delete(windows, WINDOW, axis=1), axis=1)
    return np.divide(sharpness[rows], typical, out=np.ones(len(rows)), where=typical > 0)


def exchanged(problem: Problem, picks: np.ndarray, sharpness_of: SharpnessOf) -> np.ndarray:
    """Picks, of which each blurred one is exchanged for the sharpest of the frames beside it.

    A pick is blurred that is less than half as sharp as its neighbours that may be selected. Frames
    that are always to be selected stay.

    Args:
        problem: the selection problem; no frame comes but its candidates.
        picks: (K,) int64 candidates.
        sharpness_of: asked once, for the picks and the frames around them.

    Returns:
        (K,) int64: a frame that comes has the place of the one that left.
    """
    pool = problem.candidates
    places, near = np.searchsorted(pool, picks), _near(problem, picks)
    window = np.clip(places[:, None] + np.arange(-WINDOW, WINDOW + 1), 0, len(pool) - 1)
    asked = np.unique(np.concatenate([window.ravel(), near.ravel()]))
    sharpness = np.full(len(pool), np.nan)
    sharpness[asked] = sharpness_of(pool[asked])
    blurred = (relative_sharpness(sharpness, places) < BLURRED) & ~np.isin(picks, problem.given)
    out = picks.copy()
    for at in np.flatnonzero(blurred):
        free = near[at][~np.isin(pool[near[at]], out)]
        if not len(free):
            continue
        best = free[np.argmax(sharpness[free])]
        if sharpness[best] >= SHARPER * sharpness[places[at]]:
            out[at] = pool[best]
    return out


def _near(problem: Problem, picks: np.ndarray) -> np.ndarray:
    """(K, n) rows of the candidates closest to each pick by pose, itself left out."""
    capture, pool = problem.capture, problem.candidates
    distance = pose_distance(
        capture.centers[picks], capture.axes[picks], capture.centers[pool], capture.axes[pool]
    )
    distance[np.arange(len(picks)), np.searchsorted(pool, picks)] = np.inf
    return np.argsort(distance, axis=1, kind="stable")[:, : min(NEAR, len(pool) - 1)]
