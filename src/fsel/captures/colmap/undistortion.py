"""Undistortion and resizing: the one place where pixels move.

Cameras put the top-left pixel's centre at (0.5, 0.5), as COLMAP does; OpenCV's tables put it at
(0, 0), half a pixel away. Resizing keeps the corners: every length scales with the image.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np

from fsel.captures.colmap.camera import Camera, pycolmap
from fsel.captures.images.files import Image

ASPECT_TOLERANCE = 0.01
HALF = 0.5
ROWS = 256  # of a table computed at once
BEYOND = 1e9  # pixels, outside of every image
KEPT = 4  # lenses at once: cameras of a capture may be as many as its frames
MASKED_OUT = 127  # of a mask's 0 and 255, after interpolation


def straight(camera: Camera) -> Camera:
    """Return the PINHOLE camera of equal size whose every pixel the distorted image covers:
    COLMAP's undistorted one at the original size, so that images keep one size."""
    model = camera.colmap
    try:
        if not is_straight(camera):
            model = pycolmap.undistort_camera(pycolmap.UndistortCameraOptions(), model)
            model.rescale(camera.width, camera.height)
        return Camera("PINHOLE", camera.width, camera.height, pinhole_of(model))
    except ValueError as error:
        raise ValueError(f"camera model {camera.model} cannot be undistorted") from error


def is_straight(camera: Camera) -> bool:
    """Return whether images need no undistortion; a fisheye without coefficients does."""
    return camera.colmap.is_undistorted() and "FISHEYE" not in camera.model


def pinhole_of(model: pycolmap.Camera) -> tuple[float, ...]:
    """Return the intrinsics fx, fy, cx, cy, of whatever model."""
    k = model.calibration_matrix()
    return (k[0, 0], k[1, 1], k[0, 2], k[1, 2])


def undistortion_maps(
    camera: Camera, pinhole: Camera, size: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Return two (h, w) float32 tables for `cv2.remap` of a straight image's pixels; both cameras
    are stated at one size, and `size` is that of the images."""
    width, height = size
    scale = np.array([width / camera.width, height / camera.height])
    fx, fy, cx, cy = pinhole.params
    x = ((np.arange(width) + HALF) / scale[0] - cx) / fx
    y = ((np.arange(height) + HALF) / scale[1] - cy) / fy
    tables = np.empty((2, height, width), np.float32)
    model = camera.colmap
    for top in range(0, height, ROWS):  # rays of a whole large image would take gigabytes
        rows = y[top : top + ROWS]
        rays = np.ones((len(rows) * width, 3))
        rays[:, 0] = np.tile(x, len(rows))
        rays[:, 1] = np.repeat(rows, width)
        seen = np.asarray(model.img_from_cam(rays)) * scale - HALF
        seen = seen.clip(-BEYOND, BEYOND)  # float32 ends at 3e38, strong distortion later
        tables[:, top : top + ROWS] = seen.T.reshape(2, len(rows), width)
    return tables[0], tables[1]


def working_size(camera: Camera, size: tuple[int, int], long_side: int) -> tuple[int, int]:
    """Return (width, height) that an image of a size is brought to, see `Lens`."""
    width, height = size
    across, down = width / camera.width, height / camera.height
    if abs(across / down - 1) > ASPECT_TOLERANCE:
        raise ValueError(
            f"image is {width}x{height} but its camera {camera.width}x{camera.height}; "
            "the two scales may differ by 1 % at most"
        )
    return _reduced(size, long_side)


def common_frame(cameras: Sequence[Camera], long_side: int) -> tuple[int, int] | None:
    """(width, height) of most cameras, reduced, to crop to if they have several shapes, or None."""
    sizes = Counter((camera.width, camera.height) for camera in cameras)
    shapes = [width / height for width, height in sizes]
    if max(shapes) / min(shapes) - 1 <= ASPECT_TOLERANCE:
        return None
    width, height = sizes.most_common(1)[0][0]
    return _reduced((width, height), long_side)


def _reduced(size: tuple[int, int], long_side: int) -> tuple[int, int]:
    width, height = size
    scale = min(1.0, long_side / max(width, height))
    return max(1, round(width * scale)), max(1, round(height * scale))


class Lens:
    """Undistortion and resizing of a camera's images, to `size` and `intrinsics` fx, fy, cx, cy."""

    def __init__(
        self,
        camera: Camera,
        size: tuple[int, int],
        long_side: int,
        frame: tuple[int, int] | None = None,
    ) -> None:
        """Prepare the tables.

        Args:
            camera: at the size that the dataset states.
            size: (width, height) of the images as they are, of the same shape.
            long_side: longer side of the images to make; smaller ones keep their size.
            frame: (width, height) to crop the images to, in the place of `long_side`.
        """
        self.size = working_size(camera, size, long_side)
        pinhole, stated = straight(camera), (camera.width, camera.height)
        self._maps = None if is_straight(camera) else undistortion_maps(camera, pinhole, size)
        self.intrinsics = np.array(pinhole.params) * np.tile(np.array(self.size) / stated, 2)
        self._window = (slice(None), slice(None))
        if frame is not None:  # the largest middle part that has its shape
            part = np.round(np.array(frame) * np.divide(size, frame).min())
            part = np.maximum(1, part).astype(int)
            start = (np.array(size) - part) // 2
            across, down = (slice(a, a + n) for a, n in zip(start, part, strict=True))
            self._window, self.size = (down, across), frame
            focal, center = np.array(pinhole.params).reshape(2, 2) * size / stated
            self.intrinsics = np.concatenate([focal, center - start]) * np.tile(frame / part, 2)
        self._same = self.size == size

    def straighten(self, image: np.ndarray, border: int = cv2.BORDER_REPLICATE) -> np.ndarray:
        """Return the undistorted (h, w) or (h, w, 3) uint8 image, reduced by area means."""
        if self._maps is not None:
            image = cv2.remap(image, *self._maps, cv2.INTER_LINEAR, borderMode=border)
        image = image[self._window]
        if self._same:
            return np.ascontiguousarray(image)
        return cv2.resize(image, self.size, interpolation=cv2.INTER_AREA)

    def straighten_mask(self, mask: np.ndarray) -> np.ndarray:
        """Return the same for a (h, w) bool mask; what the image does not show is masked out."""
        grey = self.straighten(mask.astype(np.uint8) * 255, cv2.BORDER_CONSTANT)
        return grey > MASKED_OUT


class Lenses:
    """Lenses of a capture's cameras, made when an image is opened; a few are kept, see `Lens`."""

    def __init__(self, long_side: int, frame: tuple[int, int] | None = None) -> None:
        self.long_side = long_side
        self._of = lru_cache(KEPT)(lambda camera, size: Lens(camera, size, long_side, frame))

    def of(self, camera: Camera, image: np.ndarray, file: Image) -> Lens:
        """Return the lens of an opened image; errors name its file."""
        try:
            return self._of(camera, image.shape[1::-1])
        except ValueError as error:
            raise ValueError(f"{file}: {error}") from error
