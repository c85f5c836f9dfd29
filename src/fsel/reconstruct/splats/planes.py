"""Basis of a plane sweep: frames, depth ranges, planes, and which frames make good partners."""

from __future__ import annotations

from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import distances_from_middle, pixel_centers
from fsel.core.points import grouped_rows
from fsel.reconstruct.splats import stereo

LOOK_ANGLE = 8.0  # parallax at which stereo works best, degrees
LOOK_SPREAD = (4.0, 12.0)  # width of that preference below and above it, degrees
AXIS_SPREAD = 30.0  # degrees between optical axes
FRAME_BYTES = 1 << 28  # of frames that are kept: 1,500 at 64x48
_adding = Lock()
NEAREST = 16.0  # a frame is searched no nearer than its median depth over this: planes are few


class PreparedFrame(NamedTuple):
    """One frame as matching reads it."""

    image: np.ndarray  # (h, w, 3) float32 grey levels
    grey: np.ndarray  # (h, w) float32, their mean
    enlarged: np.ndarray  # (2h, 2w) uint64, see `stereo.packed`
    rays: np.ndarray  # (2, h, w) float32, x/z and y/z of every pixel


class FrameCache:
    """The frames of a capture, the oldest of which are forgotten."""

    def __init__(self, capture: Capture) -> None:
        self._capture = capture
        self._pixels = pixel_centers(*capture.size)
        self._known: dict[int, PreparedFrame] = {}

    def __getitem__(self, frame: int) -> PreparedFrame:
        prepared = self._known.get(frame)
        if prepared is None:
            image = np.asarray(self._capture.images[frame]).astype(np.float32)
            (x, y), (fx, fy, cx, cy) = self._pixels, self._capture.intrinsics[frame]
            rays = np.stack([(x - cx) / fx, (y - cy) / fy]).astype(np.float32)
            grey, enlarged = image.mean(axis=-1), stereo.packed(image)
            prepared = PreparedFrame(image, grey, enlarged, rays)
            most = FRAME_BYTES // sum(part.nbytes for part in prepared)
            remember(self._known, frame, prepared, most)
        return prepared


def remember(cache: dict, key: Any, value: Any, most: int) -> None:
    """Add to a cache; the oldest entry of one that holds `most` goes: dictionaries keep order."""
    with _adding:  # threads share a cache
        if cache and len(cache) >= most:
            del cache[next(iter(cache))]
        cache[key] = value


def depth_range(capture: Capture) -> np.ndarray:
    """Return (N, 2) nearest and farthest depth that each frame's planes must reach, world units:
    from ten or more points that it sees, else from all, else from the spread of the cameras."""
    n = len(capture)
    if capture.points is None or len(capture.points.track_point) == 0:
        extent = 2 * distances_from_middle(capture.centers)[1] or 1.0
        return np.tile([0.15 * extent, 4 * extent], (n, 1))
    track = capture.points
    rows = capture.world_to_camera[track.track_frame, 2]
    z = np.einsum("li,li->l", rows[:, :3], track.xyz[track.track_point]) + rows[:, 3]
    seen, z = track.track_frame[z > 0], z[z > 0]
    limits = np.tile(np.percentile(z, [0.5, 99.5]), (n, 1))
    middle = np.full(n, np.median(z))
    for i, rows in enumerate(grouped_rows(seen, n)):
        if len(rows) >= 10:
            own = z[rows]
            limits[i], middle[i] = np.percentile(own, [1, 99]), np.median(own)
    limits[:, 0] = np.maximum(limits[:, 0], middle / NEAREST)
    limits[:, 1] = 2.5 * np.maximum(limits[:, 1], np.median(limits[:, 1]))
    return limits


def look_depth(limits: np.ndarray) -> float:
    """The depth at which frames are compared by parallax, from all frames' (N, 2) ranges."""
    return float(np.median(2 / (1 / limits[:, 0] + 1 / limits[:, 1])))


def affinity(centers: np.ndarray, axes: np.ndarray, depth: float) -> np.ndarray:
    """Return (K, K) how well frames, row by row, are served by others as stereo partners, by (K, 3)
    centres and axes and the depth whose parallax counts; -inf on the diagonal."""
    points = centers + axes * depth
    back = -axes
    rays = centers[None] - points[:, None]
    rays /= np.maximum(np.linalg.norm(rays, axis=-1, keepdims=True), 1e-12)
    half_sum = np.linalg.norm(rays + back[:, None], axis=-1)
    half_gap = np.linalg.norm(rays - back[:, None], axis=-1)
    parallax = np.degrees(2 * np.arctan2(half_gap, half_sum))
    spread = np.where(parallax < LOOK_ANGLE, *LOOK_SPREAD)
    gap = np.linalg.norm(axes[:, None] - axes[None], axis=-1)
    tilt = np.degrees(2 * np.arcsin(np.clip(gap / 2, 0, 1)))
    # logarithm of the product of two Gaussians: it ranks even pairs that underflow
    score = -((parallax - LOOK_ANGLE) ** 2) / (2 * spread**2) - (tilt / AXIS_SPREAD) ** 2
    np.fill_diagonal(score, -np.inf)
    return score


def planes(capture: Capture, limits: np.ndarray, bounds: tuple[int, int]) -> np.ndarray:
    """(N, D) inverse depths: one pixel of disparity at the preferred parallax between planes."""
    baseline = 2 * np.tan(np.radians(LOOK_ANGLE) / 2) * look_depth(limits)
    near, far = np.median(limits, axis=0)
    disparity = np.median(capture.intrinsics[:, 0]) * baseline * (1 / near - 1 / far)
    count = int(np.clip(np.ceil(disparity / 8) * 8, *bounds))
    share = np.linspace(0, 1, count)
    inverse = 1 / limits[:, 1:] * (1 - share) + 1 / limits[:, :1] * share
    return inverse.astype(np.float32)
