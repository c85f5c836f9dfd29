"""Faults that a frame's pixels show: blur, exposure, no movement."""

from __future__ import annotations

import numpy as np

from fsel.captures.quality.cells import GRID, LEAST_CELLS, Cells
from fsel.core.points import quantile_of

BESIDE = 4.0  # times less detail than the frames beside it show: at 2.5, gaps cost more than blur
AT_POINTS = 6.0  # times less than its points' neighbourhoods show in the sharpest tenth
SAME = 0.5  # correlation of the grey levels of two frames that show the same, at least
SHARP = 0.9  # quantile of the detail that sharp frames show
LEAST_TRACK = 4  # frames that see a point whose detail is compared
LEAST_POINTS = 20  # of a frame that is compared by them
BRIGHTER = np.log(1.4)  # gain over the capture's middle one that is usual, at most
SPREAD = 4.0  # times what is usual in the capture that it may be
ROUNDS = 4  # of the points' colors by the frames' gains, and the other way round
STILL = 0.004  # of the longer side that the image moves: 2 pixels at 480


def blur_beside(sharpness: np.ndarray, near: np.ndarray, same: np.ndarray) -> np.ndarray:
    """Return (N,) times that the (N, m) frames beside each show as much detail, (N, 4)
    `cells.sharpness`, along the direction that lost most; NaN unless two of them, by (N, m) bool,
    show the same. The second sharpest counts, since a burst blurs some."""
    shown = np.where(same[..., None], np.nan_to_num(sharpness[near], nan=-np.inf), -np.inf)
    ordered = np.sort(shown, axis=1)
    usual = ordered[:, -2] if near.shape[1] > 1 else np.full_like(sharpness, np.nan)
    return np.exp(np.where(np.isfinite(usual), usual - sharpness, np.nan).max(axis=1))


def same_content(cells: Cells, near: np.ndarray) -> np.ndarray:
    """Return (N, m) bool, which of the (N, m) frames beside each show the same: their grey levels,
    cell by cell, correlate, which blur leaves."""
    grey = cells.color.mean(axis=1).reshape(len(near), -1)
    grey[(cells.color == 0).any(axis=1).reshape(grey.shape)] = 0

    def alike(i: int, j: int) -> bool:
        known = (grey[i] > 0) & (grey[j] > 0)
        if not known.any():
            return False
        one, other = (values[known] - values[known].mean() for values in (grey[i], grey[j]))
        return bool(one @ other > SAME * np.sqrt((one @ one) * (other @ other)))

    return np.array([[alike(i, j) for j in row] for i, row in enumerate(near.tolist())])


def blur_at_points(
    cells: Cells, cell: np.ndarray, point: np.ndarray, frame: np.ndarray
) -> np.ndarray:
    """(N,) times that a frame's points show as much detail in the sharpest tenth of their frames.

    A frame's value is the median over its places, NaN for few. Noise raises the reference of every
    place, so the sharpest tenth of the frames has the value 1.

    `cell`, `point`, `frame` are (L,) of each observation, see `Cells.at`.
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


def gains_at_points(
    cells: Cells, cell: np.ndarray, point: np.ndarray, frame: np.ndarray
) -> np.ndarray:
    """Return the gain of each frame's channels over the other frames that see the same points.

    The logarithm of a color is a point's plus a frame's, fitted by medians in turn (Tukey's median
    polish, 1977). Arguments are those of `blur_at_points`.

    Returns:
        (N, 3) natural logarithm of the gains; NaN where unknown.
    """
    count, gains = len(cells.color), []
    for values in cells.color.reshape(count, 3, GRID * GRID).transpose(1, 0, 2):
        color = values[frame, cell]
        use = color > 0
        rows, of, log = point[use], frame[use], np.log(color[use])
        gain = np.zeros(count)
        for _ in range(ROUNDS):
            true = quantile_of(log - gain[of], rows, point.max(initial=-1) + 1, 0.5)
            gain = quantile_of(log - true[rows], of, count, 0.5)
        gains.append(gain)
    return np.array(gains).T


def gains_beside(cells: Cells, near: np.ndarray) -> np.ndarray:
    """Return (N, 3) the same over the (N, m) frames beside each, by the color of whole images."""
    known = cells.color > 0
    total, size = (np.where(known, x, 0).sum(axis=(2, 3)) for x in (cells.color, known))
    color = np.ma.log(np.ma.masked_equal(total, 0) / np.maximum(size, 1))
    return (color - np.ma.median(color[near], axis=1)).filled(np.nan)


def unusual_gains(gains: np.ndarray) -> tuple[np.ndarray, float]:
    """(N,) factors by which (N, 3) log gains are too bright or dark, and the limit."""
    known = np.isfinite(gains).all(axis=1)
    if not known.any():
        return np.full(len(gains), np.nan), 1.0
    brightness = np.abs((gains - np.median(gains[known], axis=0)).mean(axis=1))
    limit = max(BRIGHTER, SPREAD * float(np.median(brightness[known])))
    return np.exp(brightness), float(np.exp(limit))


def duplicates(thumbnails: np.ndarray) -> np.ndarray:
    """Return (n,) bool, which frames of a sequence to keep so that neighbours differ."""
    return movements(thumbnails) >= STILL


def movements(thumbnails: np.ndarray) -> np.ndarray:
    """Return (n,) movements of (n, h, w) grey images of a sequence, some 100 pixels long, since the
    last one that moved by `STILL` or more, see `moved`; infinite for the first."""
    movement = np.full(len(thumbnails), np.inf)
    last = 0
    for at in range(1, len(thumbnails)):
        movement[at] = moved(thumbnails[last], thumbnails[at])
        last = at if movement[at] >= STILL else last
    return movement


def moved(first: np.ndarray, second: np.ndarray) -> float:
    """Return how far the content of two (h, w) grey images moved, as a share of the longer side.

    The root of the mean squared difference over that of the gradient along a direction: the optical
    flow constraint (Horn and Schunck, 1981) for one motion of the whole image. Brightness and
    contrast are evened first. Motions beyond the texture's scale are underestimated.
    """
    a, b = _evened(first), _evened(second)
    change = ((a - b) ** 2).mean()
    slope = sum((np.diff(a + b, axis=axis) ** 2).mean() for axis in (0, 1)) / 8
    if not a.any() or not b.any() or slope == 0:
        return 0.0 if change == 0 else float("inf")
    return float(np.sqrt(change / slope)) / max(first.shape)


def _evened(image: np.ndarray) -> np.ndarray:
    """Return the image with a mean of 0 and a variance of 1; zeros for a blank one."""
    centred = image - image.mean(dtype=np.float64)
    spread = centred.std()
    return centred / spread if spread > 1e-9 * np.abs(image).max(initial=1) else 0 * centred
