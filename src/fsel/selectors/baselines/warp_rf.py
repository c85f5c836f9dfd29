"""WarpRF: the view that the picks' renderings, warped into it, explain least (2506.22433)."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import map_coordinates

from fsel.core.capture import Capture
from fsel.core.geometry import pixel_rays
from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.splat_views import greedily, reconstructed


class Inconsistency:
    """Criterion: at each pixel the least difference from the warped renderings, summed."""

    def __init__(self, capture: Capture, pool: np.ndarray, rows: np.ndarray) -> None:
        model, views = reconstructed(capture, pool, rows)
        self.images, self.cameras = model.render(views), views.intrinsics
        self.poses = model.frame.local_poses(views.world_to_camera)
        self.points = np.empty(self.images.shape)  # that the pixels show
        depth = self.poses[:, 2, :3] @ model.splats[:3] + self.poses[:, 2, 3:]
        most = depth.max(initial=1e-9)
        shown = most * model.painted(views, lambda z: np.maximum(z, 0) / most)[..., None]
        for at, (pose, k) in enumerate(zip(self.poses, self.cameras, strict=True)):
            self.points[at] = (pixel_rays(k, *views.size) * shown[at] - pose[:, 3]) @ pose[:, :3]
        self.least = np.full(self.images.shape[:3], np.inf)

    def scores(self) -> np.ndarray:
        return self.least.sum(axis=(1, 2))

    def add(self, row: int) -> None:
        pose, k = self.poses[row], self.cameras[row]
        seen = np.einsum("vhwb,ab->vhwa", self.points, pose[:, :3]) + pose[:, 3]
        pixel = seen[..., :2] / np.maximum(seen[..., 2:], 1e-9) * k[:2] + k[2:] - 0.5
        where = np.broadcast_arrays(pixel[..., 1:], pixel[..., :1], np.arange(3.0))
        warped = map_coordinates(self.images[row], where, order=1, mode="nearest")  # at the border
        np.minimum(self.least, np.abs(warped - self.images).sum(axis=-1), out=self.least)


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick (k,) int64 frames of the pool, each the view that the warped picks explain least."""
    return greedily(problem, k, Inconsistency)


METHOD = Method(
    "warp_rf", "WarpRF", "observed", nested=True, select=select, tracks=True, begins=True
)
