"""How good a subset is: reconstruct from it, render, compare."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.capture import Views
from fsel.metrics import score_views
from fsel.reconstruct import Reconstructor


@dataclass(frozen=True)
class Evaluator:
    """Scores subsets of one capture on fixed views.

    Attributes:
        reconstructor: bound to the capture; its caches serve every subset.
        views: T poses to render.
        truth: (T, h, w, 3) uint8 images at those poses, at the reconstruction size.
    """

    reconstructor: Reconstructor
    views: Views
    truth: np.ndarray

    @classmethod
    def on_frames(cls, reconstructor: Reconstructor, frames: np.ndarray) -> Evaluator:
        """Score on frames of the reconstructor's capture: proxies in a search, else targets."""
        capture = reconstructor.capture
        return cls(reconstructor, capture.view(frames), np.asarray(capture.images[frames]))

    def per_view(self, subset: np.ndarray) -> np.ndarray:
        """(T, 3) metrics of every view; columns as `fsel.metrics.METRICS`."""
        model = self.reconstructor.fit(np.sort(subset))
        return score_views(model.render(self.views), self.truth)

    def __call__(self, subset: np.ndarray) -> np.ndarray:
        """(3,) metrics averaged over the views."""
        return self.per_view(subset).mean(axis=0)
