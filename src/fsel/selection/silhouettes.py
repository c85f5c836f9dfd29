"""Silhouettes: where in its images an object is seen."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from fsel.core.capture import Capture
from fsel.selection.focus import Focus, load_white, mask_file


def masked(capture: Capture, frames: np.ndarray, folder: Path) -> np.ndarray:
    """(n, h, w) bool of the object's masks in a folder; a frame without one shows nothing of it.

    Args:
        capture: whose images' size the masks are brought to.
        frames: (n,) of it.
        folder: see `fsel.selection.focus.from_masks`.

    Raises:
        ValueError: for an unreadable mask.
    """
    width, height = capture.size
    shown = np.zeros((len(frames), height, width), bool)
    for at, frame in enumerate(frames):
        if file := mask_file(folder, capture.names[frame]):
            white = load_white(file).astype(np.uint8)
            shown[at] = cv2.resize(white, capture.size, interpolation=cv2.INTER_NEAREST_EXACT) > 0
    return shown


def boxed(capture: Capture, frames: np.ndarray, box: Focus) -> np.ndarray:
    """(n, h, w) bool, the outline of a box; empty where a corner of it lies behind the camera.

    Args:
        capture: the capture.
        frames: (n,) of it.
        box: see `fsel.selection.focus.from_box`.
    """
    width, height = capture.size
    shown = np.zeros((len(frames), height, width), np.uint8)
    for at, frame in enumerate(frames):
        pose, (fx, fy, cx, cy) = capture.world_to_camera[frame], capture.intrinsics[frame]
        x, y, z = (box.corners @ pose[:, :3].T + pose[:, 3]).T
        if np.all(z > 0):
            pixels = np.stack([fx * x / z + cx, fy * y / z + cy], axis=1) - 0.5
            near = np.clip(pixels, -width - height, 2 * (width + height))
            cv2.fillConvexPoly(shown[at], cv2.convexHull(near.round().astype(np.int32)), 1)
    return shown > 0
