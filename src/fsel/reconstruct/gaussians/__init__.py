"""3D Gaussian splatting, optimised on the CPU (Kerbl et al. 2023; Kheradmand et al. 2024)."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

import numpy as np

from fsel.capture import Capture
from fsel.reconstruct.gaussians import initial
from fsel.reconstruct.gaussians.model import GaussianModel
from fsel.reconstruct.gaussians.settings import GaussianSettings
from fsel.reconstruct.gaussians.training import Training
from fsel.reconstruct.keywords import settings_from
from fsel.reconstruct.memory import Peak
from fsel.reconstruct.normalisation import Frame
from fsel.reconstruct.subset import distinct, restricted

__all__ = ["GaussianModel", "GaussianSettings", "Gaussians"]

logger = logging.getLogger(__name__)


class Gaussians:
    """The reconstructor bound to one capture; see `GaussianSettings`.

    A model depends on the selected frames alone: on their images, cameras and masks, and on the
    sparse points that at least two of them see. The order of the frames does not matter.

    Args:
        capture: already at the reconstruction size.
        settings: keyword arguments of `GaussianSettings`.

    Raises:
        ValueError: for a setting outside its range.
    """

    def __init__(self, capture: Capture, **settings) -> None:
        self.capture = capture
        self.settings = settings_from(GaussianSettings, settings)

    @staticmethod
    def check(**settings) -> None:
        """Refuse settings outside their range; it needs nothing else."""
        settings_from(GaussianSettings, settings)

    def fit(
        self,
        frames: np.ndarray,
        progress: Callable[[int, int, float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> GaussianModel:
        """Reconstruct from a subset.

        Args:
            frames: (K,) int64 distinct frames, K >= 2.
            progress: called after each step with the steps made, all steps, and the loss.
            stop: asked before each step; when it says True, the model so far is returned.

        Raises:
            ValueError: for fewer than two frames, repeated ones, or nothing to start from.
        """
        frames = np.sort(distinct(frames))
        started, peak = time.perf_counter(), Peak()
        capture = restricted(self.capture, frames)
        frame, settings = Frame.of(capture), self.settings
        begin = initial.from_splats if settings.initial == "splats" else initial.from_points
        xyz, rgb = begin(capture)
        if not len(xyz):
            logger.warning("%s: stereo finds no surface; the model is empty", capture.source)
        table = initial.table_of(
            xyz, rgb, frame, settings.degree, settings.gaussians, settings.seed
        )
        background = _background(capture, settings.background)
        training = Training(capture, frame, table, background, settings)
        steps = training.run(progress, stop)
        return GaussianModel(
            frame=frame,
            table=training.kept,
            background=background,
            steps=steps,
            seconds=time.perf_counter() - started,
            peak_bytes=peak.bytes,
        )


def _background(capture: Capture, name: str) -> np.ndarray:
    """(3,) float32 colour of what is not reconstructed."""
    if name == "black" or (capture.masks is not None and not capture.masks.any()):
        return np.zeros(3, np.float32)
    pixels = capture.images.reshape(-1, 3)
    if capture.masks is not None:
        pixels = pixels[capture.masks.ravel()]
    return (pixels.mean(axis=0, dtype=np.float64) / 255).astype(np.float32)
