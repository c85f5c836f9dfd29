"""Brightness and tint in which frames show what others show too."""

from __future__ import annotations

import numpy as np

from fsel.captures.quality.cells import GRID, Cells
from fsel.captures.quality.grouped import quantile_of

BRIGHTER = np.log(1.4)  # gain over the capture's middle one that is usual, at most
TINT = np.log(1.2)  # difference of a channel's gain from the mean of the three
SPREAD = 4.0  # times what is usual in the capture that both may be
ROUNDS = 4  # of the points' colors by the frames' gains, and the other way round


def gains_at_points(
    cells: Cells, cell: np.ndarray, point: np.ndarray, frame: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gain of each frame's channels over the other frames that see the same points.

    The logarithm of a color is a point's plus a frame's, fitted by medians in turn (Tukey's median
    polish, 1977).

    Args:
        cells: of N frames.
        cell: (L,) cell of each observation, see `Cells.at`.
        point, frame: (L,) its point and its frame.

    Returns:
        (N, 3) natural logarithm of the gains; NaN for frames without known colors. (M, 3) that of
        the points' colors; NaN for points without.
    """
    count, gains, colors = len(cells.clipped), [], []
    for values in cells.color.reshape(count, 3, GRID * GRID).transpose(1, 0, 2):
        color = values[frame, cell]
        use = color > 0
        rows, of, log = point[use], frame[use], np.log(color[use])
        gain = np.zeros(count)
        for _ in range(ROUNDS):
            true = quantile_of(log - gain[of], rows, point.max(initial=-1) + 1, 0.5)
            gain = quantile_of(log - true[rows], of, count, 0.5)
        gains.append(gain)
        colors.append(true)
    return np.array(gains).T, np.array(colors).T


def gains_beside(cells: Cells, near: np.ndarray) -> np.ndarray:
    """(N, 3) the same over the (N, m) frames beside each, by the color of whole images."""
    known = cells.color > 0
    total, size = (np.where(known, x, 0).sum(axis=(2, 3)) for x in (cells.color, known))
    color = np.ma.log(np.ma.masked_equal(total, 0) / np.maximum(size, 1))
    return (color - np.ma.median(color[near], axis=1)).filled(np.nan)


def unusual(gains: np.ndarray) -> tuple[np.ndarray, float, np.ndarray, float]:
    """(N,) factors by which frames are too bright or dark, and the limit; the same of the tint.

    Args:
        gains: (N, 3) natural logarithm.
    """
    known = np.isfinite(gains).all(axis=1)
    if not known.any():
        return np.full(len(gains), np.nan), 1.0, np.full(len(gains), np.nan), 1.0
    gains = gains - np.median(gains[known], axis=0)
    whole = gains.mean(axis=1)
    brightness, tint = np.abs(whole), np.abs(gains - whole[:, None]).max(axis=1)
    brighter = max(BRIGHTER, SPREAD * float(np.median(brightness[known])))
    tinted = max(TINT, SPREAD * float(np.median(tint[known])))
    return np.exp(brightness), float(np.exp(brighter)), np.exp(tint), float(np.exp(tinted))
