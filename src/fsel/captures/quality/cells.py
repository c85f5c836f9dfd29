"""Detail and colour of an image, in cells of a grid; clipped pixels are unknown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

SIDE = 480  # pixels of the longer side of the images that are measured
CELL = 24  # pixels of a cell's side
GRID = SIDE // CELL
DARK, BRIGHT = 4, 250  # grey level up to which, and level of a channel from which, it is clipped
KERNELS = [  # second differences along a line, across it and along both diagonals
    np.array(rows, np.float32)
    for rows in (
        [[0, 0, 0], [-1, 2, -1], [0, 0, 0]],
        [[0, -1, 0], [0, 2, 0], [0, -1, 0]],
        [[-1, 0, 0], [0, 2, 0], [0, 0, -1]],
        [[0, 0, -1], [0, 2, 0], [-1, 0, 0]],
    )
]
GAIN = 6.0  # variance of a kernel's response to noise of variance 1
NOISE = 5  # per cent of the cells, the smoothest, whose high frequencies are taken for noise
LEAST_VARIANCE = 16.0  # of the grey levels of a cell that shows something
WHOLE = 0.95  # share of a cell that is not clipped, for its color: the clipped part is brighter
CONTRAST = 4.0  # times the noise's variance that it has at least
LEAST_CELLS = 5  # that show something, of a frame that is judged


@dataclass(frozen=True)
class Cells:
    """Cells of N images, on a grid that the largest fills; zeros beyond an image's edge.

    Energy is the mean square of the second differences. The variance is that of the grey levels of
    a cell and those around it, which strong motion leaves; 0 where nothing is known of its detail.
    Both are without those of noise.
    """

    energy: np.ndarray  # (N, 4, GRID, GRID) float32, in four directions
    variance: np.ndarray  # (N, GRID, GRID) float32
    color: np.ndarray  # (N, 3, GRID, GRID) float32 mean RGB; 0 where some pixels are clipped

    @classmethod
    def of(cls, images: Sequence[tuple]) -> Cells:
        """Cells of images, each as `measured` returned them."""
        return cls(*(np.array(part) for part in zip(*images, strict=True)))

    def at(self, pixels: np.ndarray, scale: np.ndarray) -> np.ndarray:
        """(L,) numbers of the cells, row by row, at (L, 2) pixels of images reduced by (L,)."""
        place = np.clip(np.asarray(pixels * scale[:, None] // CELL, np.int64), 0, GRID - 1)
        return place[:, 1] * GRID + place[:, 0]


def measured(image: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Energy, variance and colour of an (h, w, 3) uint8 RGB image, see `Cells`."""
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32)
    red, green, blue = cv2.split(image)  # NumPy's maximum over them takes ten times as long
    white = cv2.max(cv2.max(red, green), blue) >= BRIGHT
    unknown = cv2.dilate((white | (grey <= DARK)).astype(np.uint8), np.ones((7, 7), np.uint8))
    valid = 1 - unknown.astype(np.float32)
    weight = _means(valid)
    known = weight > 0.5

    def mean(values: np.ndarray) -> np.ndarray:
        return _means(values * valid) / np.maximum(weight, 1e-3)

    variance = _spread(*(_means(values * valid) * known for values in (1.0, grey, grey * grey)))
    responses = (
        cv2.filter2D(grey, -1, kernel, borderType=cv2.BORDER_REFLECT) for kernel in KERNELS
    )
    energy = np.array([mean(response**2) for response in responses])
    planes = [mean(plane.astype(np.float32)) for plane in (red, green, blue)]
    color = np.array(planes) * (weight > WHOLE)
    noise = np.zeros(len(KERNELS), np.float32)
    if known.any():
        noise = np.percentile(energy[:, known], NOISE, axis=1).astype(np.float32)
    level = noise.mean() / GAIN
    shows = known & (variance > max(LEAST_VARIANCE, CONTRAST * level))
    energy = (energy - noise[:, None, None]) * shows
    return _padded(energy), _padded((variance - level) * shows), _padded(color)


def sharpness(cells: Cells) -> np.ndarray:
    """Return (N, 4) log of high frequencies over contrast, by direction, which motion lowers along
    it and a gain leaves; NaN where a frame shows little."""
    contrast = cells.variance.sum(axis=(1, 2))[:, None]
    ratio = cells.energy.sum(axis=(2, 3)) / np.maximum(contrast, LEAST_VARIANCE)
    enough = (cells.variance > 0).sum(axis=(1, 2)) >= LEAST_CELLS
    return np.where(enough[:, None], np.log(np.maximum(ratio, 1e-4)), np.nan)


def _means(values: np.ndarray) -> np.ndarray:
    """Return (gh, gw) means of the whole cells of (h, w) values."""
    height, width = (n // CELL for n in values.shape)
    if not height * width:
        return np.zeros((height, width), np.float32)
    whole = values[: height * CELL, : width * CELL]
    return cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA)


def _spread(weight: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(gh, gw) variance over each cell and those around it, of weighted means of two powers."""
    if not weight.size:
        return weight
    total, *sums = (
        cv2.boxFilter(np.float32(part), -1, (3, 3), borderType=cv2.BORDER_CONSTANT)
        for part in (weight, first, second)
    )
    mean, square = (part / np.maximum(total, 1e-3) for part in sums)
    return np.maximum(square - mean**2, 0)


def _padded(values: np.ndarray) -> np.ndarray:
    """Return (..., GRID, GRID) the cells in the corner of a full grid."""
    out = np.zeros((*values.shape[:-2], GRID, GRID), np.float32)
    out[..., : values.shape[-2], : values.shape[-1]] = values
    return out
