"""Image sharpness: the variance of the Laplacian (paper, section 3.2)."""

from __future__ import annotations

import cv2
import numpy as np

LUMA = np.array([0.299, 0.587, 0.114])


def sharpness(images: np.ndarray) -> np.ndarray:
    """Variance of the Laplacian of every image's luma.

    The Laplacian is the four-neighbour one with mirrored borders, in float64, of luma in [0, 255].

    Args:
        images: (N, h, w, 3) uint8, RGB.

    Returns:
        (N,) float64, squared grey levels; higher is sharper.
    """
    return np.array([cv2.Laplacian(image @ LUMA, cv2.CV_64F).var() for image in images])
