"""3D Gaussian splatting (Kerbl et al. 2023; Kheradmand et al. 2024) on the CPU."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fsel.core.capture import Capture
from fsel.reconstruct.configured import ConfiguredReconstructor, Peak
from fsel.reconstruct.gaussians import initial
from fsel.reconstruct.gaussians.model import GaussianModel
from fsel.reconstruct.gaussians.settings import GaussianSettings
from fsel.reconstruct.gaussians.training import Progress, Training
from fsel.reconstruct.selected import Frame, distinct, restricted

__all__ = ["GaussianModel", "GaussianSettings", "Gaussians"]

logger = logging.getLogger(__name__)


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
        capture = restricted(self.capture, np.sort(distinct(frames)))
        model = self._start(capture)
        if model.primitives:
            model = Training(capture, model, self.settings).run(progress, stop)
        return replace(model, seconds=time.perf_counter() - started, peak_bytes=peak.bytes)

    def _start(self, capture: Capture) -> GaussianModel:
        """Return the Gaussians to start from, none where stereo finds no surface."""
        frame, settings = Frame.of(capture), self.settings
        begin = initial.from_splats if settings.initial == "splats" else initial.from_points
        xyz, rgb = begin(capture)
        if not len(xyz):
            logger.warning("%s: stereo finds no surface; the model is empty", capture.source)
        drawn = settings.degree, settings.gaussians, settings.seed
        table = initial.table_of(xyz, rgb, frame, *drawn)
        return GaussianModel(frame, table, _background(capture, settings.background))


def _background(capture: Capture, name: str) -> np.ndarray:
    """Return the (3,) float32 colour of what is not reconstructed."""
    if name == "black" or (capture.masks is not None and not capture.masks.any()):
        return np.zeros(3, np.float32)
    pixels = capture.images.reshape(-1, 3)
    if capture.masks is not None:
        pixels = pixels[capture.masks.ravel()]
    return (pixels.mean(axis=0, dtype=np.float64) / 255).astype(np.float32)
