"""Frames before whose middle something stands that the frames beside them do not show."""

from __future__ import annotations

import numpy as np

MIDDLE = 0.5  # of the width and the height
HIDDEN = 2 / 3  # share of the points expected there that are hidden, at most
OTHER = np.log(1.5)  # difference of a channel's logarithm from the color that a point has elsewhere
LEAST_EXPECTED = 20  # points in the middle of a frame that is judged


def hidden(color: np.ndarray, expected: np.ndarray, observed: np.ndarray) -> float:
    """Share of the points expected in a frame's middle that something of another color hides.

    Args:
        color: (n, 3) of the frame where the points are expected; 0 where it is unknown.
        expected: (n, 3) color of the points as other frames show them, under the frame's exposure.
        observed: (n,) bool, points that the frame was seen to show.

    Returns:
        0 to 1; NaN for too few points.
    """
    known = (color > 0).all(axis=1) & np.isfinite(expected).all(axis=1)
    if known.sum() < LEAST_EXPECTED:
        return float("nan")
    gap = np.abs(np.log(color[known] / expected[known])).max(axis=1)
    return float(((gap > OTHER) & ~observed[known]).mean())


def in_the_middle(pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """(n,) bool, which of (n, 2) pixels lie in the middle of an image of (width, height)."""
    half = np.array(size) / 2
    return np.all(np.abs(pixels - half) < MIDDLE * half, axis=1)
