"""Image sharpness: the variance of the Laplacian (paper, section 3.2)."""

from __future__ import annotations

import cv2
import numpy as np


def sharpness(images: np.ndarray) -> np.ndarray:
    """Variance of the 3x3 Laplacian of each image's luma.

    Args:
        images: (N, h, w, 3) uint8 RGB.

    Returns:
        (N,) float64, squared grey levels; 0 for a uniform image.
    """
    grey = (cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2GRAY) for image in images)
    return np.array([cv2.Laplacian(g, cv2.CV_64F).var() for g in grey])
