"""From raw files to the canonical capture: order, sizes, undistortion, resizing; once, here."""

from __future__ import annotations

import logging
from pathlib import Path

import cv2
import numpy as np

from fsel.capture import Capture, SparsePoints
from fsel.layouts import images
from fsel.layouts.base import Layout, RawCapture, natural
from fsel.recording import Camera

ASPECT_TOLERANCE = 0.01
ROUNDING = 1e-3
HALF = np.array([0.0, 0.0, 0.5, 0.5])  # OpenCV puts the top-left pixel's centre at (0, 0)
log = logging.getLogger(__name__)


def ingest(
    raw: RawCapture, layout: Layout, folder: Path, long_side: int, *, lazy: bool = False
) -> Capture:
    """Open, undistort and resize every image of a raw capture.

    Args:
        raw: what the layout's reader found.
        layout: the reader.
        folder: the capture.
        long_side: pixels of the longer side; smaller images keep their size.
        lazy: open images only when they are asked for, each time anew, and leave masks and
            points out; for those who need poses above all.

    Raises:
        ValueError: for an unreadable image, sizes that contradict the camera, or a bad pose; the
            message names the file.
    """
    for name, reason in sorted(raw.dropped.items()):
        log.info("%s: left out %s: %s", folder, name, reason)
    source = f"{layout.name} at {folder}"
    if len(set(raw.names)) != len(raw.names):
        twice = sorted({n for n in raw.names if raw.names.count(n) > 1})
        raise ValueError(f"{source}: duplicate frame names {twice[:3]}")
    order = natural_order(raw)
    opened = _unopened if lazy else _opened
    frames, intrinsics, masks = opened(raw, order, long_side)
    return Capture(
        names=tuple(raw.names[i] for i in order),
        world_to_camera=_rigid(np.asarray(raw.world_to_camera, np.float64)[order]),
        intrinsics=intrinsics,
        images=frames,
        sequences=tuple(raw.sequences[i] for i in order),
        points=None if lazy else _renumbered(raw, order),
        masks=masks,
        source=source,
    )


def natural_order(raw: RawCapture) -> list[int]:
    """Rows of a raw capture in the canonical order: natural order of the names."""
    return sorted(range(len(raw.names)), key=lambda i: natural(raw.names[i]))


def _opened(raw: RawCapture, order: list[int], long_side: int):
    """Images, intrinsics and masks of all frames."""
    frames, intrinsics, masks = [], [], []
    lenses: dict[tuple, _Lens] = {}
    for i in order:
        image = images.load(raw.images[i])
        key = (raw.cameras[i], image.shape)
        if key not in lenses:
            lenses[key] = _Lens(raw.cameras[i], image.shape, long_side, raw.images[i])
        frames.append(lenses[key].straighten(image))
        intrinsics.append(lenses[key].intrinsics)
        if raw.masks:
            mask = images.load(raw.masks[i], cv2.IMREAD_GRAYSCALE)
            masks.append(lenses[key].straighten((mask == 255).astype(np.uint8) * 255) > 127)
        _same_size(raw.images[i], frames[-1].shape[1::-1], frames[0].shape[1::-1])
    return np.stack(frames), np.array(intrinsics), np.stack(masks) if masks else None


def _unopened(raw: RawCapture, order: list[int], long_side: int):
    """A lazy stack of images, intrinsics at the size that the cameras state, no masks."""
    lenses = {}
    for i in order:
        camera = raw.cameras[i]
        if camera not in lenses:
            lenses[camera] = _Lens(camera, (camera.height, camera.width), long_side, raw.images[i])
        _same_size(raw.images[i], lenses[camera].size, lenses[raw.cameras[order[0]]].size)
    stack = LazyImages(
        files=[raw.images[i] for i in order],
        cameras=[raw.cameras[i] for i in order],
        size=lenses[raw.cameras[order[0]]].size,
    )
    return stack, np.array([lenses[raw.cameras[i]].intrinsics for i in order]), None


def _same_size(file: Path, size: tuple[int, int], first: tuple[int, int]) -> None:
    if tuple(size) != tuple(first):
        raise ValueError(
            f"{file}: {tuple(size)} pixels after ingestion, others {tuple(first)}; a capture's "
            "images must share one size"
        )


class LazyImages:
    """A capture's images, opened, undistorted and resized when indexed.

    Args:
        files: N image files.
        cameras: one a file.
        size: (width, height) that every image is brought to.
    """

    dtype = np.dtype(np.uint8)
    ndim = 4

    def __init__(self, files: list[Path], cameras: list[Camera], size: tuple[int, int]) -> None:
        self._files, self._cameras, self._size = files, cameras, size
        self.shape = (len(files), size[1], size[0], 3)

    def __len__(self) -> int:
        return len(self._files)

    def __getitem__(self, rows) -> np.ndarray:
        """(h, w, 3) for a number, (n, h, w, 3) for a slice or an array of numbers."""
        asked = np.arange(len(self))[rows]
        if asked.ndim == 0:
            return self._open(int(asked))
        return np.array([self._open(i) for i in asked], np.uint8).reshape(-1, *self.shape[1:])

    def __array__(self, dtype=None, copy=None) -> np.ndarray:
        return self[:] if dtype is None else self[:].astype(dtype)

    def _open(self, row: int) -> np.ndarray:
        image = images.load(self._files[row])
        lens = _Lens(self._cameras[row], image.shape, max(self._size), self._files[row])
        straight = lens.straighten(image)
        if lens.size == self._size:
            return straight
        # images smaller than their camera states, or reduced by a factor that is not whole
        return cv2.resize(straight, self._size, interpolation=cv2.INTER_AREA)


def _rigid(poses: np.ndarray) -> np.ndarray:
    """Poses whose rotations, printed with few digits, are made orthonormal again.

    Only what rounding explains is mended: anything further off is left for the capture to refuse.
    """
    if not np.isfinite(poses).all():
        return poses
    left, stretch, right = np.linalg.svd(poses[:, :, :3])
    rounded = np.abs(stretch - 1).max(axis=1) < ROUNDING
    mended = np.where(rounded[:, None, None], left @ right, poses[:, :, :3])
    return np.concatenate([mended, poses[:, :, 3:]], axis=2)


def _renumbered(raw: RawCapture, order: list[int]) -> SparsePoints | None:
    points = raw.points() if raw.points else None
    if points is None:
        return None
    position = np.empty(len(order), np.int64)
    position[order] = np.arange(len(order))
    return SparsePoints(points.xyz, points.rgb, points.track_point, position[points.track_frame])


class _Lens:
    """Undistortion and resizing of one camera's images at one true size."""

    def __init__(self, camera: Camera, shape: tuple, long_side: int, file: Path) -> None:
        height, width = shape[:2]
        across, down = width / camera.width, height / camera.height
        if abs(across / down - 1) > ASPECT_TOLERANCE:
            raise ValueError(
                f"{file}: image is {width}x{height} but its camera {camera.width}x{camera.height}; "
                "the two scales may differ by 1 % at most"
            )
        k = _pinhole(camera, file) * [across, down, across, down]
        extra = np.array(camera.params[DISTORTED.get(camera.model, len(camera.params)) :])
        self._maps = None
        if np.any(extra):
            k, self._maps = _undistortion(camera.model, k, extra, (width, height))
        scale = min(1.0, long_side / max(width, height))
        self.size = (max(1, round(width * scale)), max(1, round(height * scale)))
        self._same = self.size == (width, height)
        factors = np.array(self.size) / (width, height)
        self.intrinsics = k * np.tile(factors, 2)

    def straighten(self, image: np.ndarray) -> np.ndarray:
        """The undistorted, resized image."""
        if self._maps is not None:
            image = cv2.remap(image, *self._maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        if self._same:
            return np.ascontiguousarray(image)
        return cv2.resize(image, self.size, interpolation=cv2.INTER_AREA)


DISTORTED = {"OPENCV": 4, "OPENCV_FISHEYE": 4, "SIMPLE_RADIAL": 3, "RADIAL": 3}
"""Models with distortion, and where its coefficients begin."""


def _pinhole(camera: Camera, file: Path) -> np.ndarray:
    """fx, fy, cx, cy of a camera model."""
    if camera.model in ("PINHOLE", "OPENCV", "OPENCV_FISHEYE"):
        return np.array(camera.params[:4], float)
    if camera.model in ("SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL"):
        f, cx, cy = camera.params[:3]
        return np.array([f, f, cx, cy], float)
    allowed = "SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE"
    raise ValueError(f"{file}: camera model {camera.model} is not supported; allowed: {allowed}")


def _undistortion(model: str, k: np.ndarray, extra: np.ndarray, size: tuple[int, int]):
    """New pinhole intrinsics that leave no invalid border, and remap tables."""
    matrix = _matrix(k - HALF)
    if model == "OPENCV_FISHEYE":
        new = cv2.fisheye.estimateNewCameraMatrixForUndistortRectify(
            matrix, extra, size, np.eye(3), balance=0.0
        )
        maps = cv2.fisheye.initUndistortRectifyMap(
            matrix, extra, np.eye(3), new, size, cv2.CV_32FC1
        )
    else:
        coefficients = np.zeros(4)
        coefficients[: len(extra)] = extra
        new, _ = cv2.getOptimalNewCameraMatrix(matrix, coefficients, size, 0.0)
        maps = cv2.initUndistortRectifyMap(matrix, coefficients, np.eye(3), new, size, cv2.CV_32FC1)
    straight = np.array([new[0, 0], new[1, 1], new[0, 2], new[1, 2]]) + HALF
    return straight, maps


def _matrix(k: np.ndarray) -> np.ndarray:
    return np.array([[k[0], 0, k[2]], [0, k[1], k[3]], [0, 0, 1.0]])
