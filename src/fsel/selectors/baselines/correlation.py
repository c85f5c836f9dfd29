"""A threshold on the normalised correlation of a frame with the last that was kept."""

from __future__ import annotations

import cv2
import numpy as np

from fsel.core.problem import Method, Problem
from fsel.core.subsets import evenly
from fsel.selectors.baselines.drift import grey_images

SIDE = (32, 32)  # pixels of the grey images that are correlated
STEPS = 30  # of the bisection of the threshold


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Lower the threshold as long as k frames or more are kept; of more, evenly spaced ones."""
    grey = [cv2.resize(i, SIDE, interpolation=cv2.INTER_AREA) for i in grey_images(problem)]
    low, high = -2.0, 2.0  # above 1 every frame is kept
    for _ in range(STEPS):
        middle = (low + high) / 2
        low, high = (low, middle) if len(kept(grey, middle)) >= k else (middle, high)
    rows = kept(grey, high)
    return problem.observed[rows[evenly(len(rows), k)]]


def kept(grey: list[np.ndarray], threshold: float) -> np.ndarray:
    """Return the rows of images that correlate less than that with the last that was kept."""
    rows = [0]
    for row in range(1, len(grey)):
        if cv2.matchTemplate(grey[row], grey[rows[-1]], cv2.TM_CCOEFF_NORMED)[0, 0] < threshold:
            rows.append(row)
    return np.array(rows)


METHOD = Method(
    "correlation", "Correlation", "observed", nested=False, select=select, reads=("images",)
)
