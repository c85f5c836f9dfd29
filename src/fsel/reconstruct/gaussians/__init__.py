"""3D Gaussian splatting (Kerbl et al. 2023; Kheradmand et al. 2024) on the CPU."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

import numpy as np

from fsel.core.capture import Capture
from fsel.reconstruct.configured import ConfiguredReconstructor, Peak
from fsel.reconstruct.gaussians import initial
from fsel.reconstruct.gaussians.model import GaussianModel
from fsel.reconstruct.gaussians.settings import GaussianSettings
from fsel.reconstruct.gaussians.training import Begun, Training
from fsel.reconstruct.selected import Frame, distinct, restricted

__all__ = ["GaussianModel", "GaussianSettings", "Gaussians"]

logger = logging.getLogger(__name__)
Progress = Callable[[int, int, float], None]


class Gaussians(ConfiguredReconstructor[GaussianSettings]):
    """The reconstructor bound to one capture; see `GaussianSettings`.

    A model depends on the selected frames alone: on their images, cameras and masks, and on the
    sparse points that at least two of them see. The order of the frames does not matter.
    """

    settings_type = GaussianSettings

    def fit(
        self,
        frames: np.ndarray,
        progress: Progress | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> GaussianModel:
        """Reconstruct from a subset.

        Args:
            frames: (K,) int64 distinct frames, K >= 2.
            progress: called after each step with the steps made, all steps, and the loss.
            stop: called before each step; when it returns True, the model so far is returned.

        Raises:
            ValueError: for fewer than two frames, repeated ones, or nothing to start from.
        """
        started, peak = time.perf_counter(), Peak()
        begun = self._begun(np.sort(distinct(frames)))
        steps, table = 0, begun.table
        if len(table):
            training = Training(begun, self.settings)
            steps, table = training.run(progress, stop), training.kept
        return GaussianModel(
            frame=begun.frame,
            table=table,
            background=begun.background,
            steps=steps,
            seconds=time.perf_counter() - started,
            peak_bytes=peak.bytes,
        )

    def _begun(self, frames: np.ndarray) -> Begun:
        capture = restricted(self.capture, frames)
        frame, settings = Frame.of(capture), self.settings
        begin = initial.from_splats if settings.initial == "splats" else initial.from_points
        xyz, rgb = begin(capture)
        if not len(xyz):
            logger.warning("%s: stereo finds no surface; the model is empty", capture.source)
        table = initial.table_of(
            xyz, rgb, frame, settings.degree, settings.gaussians, settings.seed
        )
        return Begun(capture, frame, table, _background(capture, settings.background))


def _background(capture: Capture, name: str) -> np.ndarray:
    """Return the (3,) float32 colour of what is not reconstructed."""
    if name == "black" or (capture.masks is not None and not capture.masks.any()):
        return np.zeros(3, np.float32)
    pixels = capture.images.reshape(-1, 3)
    if capture.masks is not None:
        pixels = pixels[capture.masks.ravel()]
    return (pixels.mean(axis=0, dtype=np.float64) / 255).astype(np.float32)
