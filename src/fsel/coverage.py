"""How well picked frames cover the target views, and what each pick adds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.capture import Capture, Views
from fsel.geometry import pose_distance
from fsel.selector import coverage_kernel

BLURRED = 0.5  # of its neighbours' median sharpness
WINDOW = 5  # neighbours on either side
ENOUGH = 0.95  # of what all frames cover


@dataclass(frozen=True)
class Coverage:
    """Coverage by picks in order.

    A view is covered to the share exp(-d / h) / exp(-d* / h) that its closest picked frame reaches
    of its closest frame at all: d is the pose distance, h the view's scale in
    `fsel.selector.coverage_kernel`. Coverage is the mean over the views; all frames together
    give 1.

    Attributes:
        curve: (k,) coverage after each pick, rising.
        gain: (k,) what each pick added.
        nearest_view: (k,) int64 the target view that each pick is closest to.
        left: (n,) what each frame of the pool would still add after the last pick.
    """

    curve: np.ndarray
    gain: np.ndarray
    nearest_view: np.ndarray
    left: np.ndarray


def coverage_of(capture: Capture, views: Views, pool: np.ndarray, picks: np.ndarray) -> Coverage:
    """Coverage of target views by picked frames.

    Args:
        capture: the capture.
        views: T target views.
        pool: (n,) frames that could be picked, ascending.
        picks: (k,) of them, in pick order.
    """
    closeness = coverage_kernel(capture.centers[pool], capture.axes[pool], views)
    rows = np.searchsorted(pool, picks)
    share = closeness / closeness.max(axis=0)
    reached = np.maximum.accumulate(share[rows], axis=0)
    curve = reached.mean(axis=1)
    return Coverage(
        curve=curve,
        gain=np.diff(curve, prepend=0.0),
        nearest_view=np.argmax(closeness[rows], axis=1),
        left=np.maximum(share - reached[-1], 0).mean(axis=1),
    )


def enough(curve: np.ndarray) -> int:
    """The least number of picks that reaches 95 % coverage; all of them where none does."""
    reached = np.flatnonzero(curve >= ENOUGH)
    return int(reached[0]) + 1 if len(reached) else len(curve)


def relative_sharpness(sharpness: np.ndarray) -> np.ndarray:
    """(N,) sharpness over the median of up to ten neighbours in the sequence; 1 where that is 0."""
    n = len(sharpness)
    windows = (
        sharpness[[j for j in range(i - WINDOW, i + WINDOW + 1) if 0 <= j < n and j != i]]
        for i in range(n)
    )
    typical = np.array([np.median(window) for window in windows])
    return np.divide(sharpness, typical, out=np.ones(n), where=typical > 0)


def closest_pick(capture: Capture, picks: np.ndarray) -> np.ndarray:
    """(N,) for every frame the pick with the closest pose."""
    distance = pose_distance(
        capture.centers, capture.axes, capture.centers[picks], capture.axes[picks]
    )
    return picks[np.argmin(distance, axis=1)]
