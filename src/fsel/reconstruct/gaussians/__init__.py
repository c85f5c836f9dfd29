"""3D Gaussian splatting (Kerbl et al. 2023; Kheradmand et al. 2024) on the CPU."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from fsel.core.capture import Capture
from fsel.reconstruct.configured import ConfiguredReconstructor, Peak
from fsel.reconstruct.gaussians.model import GaussianModel
from fsel.reconstruct.gaussians.parameters import C0, COLOR, LOGIT, MEAN, SCALE, TURN, width_of
from fsel.reconstruct.gaussians.settings import GaussianSettings
from fsel.reconstruct.gaussians.training import Progress, Training
from fsel.reconstruct.selected import Frame, distinct, restricted
from fsel.reconstruct.splats import Splats

__all__ = ["GaussianModel", "GaussianSettings", "Gaussians"]

logger = logging.getLogger(__name__)

OPACITY = 0.5  # at the start (Kheradmand et al. 2024)
NEIGHBOURS = 3  # whose distances give a Gaussian its size (Kerbl et al. 2023)
STEREO_SIDE = 128  # pixels of the longer side at which stereo runs
SMALLEST = 1e-4  # standard deviation, where the neighbours are in the same place


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
        begin = from_splats if settings.initial == "splats" else from_points
        xyz, rgb = begin(capture)
        if not len(xyz):
            logger.warning("%s: stereo finds no surface; the model is empty", capture.source)
        table = table_of(xyz, rgb, frame, settings)
        return GaussianModel(frame, table, _background(capture, settings.background))


def _background(capture: Capture, name: str) -> np.ndarray:
    """Return the (3,) float32 colour of what is not reconstructed."""
    if name == "black" or (capture.masks is not None and not capture.masks.any()):
        return np.zeros(3, np.float32)
    pixels = capture.images.reshape(-1, 3)
    if capture.masks is not None:
        pixels = pixels[capture.masks.ravel()]
    return (pixels.mean(axis=0, dtype=np.float64) / 255).astype(np.float32)


def from_splats(capture: Capture) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (n, 3) and colours (n, 3) in [0, 1] of the frames' splats."""
    small = capture.resized(STEREO_SIDE)
    model = Splats(small).fit(np.arange(len(small)))
    return model.positions, model.colors.astype(np.float64) / 255


def from_points(capture: Capture) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (n, 3) and colours (n, 3) in [0, 1] of the sparse points, or refuse none."""
    if capture.points is None or not len(capture.points.xyz):
        raise ValueError(
            f"{capture.source}: no sparse point is seen by two of the {len(capture)} selected "
            "frames. Hint: initial: splats"
        )
    return capture.points.xyz, capture.points.rgb / 255


def table_of(
    xyz: np.ndarray, rgb: np.ndarray, frame: Frame, settings: GaussianSettings
) -> np.ndarray:
    """Return (min(n, budget), c) float32 round Gaussians, as large as the way to their neighbours.

    Args:
        xyz: (n, 3) world units; of more than `settings.gaussians` as many are drawn.
        rgb: (n, 3) in [0, 1].
        frame: the normalised frame.
        settings: of whose harmonics all but the first start at zero.
    """
    if len(xyz) > (budget := settings.gaussians):
        drawn = np.random.default_rng(settings.seed).choice(len(xyz), budget, replace=False)
        drawn.sort()
        xyz, rgb = xyz[drawn], rgb[drawn]
    local = (xyz - frame.origin) / frame.unit
    table = np.zeros((len(xyz), width_of(settings.degree)), np.float32)
    table[:, MEAN] = local
    spacing = np.full(len(local), 0.1)
    if len(local) > 1:  # root mean square distance to the nearest others
        gaps = cKDTree(local).query(local, min(NEIGHBOURS + 1, len(local)))[0][:, 1:]
        spacing = np.maximum(np.sqrt((gaps**2).mean(axis=1)), SMALLEST)
    table[:, SCALE] = np.log(spacing)[:, None]
    table[:, TURN.start] = 1
    table[:, LOGIT] = np.log(OPACITY / (1 - OPACITY))
    table[:, COLOR : COLOR + 3] = (rgb - 0.5) / C0
    return table
