"""Detail that frames lack, by three references."""

from __future__ import annotations

import numpy as np

from fsel.captures.quality.cells import LEAST_CELLS, Cells
from fsel.captures.quality.grouped import quantile_of

BESIDE = 2.5  # times less detail than the frames beside it show: 2 to 3 pixels of motion of 480
AT_POINTS = 6.0  # times less than its points' neighbourhoods show in the sharpest tenth
OF_CAPTURE = 6.0  # times less than the sharpest tenth of the frames
SHARP = 0.9  # quantile of the detail that sharp frames show
LEAST_TRACK = 4  # frames that see a point whose detail is compared
LEAST_POINTS = 20  # of a frame that is compared by them


def beside(sharpness: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Times that the frames beside each show as much detail, along the direction that lost most.

    Args:
        sharpness: (N, 4) see `fsel.captures.quality.cells.sharpness`.
        near: (N, m) frames beside each.

    Returns:
        (N,) 1 for as much as the second sharpest of them, since a burst blurs some; NaN where it
        is unknown.
    """
    ordered = np.sort(np.nan_to_num(sharpness[near], nan=-np.inf), axis=1)
    usual = ordered[:, -2] if near.shape[1] > 1 else np.full_like(sharpness, np.nan)
    return np.exp(np.where(np.isfinite(usual), usual - sharpness, np.nan).max(axis=1))


def of_capture(sharpness: np.ndarray) -> np.ndarray:
    """(N,) times that the capture's sharpest tenth shows as much detail, see `beside`."""
    known = ~np.isnan(sharpness).any(axis=1)
    if not known.any():
        return np.full(len(sharpness), np.nan)
    return np.exp((np.quantile(sharpness[known], SHARP, axis=0) - sharpness).max(axis=1))


def at_points(cells: Cells, cell: np.ndarray, point: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """Times that the places of a frame's points show as much detail in the sharpest frames.

    A place's reference is what it shows in the sharpest tenth of the frames that see it, and a
    frame's value the median over its places. Noise raises the reference of every place, so the
    sharpest tenth of the frames has the value 1.

    Args:
        cells: of N frames.
        cell: (L,) cell of each observation, see `Cells.at`.
        point, frame: (L,) its point and its frame.

    Returns:
        (N,) NaN for frames with few places.
    """
    count = len(cells.variance)
    variance = cells.variance.reshape(count, -1)[frame, cell]
    enough = np.bincount(point[variance > 0], minlength=point.max(initial=-1) + 1) >= LEAST_TRACK
    use = (variance > 0) & enough[point]
    point, frame, cell, variance = point[use], frame[use], cell[use], variance[use]
    many = np.bincount(frame, minlength=count) >= LEAST_POINTS
    many &= (cells.variance > 0).sum(axis=(1, 2)) >= LEAST_CELLS
    if not many.any():
        return np.full(count, np.nan)
    lost = []
    for energy in cells.energy.reshape(count, 4, -1).transpose(1, 0, 2):
        detail = np.log(np.maximum(energy[frame, cell] / variance, 1e-3))
        sharp = quantile_of(detail, point, len(enough), SHARP)
        own = quantile_of(detail - sharp[point], frame, count, 0.5)
        lost.append(np.quantile(own[many], SHARP) - own)
    return np.where(many, np.exp(np.max(lost, axis=0)), np.nan)
