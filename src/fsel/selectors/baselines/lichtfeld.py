"""The sharpest frame of each window by Tenengrad, as LichtFeld Studio extracts a video's frames."""

from __future__ import annotations

import cv2
import numpy as np

from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.drift import grey_images


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Cut the pool in capture order into k windows as equal as can be; ties go to the lowest."""
    sharp = np.array([tenengrad(image) for image in grey_images(problem)])
    windows = np.array_split(np.arange(len(sharp)), k)
    return problem.observed[[window[np.argmax(sharp[window])] for window in windows]]


def tenengrad(image: np.ndarray) -> int:
    """Return the sum of the squared Sobel gradients of an (h, w) uint8 image."""
    gradients = [cv2.Sobel(image, cv2.CV_16S, *order) for order in ((1, 0), (0, 1))]
    return int(np.square(gradients, dtype=np.int64).sum())


METHOD = Method(
    "lichtfeld", "LichtFeld Studio", "observed", nested=False, select=select, reads=("images",)
)
