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
        masks: (T, h, w) bool, the pixels that count; None for all.
    """

    reconstructor: Reconstructor
    views: Views
    truth: np.ndarray
    masks: np.ndarray | None = None

    @classmethod
    def on_frames(
        cls, reconstructor: Reconstructor, frames: np.ndarray, masked: bool = False
    ) -> Evaluator:
        """Score on frames of the reconstructor's capture: proxies in a search, else targets.

        Args:
            reconstructor: bound to the capture.
            frames: (T,) int64.
            masked: compare inside the capture's masks alone.
        """
        capture = reconstructor.capture
        truth = np.asarray(capture.images[frames])
        masks = np.asarray(capture.masks[frames]) if masked else None
        return cls(reconstructor, capture.view(frames), truth, masks)

    def per_view(self, subset: np.ndarray) -> np.ndarray:
        """(T, 3) metrics of every view; columns as `fsel.metrics.METRICS`."""
        model = self.reconstructor.fit(np.sort(subset))
        return score_views(model.render(self.views), self.truth, self.masks)

    def __call__(self, subset: np.ndarray) -> np.ndarray:
        """(3,) metrics averaged over the views."""
        return self.per_view(subset).mean(axis=0)
