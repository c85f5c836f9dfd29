"""Any program as a reconstructor: a folder goes in, images come out."""

from __future__ import annotations

import logging
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fsel.core.capture import Views
from fsel.core.registry import settings_from
from fsel.reconstruct.bound import Bound
from fsel.reconstruct.external import folder
from fsel.reconstruct.external.serving import Served, ServedModel
from fsel.reconstruct.external.settings import ExternalSettings
from fsel.reconstruct.external.worker import shared
from fsel.reconstruct.subset import distinct, restricted

__all__ = ["External", "ExternalModel", "ExternalSettings"]

logger = logging.getLogger(__name__)


class External(Bound[ExternalSettings]):
    """The reconstructor bound to one capture; see `ExternalSettings`.

    A program sees the selected frames alone: their images, cameras and masks, and the sparse points
    that at least two of them see. Frames are in the order of the capture.
    """

    settings_type = ExternalSettings

    @classmethod
    def check_requirements(cls, settings: ExternalSettings) -> None:
        """Refuse an environment, a program, a file or a GPU that is not here.

        Raises:
            ExceptionGroup: of one error for each.
        """
        missing = settings.missing()
        if missing:
            raise ExceptionGroup("what is needed and is not here", missing)

    @classmethod
    def needs_gpu(cls, **settings: Any) -> bool:
        """Return what the setting `gpu` says."""
        return settings_from(ExternalSettings, settings).gpu

    @cached_property
    def _served(self) -> Served | None:
        """The worker, where there is one."""
        return Served(self.capture, shared(self.settings)) if self.settings.serve else None

    @property
    def together(self) -> int:
        """Number of subsets that a worker takes at once; 1 for a program that is run for each."""
        return 1 if self._served is None else self._served.together

    def fit_many(self, subsets: Sequence[np.ndarray]) -> Iterator[ExternalModel | ServedModel]:
        """A model a subset, so many at once as a worker takes; see `fit`."""
        for at in range(0, len(subsets), self.together):
            part = subsets[at : at + self.together]
            yield from self._served.fit(part) if self._served else map(self.fit, part)

    def fit(self, frames: np.ndarray) -> ExternalModel | ServedModel:
        """Ask the worker; or write the folder, and run the command `fit` where there is one.

        Args:
            frames: (K,) int64 distinct frames, K >= 2.

        Raises:
            ValueError: for fewer than two frames, or repeated ones.
            Unfinished: when the command fails.
        """
        if self._served is not None:
            return self._served.fit([frames])[0]
        capture = restricted(self.capture, np.sort(distinct(frames)))
        model = ExternalModel(self.settings)
        try:
            folder.write_inputs(model.folder, capture)
            if self.settings.fit is not None:
                model.seconds = model.run(self.settings.fit)
        except BaseException:
            model.close()
            raise
        return model


class ExternalModel:
    """Model that a program made of a folder. Its folder goes with it, unless a workspace keeps it.

    `seconds` are of the command `fit`; where there is none, the whole work is rendering. How many
    primitives there are, and their bytes, is the program's own affair: both are zero.

    Args:
        settings: of the reconstructor.
    """

    primitives = 0
    bytes = 0

    def __init__(self, settings: ExternalSettings) -> None:
        self._settings = settings
        self.folder = Path(tempfile.mkdtemp(prefix="fsel-", dir=settings.workspace)).resolve()
        self.seconds, self.peak_bytes = 0.0, 0
        self.device = "cpu"

    def run(self, words: tuple[str, ...]) -> float:
        """Run one of the settings' commands; returns its seconds.

        Raises:
            Unfinished: when it fails; the end of its log is in the message.
        """
        spent = self._settings.run(words, self.folder)
        logger.info("%s: %.1f s, %.0f MB", words[0], spent.seconds, spent.peak_bytes / 1e6)
        self.peak_bytes, self.device = max(self.peak_bytes, spent.peak_bytes), spent.device
        return spent.seconds

    def render(self, views: Views) -> np.ndarray:
        """(T, h, w, 3) float32 images in [0, 1], by the command `render`.

        Raises:
            Unfinished: when the command fails, or leaves other images than the targets.
        """
        shutil.rmtree(self.folder / folder.RENDERINGS, ignore_errors=True)
        folder.write_targets(self.folder, views)
        self.run(self._settings.render)
        return folder.read_renderings(self.folder, views)

    def close(self) -> None:
        """Remove the folder, unless a workspace keeps it."""
        if self._settings.workspace is None:
            shutil.rmtree(self.folder, ignore_errors=True)

    def __del__(self) -> None:
        if hasattr(self, "folder"):
            self.close()
