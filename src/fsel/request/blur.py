"""Blurred picks are exchanged for sharp frames beside them.

Not in the paper, whose sharpness is one input of many. Motion blurs single frames of a video, and
those beside them serve the same views. What it gains is in docs/experiments.md, "Blur".
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fsel.data.capture import Capture
from fsel.data.geometry import pose_distance
from fsel.data.problem import Problem

NEAR = 4  # frames closest to a pick by pose
SHARPER = 2.5  # times a pick's sharpness that one of them has where the pick is blurred
BLOCK = 1000  # frames whose distances from all others are in memory at once

SharpnessOf = Callable[[np.ndarray], np.ndarray]
"""(n,) int64 frames -> (n,) sharpness of each, comparable within a call."""


def exchanged(problem: Problem, picks: np.ndarray, sharpness_of: SharpnessOf) -> np.ndarray:
    """Picks, of which each blurred one is exchanged for the sharpest of the frames beside it.

    A pick is blurred where one of the four candidates closest to it by pose is 2.5 times as sharp:
    these show much the same. Frames that are always to be selected stay.

    Args:
        problem: the selection problem; no frame comes but its candidates.
        picks: (K,) int64 candidates.
        sharpness_of: called once, for the picks and the frames beside them.

    Returns:
        (K,) int64: a frame that comes has the place of the one that left.
    """
    near = _near(problem.capture, picks, problem.candidates)
    sharpness = _known(problem.capture, picks, near, sharpness_of)
    least = _least(sharpness[picks])
    out = picks.copy()
    for at in np.flatnonzero(~np.isin(picks, problem.given)):
        free = near[at][~np.isin(near[at], out)]
        if len(free) and sharpness[free].max() >= least[at]:
            out[at] = free[np.argmax(sharpness[free])]
    return out


def blurred(capture: Capture, frames: np.ndarray, sharpness_of: SharpnessOf) -> np.ndarray:
    """(n,) bool: one of the four frames closest by pose is 2.5 times as sharp, as in `exchanged`.

    Args:
        capture: whose frames they are.
        frames: (n,) int64.
        sharpness_of: called once, for the frames and those beside them.
    """
    every = np.arange(len(capture))
    blocks = np.array_split(frames, len(frames) // BLOCK + 1)
    near = np.concatenate([_near(capture, block, every) for block in blocks])
    sharpness = _known(capture, frames, near, sharpness_of)
    return sharpness[near].max(axis=1, initial=0.0) >= _least(sharpness[frames])


def _near(capture: Capture, frames: np.ndarray, pool: np.ndarray) -> np.ndarray:
    """(n, m) frames of a pool closest to each of some of them by pose, itself left out."""
    distance = pose_distance(
        capture.centers[frames], capture.axes[frames], capture.centers[pool], capture.axes[pool]
    )
    distance[np.arange(len(frames)), np.searchsorted(pool, frames)] = np.inf
    return pool[np.argsort(distance, axis=1, kind="stable")[:, : min(NEAR, len(pool) - 1)]]


def _known(
    capture: Capture, frames: np.ndarray, near: np.ndarray, sharpness_of: SharpnessOf
) -> np.ndarray:
    """(N,) sharpness of frames and of those beside them; NaN for others."""
    looked_at = np.union1d(frames, near)
    sharpness = np.full(len(capture), np.nan)
    sharpness[looked_at] = sharpness_of(looked_at)
    return sharpness


def _least(sharpness: np.ndarray) -> np.ndarray:
    """The sharpness beside a frame that tells that it is blurred; of a blank one, any."""
    return np.maximum(SHARPER * sharpness, np.finfo(float).tiny)
