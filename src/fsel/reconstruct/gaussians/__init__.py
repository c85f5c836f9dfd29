"""3D Gaussian splatting (Kerbl et al. 2023; Kheradmand et al. 2024), on the CPU or on a GPU."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import NamedTuple

import numpy as np

from fsel.core.capture import Capture
from fsel.reconstruct import gpu
from fsel.reconstruct.bound import Bound
from fsel.reconstruct.gaussians import initial
from fsel.reconstruct.gaussians.model import GaussianModel
from fsel.reconstruct.gaussians.settings import GaussianSettings
from fsel.reconstruct.gaussians.training import Begun, Steps, Training
from fsel.reconstruct.normalisation import Frame
from fsel.reconstruct.subset import distinct, restricted

__all__ = ["GaussianModel", "GaussianSettings", "Gaussians"]

logger = logging.getLogger(__name__)
WATCHED = 10.0  # seconds between two models that `watch` is shown


class Gaussians(Bound[GaussianSettings]):
    """The reconstructor bound to one capture; see `GaussianSettings`.

    A model depends on the selected frames alone: on their images, cameras and masks, and on the
    sparse points that at least two of them see. The order of the frames does not matter.
    """

    settings_type = GaussianSettings

    def fit(
        self,
        frames: np.ndarray,
        progress: Callable[[int, int, float], None] | None = None,
        stop: Callable[[], bool] | None = None,
        watch: Callable[[GaussianModel], None] | None = None,
    ) -> GaussianModel:
        """Reconstruct from a subset.

        Args:
            frames: (K,) int64 distinct frames, K >= 2.
            progress: called after each step with the steps made, all steps, and the loss.
            stop: called before each step; when it returns True, the model so far is returned.
            watch: called every ten seconds with the model so far.

        Raises:
            ValueError: for fewer than two frames, repeated ones, or nothing to start from.
            Unfinished: when a GPU's memory does not suffice.
        """
        return self._fit([frames], progress, stop, watch)[0]

    def fit_many(self, subsets: Sequence[np.ndarray]) -> Iterator[GaussianModel]:
        """Reconstruct from many subsets: on a GPU together, so far as its memory goes.

        Args:
            subsets: each as `fit` takes it.

        Yields:
            A model a subset. Of those that were fitted together, `seconds` and `peak_bytes` are an
            equal part each.

        Raises:
            ValueError, Unfinished: as `fit`, for any of them.
        """
        most = self.together
        for at in range(0, len(subsets), most):
            yield from self._fit(subsets[at : at + most])

    @property
    def together(self) -> int:
        """Number of subsets that are fitted at once."""
        return _made_on(self.settings.device).together(self.settings, self.capture.size)

    def _fit(
        self,
        subsets: Sequence[np.ndarray],
        progress: Callable[[int, int, float], None] | None = None,
        stop: Callable[[], bool] | None = None,
        watch: Callable[[GaussianModel], None] | None = None,
    ) -> list[GaussianModel]:
        started, peak = time.perf_counter(), gpu.Peak(self.settings.device)
        made = _made_on(self.settings.device)
        begun = [self._begun(np.sort(distinct(frames))) for frames in subsets]
        with made.errors(f"{self.capture.source}: Gaussians of {len(subsets)} subsets"):
            steps, kept = 0, list[np.ndarray]()
            if full := [one for one in begun if len(one.table)]:
                training = made.training(full, self.settings)
                if watch is not None:
                    progress = _watched(training, full[0], made.model, watch, progress)
                steps, kept = training.run(progress, stop), training.kept
        fitted = iter(kept)
        seconds, peak_bytes = time.perf_counter() - started, peak.bytes
        return [
            made.model(
                frame=one.frame,
                table=next(fitted) if len(one.table) else one.table,
                background=one.background,
                steps=steps,
                seconds=seconds / len(subsets),
                peak_bytes=peak_bytes // len(subsets),
                device=made.name,
            )
            for one in begun
        ]

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


def _watched(
    training: Steps,
    begun: Begun,
    model: type[GaussianModel],
    watch: Callable[[GaussianModel], None],
    progress: Callable[[int, int, float], None] | None,
) -> Callable[[int, int, float], None]:
    """The progress that from time to time shows the model so far as well."""
    shown = time.monotonic()

    def advance(step: int, steps: int, loss: float) -> None:
        nonlocal shown
        if progress is not None:
            progress(step, steps, loss)
        if time.monotonic() - shown >= WATCHED:
            watch(model(begun.frame, training.kept[0], begun.background, steps=step))
            shown = time.monotonic()

    return advance


class _Made(NamedTuple):
    """Parts that work on a device."""

    training: Callable[..., Steps]
    together: Callable[[GaussianSettings, tuple[int, int]], int]
    model: type[GaussianModel]
    errors: Callable[[str], AbstractContextManager]
    name: str


def _made_on(device: str) -> _Made:
    if device == "cpu":
        return _Made(Training, lambda *_: 1, GaussianModel, nullcontext, "cpu")
    from fsel.reconstruct.gaussians import cuda  # here: it imports torch

    return _Made(cuda.CudaTraining, cuda.together, cuda.CudaModel, gpu.memory_errors, gpu.name())


def _background(capture: Capture, name: str) -> np.ndarray:
    """(3,) float32 colour of what is not reconstructed."""
    if name == "black" or (capture.masks is not None and not capture.masks.any()):
        return np.zeros(3, np.float32)
    pixels = capture.images.reshape(-1, 3)
    if capture.masks is not None:
        pixels = pixels[capture.masks.ravel()]
    return (pixels.mean(axis=0, dtype=np.float64) / 255).astype(np.float32)
