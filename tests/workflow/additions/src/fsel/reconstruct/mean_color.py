"""The nearest picked frame's mean colour, whatever is asked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.capture import Capture, Views
from fsel.geometry import pairwise_distances


@dataclass(frozen=True)
class Colors:
    """One colour a frame.

    Attributes:
        centers: (K, 3) of the frames.
        colors: (K, 3) float32 in [0, 1].
    """

    centers: np.ndarray
    colors: np.ndarray
    seconds: float = 0.0

    @property
    def primitives(self) -> int:
        return len(self.colors)

    @property
    def bytes(self) -> int:
        return self.colors.nbytes

    def render(self, views: Views) -> np.ndarray:
        """(T, h, w, 3) float32."""
        nearest = pairwise_distances(views.centers, self.centers).argmin(axis=1)
        width, height = views.size
        return np.tile(self.colors[nearest][:, None, None], (1, height, width, 1))


@dataclass(frozen=True)
class MeanColor:
    """Bound to a capture."""

    capture: Capture

    def fit(self, frames: np.ndarray) -> Colors:
        """The frames' colours."""
        means = self.capture.images[frames].mean(axis=(1, 2)) / 255
        return Colors(self.capture.centers[frames], means.astype(np.float32))
