"""A threshold on the normalised correlation of a frame with the last that was kept."""

from __future__ import annotations

import cv2
import numpy as np

from fsel.core.problem import Method, Problem
from fsel.core.subsets import evenly, just_enough
from fsel.selectors.baselines.drift import grey_images

SIDE = (32, 32)  # pixels of the grey images that are correlated


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Lower the threshold as long as k frames or more are kept; of more, evenly spaced ones."""
    grey = [cv2.resize(i, SIDE, interpolation=cv2.INTER_AREA) for i in grey_images(problem)]
    # above 1 every frame is kept
    rows = kept(grey, just_enough(lambda threshold: len(kept(grey, threshold)), -2.0, 2.0, k))
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
