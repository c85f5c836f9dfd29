"""Frames that show the same as the one before them: a pause of the camera, or copies."""

from __future__ import annotations

import numpy as np

STILL = 0.004  # of the longer side that the image moves: 2 pixels at 480


def duplicates(thumbnails: np.ndarray) -> np.ndarray:
    """Find which frames of a sequence to keep, so that neighbours differ.

    Args:
        thumbnails: see `movements`.

    Returns:
        (n,) bool, true for frames to keep; the first is always one.
    """
    return movements(thumbnails) >= STILL


def movements(thumbnails: np.ndarray) -> np.ndarray:
    """Movement of each frame of a sequence since the last one that moved, see `moved`.

    A frame that moved less than `STILL` is not compared with, so that a slow film goes on.

    Args:
        thumbnails: (n, h, w) grey images in their order in time, reduced by averaging; a longer
            side of about 100 pixels is enough.

    Returns:
        (n,) shares of the longer side, infinite for the first frame.
    """
    movement = np.full(len(thumbnails), np.inf)
    last = 0
    for at in range(1, len(thumbnails)):
        movement[at] = moved(thumbnails[last], thumbnails[at])
        last = at if movement[at] >= STILL else last
    return movement


def moved(first: np.ndarray, second: np.ndarray) -> float:
    """Distance that the content of (h, w) grey images moved between two.

    The root of the mean squared difference over that of the gradient along a direction: the optical
    flow constraint (Horn and Schunck, 1981) for one motion of the whole image. Brightness and
    contrast are evened first. Motions beyond the texture's scale are underestimated.

    Returns:
        Share of the longer side; 0 for two blank images, infinite for one.
    """
    a, b = _evened(first), _evened(second)
    change = ((a - b) ** 2).mean()
    slope = sum((np.diff(a + b, axis=axis) ** 2).mean() for axis in (0, 1)) / 8
    if not a.any() or not b.any() or slope == 0:
        return 0.0 if change == 0 else float("inf")
    return float(np.sqrt(change / slope)) / max(first.shape)


def _evened(image: np.ndarray) -> np.ndarray:
    """The image with a mean of 0 and a variance of 1; zeros for a blank one."""
    centred = image - image.mean(dtype=np.float64)
    spread = centred.std()
    return centred / spread if spread > 1e-9 * np.abs(image).max(initial=1) else 0 * centred
