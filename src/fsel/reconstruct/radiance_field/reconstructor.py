"""The reconstructor `radiance_field` bound to one capture."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.core.geometry import pixel_rays
from fsel.core.threads import ranges, spread
from fsel.reconstruct.configured import ConfiguredReconstructor, Fitted, Peak
from fsel.reconstruct.radiance_field import passes
from fsel.reconstruct.radiance_field.grid import Grid
from fsel.reconstruct.radiance_field.training import (
    FAINT,
    FEWEST_RAYS,
    Pixels,
    RadianceSettings,
    optimised,
)
from fsel.reconstruct.selected import Frame, distinct, restricted

NEAR = 0.1  # of the frame's unit: where rays start unless points are nearer
NEAREST = 1.0  # per cent of the points that count as mistaken for being too near


class RadianceField(ConfiguredReconstructor[RadianceSettings]):
    """The reconstructor bound to one capture; see `RadianceSettings`.

    A model depends on the selected frames alone: on their images, cameras and masks, and on the
    sparse points that at least two of them see. The order of the frames does not matter.
    """

    settings_type = RadianceSettings

    def fit(self, frames: np.ndarray) -> RadianceModel:
        """Reconstruct from (K,) int64 distinct frames; ValueError for fewer than two, which hold
        no parallax, or repeated ones."""
        frames = np.sort(distinct(frames))
        started, peak = time.perf_counter(), Peak()
        capture = restricted(self.capture, frames)
        frame = Frame.of(capture)
        pixels = _pixels(frame.localised(capture))
        grid = optimised(pixels, self.settings)
        return RadianceModel(
            frame=frame,
            grid=grid,
            near=pixels.near,
            background=pixels.background,
            seconds=time.perf_counter() - started,
            peak_bytes=peak.bytes,
        )


@dataclass(frozen=True)
class RadianceModel(Fitted):
    """A radiance field."""

    grid: Grid
    near: float  # where rays start, in the model's frame
    background: np.ndarray  # (3,) float32 colour in [0, 1] where nothing is

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
            rays, image = rays_of(local.subset(slice(t, t + 1))), out[t].reshape(-1, 3)

            def render(first: int, last: int, rays=rays, image=image) -> None:
                own = rays[first:last], self.near
                passes.render_rays(*own, *field, FAINT, image[first:last])

            spread(render, ranges(len(rays), FEWEST_RAYS))
        return np.clip(out, 0, 1, out=out)


def rays_of(views: Views) -> np.ndarray:
    """Return (T * h * w, 6) float32 origins and unit directions through the centres of pixels."""
    ahead = np.stack([pixel_rays(intrinsics, *views.size) for intrinsics in views.intrinsics])
    ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
    rays = np.empty((*ahead.shape[:3], 6), np.float32)
    rays[..., :3] = views.centers[:, None, None]
    rays[..., 3:] = np.einsum("nhwi,nij->nhwj", ahead, views.world_to_camera[:, :, :3])
    return rays.reshape(-1, 6)


def _pixels(capture: Capture) -> Pixels:
    """Return the pixels of a capture in the field's coordinates, masked ones left out."""
    rays, truth = rays_of(capture.views), capture.images.reshape(-1, 3)
    if capture.masks is not None:
        counted = capture.masks.reshape(-1)
        rays, truth = rays[counted], truth[counted]
    background = np.zeros(3) if not len(truth) else truth.mean(axis=0, dtype=np.float64) / 255
    truth = truth.astype(np.float32) / np.float32(255)
    return Pixels(rays, truth, _near(capture), background.astype(np.float32))


def _near(capture: Capture) -> float:
    """Return where rays start: half-way to the nearest points, where there are any."""
    points = capture.points
    if points is None or not len(points.track_point):
        return NEAR
    pose = capture.world_to_camera[points.track_frame, 2]
    depth = np.einsum("li,li->l", pose[:, :3], points.xyz[points.track_point]) + pose[:, 3]
    ahead = depth[depth > 0]
    return float(min(NEAR, np.percentile(ahead, NEAREST) / 2)) if len(ahead) else NEAR
