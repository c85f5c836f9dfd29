"""Conversion of captures to the tensors of `ffgs`, and Gaussians that stay on a GPU."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.core.geometry import invert_pose
from fsel.reconstruct import gpu
from fsel.reconstruct.bound import Fitted
from fsel.reconstruct.feed_forward.loading import package
from fsel.reconstruct.gaussians.table import COLOR, LOGIT, MEAN, SCALE, TURN, width_of
from fsel.reconstruct.normalisation import Frame

CERTAIN = 1e-6  # opacities stay this far from 0 and 1, whose logits are infinite
SMALLEST = 1e-9  # standard deviation, in the normalised frame


@dataclass(frozen=True)
class FeedForwardModel(Fitted):
    """Gaussians on a GPU, rendered by gsplat.

    Attributes:
        pipeline: of `ffgs`, with the model's own settings of the rasteriser.
        output: of the pipeline, the Gaussians in the model's frame.
    """

    pipeline: Any
    output: Any

    @property
    def primitives(self) -> int:
        """Number of Gaussians."""
        return self.output.gaussians.num_gaussians

    @property
    def bytes(self) -> int:
        """Memory of the parameters."""
        out = self.output.gaussians
        parts = (out.means, out.scales, out.quats, out.opacities, out.colors)
        return sum(part.nbytes for part in parts)

    def render(self, views: Views) -> np.ndarray:
        """(T, h, w, 3) float32 images in [0, 1] at the given poses."""
        local = replace(views, world_to_camera=self.frame.local_poses(views.world_to_camera))
        with gpu.memory_errors(f"rendering {len(views)} views"):
            images = self.pipeline.render(self.output, cameras_of(local))["images"][0]
        return np.clip(images.permute(0, 2, 3, 1).float().cpu().numpy(), 0, 1)


def frame_for(capture: Capture, pipeline) -> Frame:
    """The capture's normalised frame, scaled like the poses that the model was trained on."""
    frame = Frame.of(capture)
    spread = getattr(pipeline.processor.config, "camera_spread", None)
    if spread is None or pipeline.processor.camera_input == "none":
        return frame
    away = np.linalg.norm(capture.centers[1:] - capture.centers[0], axis=1).mean()
    return replace(frame, unit=float(away) / spread) if away > 0 else frame


def inputs_of(capture: Capture):
    """Convert a capture to what a model is given, float32: images and cameras."""
    import torch

    cameras = cameras_of(capture.views)
    images = np.ascontiguousarray(np.asarray(capture.images).transpose(0, 3, 1, 2))
    return package().Views(torch.from_numpy(images), cameras.intrinsics[0], cameras.c2w[0])


def cameras_of(views: Views):
    """Views as `ffgs` states cameras, float32: the capture is in its normalised frame."""
    import torch

    poses = np.tile(np.eye(4, dtype=np.float32), (len(views), 1, 1))
    poses[:, :3] = invert_pose(views.world_to_camera)
    matrices = np.tile(np.eye(3, dtype=np.float32), (len(views), 1, 1))
    matrices[:, 0, 0], matrices[:, 1, 1] = views.intrinsics[:, 0], views.intrinsics[:, 1]
    matrices[:, :2, 2] = views.intrinsics[:, 2:]
    width, height = views.size
    return package().Cameras(torch.from_numpy(poses), torch.from_numpy(matrices), (height, width))


def table_of(gaussians) -> np.ndarray:
    """(n, c) float32 parameters as `fsel.reconstruct.gaussians.table` lays them out."""
    harmonics = gaussians.sh()[0].numpy()
    opacity = np.clip(gaussians.opacities[0].numpy().astype(np.float64), CERTAIN, 1 - CERTAIN)
    table = np.empty((len(harmonics), width_of(round(harmonics.shape[1] ** 0.5) - 1)), np.float32)
    table[:, MEAN] = gaussians.means[0].numpy()
    table[:, SCALE] = np.log(np.maximum(gaussians.scales[0].numpy(), SMALLEST))
    table[:, TURN] = gaussians.quats[0].numpy()
    table[:, LOGIT] = np.log(opacity / (1 - opacity))
    table[:, COLOR:] = harmonics.reshape(len(table), -1)
    return table
