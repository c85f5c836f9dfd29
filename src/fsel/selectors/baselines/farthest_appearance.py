"""Farthest points on descriptors from the most central frame: VGGSfM's and VGGT's query frames."""

from __future__ import annotations

import numpy as np

from fsel.core.geometry import farthest_views
from fsel.core.problem import Method, Problem


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Start with the frame that all others resemble most, then the least like those picked."""
    return problem.observed[farthest(problem.descriptors[problem.observed], k)]


def farthest(descriptors: np.ndarray, k: int) -> np.ndarray:
    """Return (k,) rows of (n, d) unit descriptors; their distance grows as the cosine falls."""
    described = np.asarray(descriptors, np.float64)
    central = int(np.argmax(np.einsum("nd,d->n", described, described.sum(axis=0))))
    return farthest_views(np.arange(len(described)), described, k, central).astype(np.int64)


NAME = "farthest_appearance"
METHOD = Method(
    NAME, "Farthest appearance", "observed", nested=True, select=select, reads=("appearance",)
)
