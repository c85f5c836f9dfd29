"""Image sharpness: the variance of the Laplacian (paper, section 3.2)."""

from __future__ import annotations

import cv2
import numpy as np

LUMA = np.array([0.299, 0.587, 0.114])


def sharpness(images: np.ndarray) -> np.ndarray:
    """Variance of the four-neighbour Laplacian of each image's luma, in float64.

    Args:
        images: (N, h, w, 3) uint8 RGB.

    Returns:
        (N,) float64, squared grey levels; 0 for a uniform image.
    """
    return np.array([variance_of_laplacian(np.asarray(image) @ LUMA) for image in images])


def variance_of_laplacian(grey: np.ndarray) -> float:
    """Sharpness of one (h, w) grey image, uint8 or float64."""
    return float(cv2.Laplacian(grey, cv2.CV_64F).var())
