"""A fitted field: what it holds, and its images."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.core.capture import Views
from fsel.core.geometry import pixel_rays
from fsel.reconstruct.configured import Fitted
from fsel.reconstruct.radiance_field import passes
from fsel.reconstruct.radiance_field.grid import Grid
from fsel.reconstruct.radiance_field.training import FAINT


@dataclass(frozen=True)
class RadianceModel(Fitted):
    """A radiance field.

    Attributes:
        grid: densities and colours.
        near: distance at which rays start, in the model's frame.
        background: (3,) float32 colour in [0, 1] where nothing is.
    """

    grid: Grid
    near: float
    background: np.ndarray

    @property
    def primitives(self) -> int:
        """Number of grid cells with content."""
        return int(self.grid.occupied.sum())

    @property
    def bytes(self) -> int:
        """Memory of the field."""
        return self.grid.bytes

    def render(self, views: Views) -> np.ndarray:
        """Return (T, h, w, 3) float32 images in [0, 1] at the given poses."""
        width, height = views.size
        out = np.empty((len(views), height, width, 3), np.float32)
        poses = self.frame.local_poses(views.world_to_camera)
        local, grid = Views(poses, views.intrinsics, views.size), self.grid
        field = grid.shape, grid.field, grid.harmonics, self.background
        for t in range(len(views)):
            rays = rays_of(local.subset(slice(t, t + 1)))
            passes.render_rays(rays, self.near, *field, FAINT, out[t].reshape(-1, 3))
        return np.clip(out, 0, 1, out=out)


def rays_of(views: Views) -> np.ndarray:
    """Return (T * h * w, 6) float32 origins and unit directions through the centres of pixels."""
    ahead = np.stack([pixel_rays(intrinsics, *views.size) for intrinsics in views.intrinsics])
    ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
    rays = np.empty((*ahead.shape[:3], 6), np.float32)
    rays[..., :3] = views.centers[:, None, None]
    rays[..., 3:] = np.einsum("nhwi,nij->nhwj", ahead, views.world_to_camera[:, :, :3])
    return rays.reshape(-1, 6)
