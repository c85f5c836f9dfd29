"""Service: how well picked frames cover the target views, and what each pick adds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.core.geometry import pose_distance
from fsel.features.conditioned import closeness, look_distance

RANKS = 8  # closest frames that count for a view
SHARES = 0.5 ** np.arange(RANKS)


@dataclass(frozen=True)
class Service:
    """Service by picks in order.

    A frame is as close to a view as `fsel.features.conditioned` says. A view's closest picked
    frame counts in full, the second closest half, the next a quarter, and so on: parallax needs
    several, and each further one says less. Service is that sum over the same of all frames,
    averaged over the views; all frames together give 1.

    Attributes:
        curve: (k,) service after each pick, never falling.
        gain: (k,) what each pick added.
        nearest_view: (k,) int64 the target view that each pick is closest to.
    """

    curve: np.ndarray
    gain: np.ndarray
    nearest_view: np.ndarray


def service_of(capture: Capture, views: Views, pool: np.ndarray, picks: np.ndarray) -> Service:
    """Service of target views by picked frames.

    Args:
        capture: the capture.
        views: T target views.
        pool: (n,) frames that could be picked, ascending.
        picks: (k,) of them, in pick order.
    """
    close = closeness(look_distance(capture.centers[pool], capture.axes[pool], views))
    rows = np.searchsorted(pool, picks)
    whole = SHARES @ _closest(np.concatenate([np.zeros((RANKS, len(views))), close]))
    best = np.zeros((RANKS, len(views)))
    curve = np.empty(len(rows))
    for step, row in enumerate(rows):
        best = _closest(np.concatenate([best, close[row, None]]))
        curve[step] = np.mean(SHARES @ best / whole)
    return Service(
        curve=curve,
        gain=np.diff(curve, prepend=0.0),
        nearest_view=np.argmax(close[rows], axis=1),
    )


def _closest(closeness: np.ndarray) -> np.ndarray:
    """(..., RANKS, T) the largest of (..., m, T), falling."""
    return -np.sort(-closeness, axis=-2)[..., :RANKS, :]


def closest_pick(capture: Capture, picks: np.ndarray) -> np.ndarray:
    """(N,) for every frame the pick with the closest pose."""
    distance = pose_distance(
        capture.centers, capture.axes, capture.centers[picks], capture.axes[picks]
    )
    return picks[np.argmin(distance, axis=1)]
