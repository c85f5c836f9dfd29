"""The reconstructor `radiance_field` bound to one capture."""

from __future__ import annotations

import time

import numpy as np

from fsel.core.capture import Capture
from fsel.reconstruct.configured import ConfiguredReconstructor, Peak
from fsel.reconstruct.radiance_field.model import RadianceModel, rays_of
from fsel.reconstruct.radiance_field.settings import RadianceSettings
from fsel.reconstruct.radiance_field.training import Pixels, Progress, optimised
from fsel.reconstruct.selected import Frame, distinct, restricted

NEAR = 0.1  # of the frame's unit: where rays start unless points are nearer
NEAREST = 1.0  # per cent of the points that count as mistaken for being too near


class RadianceField(ConfiguredReconstructor[RadianceSettings]):
    """The reconstructor bound to one capture; see `RadianceSettings`.

    A model depends on the selected frames alone: on their images, cameras and masks, and on the
    sparse points that at least two of them see. The order of the frames does not matter.
    """

    settings_type = RadianceSettings

    def fit(self, frames: np.ndarray, progress: Progress | None = None) -> RadianceModel:
        """Reconstruct from a subset.

        Args:
            frames: (K,) int64 distinct frames, K >= 2.
            progress: called after each step with the steps made, all steps, and the loss.

        Raises:
            ValueError: for fewer than two frames, which hold no parallax, or repeated ones.
        """
        frames = np.sort(distinct(frames))
        started, peak = time.perf_counter(), Peak()
        capture = restricted(self.capture, frames)
        frame = Frame.of(capture)
        pixels = _pixels(frame.localised(capture))
        grid = optimised(pixels, self.settings, progress)
        return RadianceModel(
            frame=frame,
            grid=grid,
            near=pixels.near,
            background=pixels.background,
            seconds=time.perf_counter() - started,
            peak_bytes=peak.bytes,
        )


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
