"""Gain of picks on the frames that are not picked, where the whole capture is to be rendered."""

from __future__ import annotations

import numpy as np

from fsel.data.problem import Problem
from fsel.data.subsets import evenly
from fsel.metrics import score_views
from fsel.reconstruct import Reconstructor

VALIDATION = 96  # frames at most, on which picks are scored
METRIC = ("psnr",)


class UnpickedGain:
    """Mean gain in PSNR over some first picks, on observed frames that neither holds.

    Args:
        reconstructor: bound to the problem's capture, at the reconstruction size.
        problem: whose observed frames are the validation frames.
        picks: (K,) the first picks.

    Attributes:
        frames: (J,) int64 the validation frames, ascending; none of the first picks, so that no
            frame is scored on itself.
        base: (J,) PSNR of each by the first picks.

    Raises:
        ValueError: where every frame is picked.
    """

    def __init__(self, reconstructor: Reconstructor, problem: Problem, picks: np.ndarray) -> None:
        free = np.setdiff1d(problem.observed, picks)
        if not len(free):
            raise ValueError("every frame is picked: none is left to score swaps on")
        self.frames = free[evenly(len(free), VALIDATION)]
        self._reconstructor = reconstructor
        self._images = np.asarray(reconstructor.capture.images[self.frames])
        self.base = self._psnr(picks, np.arange(len(self.frames)))

    def __call__(self, picks: np.ndarray) -> float:
        """Gain in dB of (K,) distinct picks on the validation frames that are not among them."""
        rows = np.flatnonzero(~np.isin(self.frames, picks))
        if not len(rows):
            return -np.inf
        return float((self._psnr(picks, rows) - self.base[rows]).mean())

    def _psnr(self, picks: np.ndarray, rows: np.ndarray) -> np.ndarray:
        model = self._reconstructor.fit(np.sort(picks))
        rendered = model.render(self._reconstructor.capture.view(self.frames[rows]))
        return score_views(rendered, self._images[rows], metrics=METRIC)[:, 0]
