"""Pixels and rays of a camera with distortion, through pycolmap's camera models."""

from __future__ import annotations

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.core.geometry import pixel_centers


def unproject(camera: Camera) -> np.ndarray:
    """(h * w, 3) camera rays with z = 1 through the pixel centres."""
    x, y = pixel_centers(camera.width, camera.height)
    pixels = np.stack([x.ravel(), y.ravel()], axis=1)
    flat = np.asarray(camera.colmap.cam_from_img(pixels))
    return np.column_stack([flat, np.ones(len(flat))])


def project(camera: Camera, points: np.ndarray) -> np.ndarray:
    """(n, 2) pixels of (n, 3) camera points; those behind the camera land far outside."""
    out = np.full((len(points), 2), -1e6)
    ahead = points[:, 2] > 1e-6
    out[ahead] = np.asarray(camera.colmap.img_from_cam(points[ahead]))
    return out
