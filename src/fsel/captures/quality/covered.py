"""Frames before whose middle something stands that the frames beside them do not show."""

from __future__ import annotations

import numpy as np

MIDDLE = 0.5  # of the width and the height
HIDDEN = 0.9  # share of the points expected there that are hidden, at most
ALIKE = 0.3  # correlation with the colors expected there, from which nothing covers them
LEAST_EXPECTED = 20  # points in the middle of a frame that is judged


def hidden(color: np.ndarray, expected: np.ndarray, observed: np.ndarray) -> float:
    """Share of the points expected in a frame's middle that something hides.

    Points are not found in blurred frames either, nor where the view is another, but then the
    colors of their surroundings still go with those expected.

    Args:
        color: (n, 3) of the frame where the points are expected; 0 where it is unknown.
        expected: (n, 3) color of the points as other frames show them, up to a gain of each
            channel.
        observed: (n,) bool, points that the frame was seen to show.

    Returns:
        0 to 1; 0 where the colors are like those expected, NaN for too few points.
    """
    known = (color > 0).all(axis=1) & np.isfinite(expected).all(axis=1)
    if known.sum() < LEAST_EXPECTED:
        return float("nan")
    shown, usual = (np.log(colors[known]) for colors in (color, expected))
    shown, usual = shown - shown.mean(axis=0), usual - usual.mean(axis=0)
    alike = (shown * usual).sum() > ALIKE * np.linalg.norm(shown) * np.linalg.norm(usual)
    return 0.0 if alike else float((~observed[known]).mean())


def in_the_middle(pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """(n,) bool, which of (n, 2) pixels lie in the middle of an image of (width, height)."""
    half = np.array(size) / 2
    return np.all(np.abs(pixels - half) < MIDDLE * half, axis=1)
