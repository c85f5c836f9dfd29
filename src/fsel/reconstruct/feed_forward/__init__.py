"""Published feed-forward models of 3D Gaussians, through the package `ffgs`.

Images go in, Gaussians come out in one pass: AnySplat (Jiang et al. 2025), C3G, TokenGS, and any
model that is registered with the package. docs/reconstructors.md has their licences.
"""

from __future__ import annotations

import logging
import time

import numpy as np

from fsel.core.programs.outcome import FAILED, Unfinished
from fsel.reconstruct import gpu
from fsel.reconstruct.bound import Bound
from fsel.reconstruct.feed_forward import loading
from fsel.reconstruct.feed_forward.model import FeedForwardModel, frame_for, inputs_of, table_of
from fsel.reconstruct.feed_forward.settings import FeedForwardSettings
from fsel.reconstruct.gaussians.model import GaussianModel
from fsel.reconstruct.subset import distinct, restricted

__all__ = ["FeedForward", "FeedForwardModel", "FeedForwardSettings"]

logger = logging.getLogger(__name__)


class FeedForward(Bound[FeedForwardSettings]):
    """The reconstructor bound to one capture; see `FeedForwardSettings`.

    A model sees the selected frames' images, and their cameras where it takes cameras. One that
    predicts cameras is placed by the similarity that carries those it predicts for the selected
    frames to the given ones. Frames enter in the order of the capture: some models take the first
    as their reference. Masks are not used. The model's processor brings the images to the size that
    it was trained on.
    """

    settings_type = FeedForwardSettings

    @classmethod
    def check_requirements(cls, settings: FeedForwardSettings) -> None:
        """Refuse, by name, what is not here: the package, the model, its weights, the device."""
        loading.check(settings)
        super().check_requirements(settings)

    def fit(self, frames: np.ndarray) -> FeedForwardModel | GaussianModel:
        """Reconstruct from a subset, in one pass.

        Args:
            frames: (K,) int64 distinct frames, K >= 2.

        Raises:
            ValueError: for fewer than two frames, or repeated ones.
            Unfinished: when the memory does not suffice, or no similarity carries the predicted
                cameras to the given ones.
        """
        frames = np.sort(distinct(frames))
        pipeline, device = loading.pipeline_of(self.settings), self.settings.device
        started, peak = time.perf_counter(), gpu.Peak(device)
        capture = restricted(self.capture, frames)
        frame = frame_for(capture, pipeline)
        output = self._output(pipeline, inputs_of(frame.localised(capture)))
        if device == "cuda":
            gpu.finish()
        spent, most = time.perf_counter() - started, peak.bytes
        if device == "cuda":
            name = gpu.name()
            return FeedForwardModel(
                frame, pipeline, output, seconds=spent, peak_bytes=most, device=name
            )
        near, _ = pipeline.processor.render_planes(output.frame)
        return GaussianModel(
            frame=frame,
            table=table_of(output.gaussians),
            background=np.array(pipeline.processor.background or (0, 0, 0), np.float32),
            near=float(near),
            seconds=spent,
            peak_bytes=most,
        )

    def _output(self, pipeline, views):
        """The model's Gaussians among the given cameras."""
        what = f"{self.capture.source}: {self.settings.model} of {views.images.shape[1]} frames"
        try:
            with gpu.memory_errors(what):
                output = pipeline(views).to_world()
        except ValueError as error:
            raise Unfinished(FAILED, f"{what}: {error}") from error
        residuals = output.frame.residuals
        if residuals is not None:
            logger.info(
                "%s: predicted cameras are at most %.2f degrees and %.3f of their spread off",
                what,
                float(residuals.rotation_deg.max()),
                float(residuals.relative_center_error.max()),
            )
        return output
