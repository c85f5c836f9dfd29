"""The frame nearest to the mean histogram of each batch: ffmpeg's `thumbnail`, as in nerfstudio."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Cut the pool in capture order into k batches as equal as can be; ties go to the lowest."""
    counts = {frame: histogram(problem.capture.images[frame]) for frame in problem.observed}
    picks = []
    for batch in np.array_split(problem.observed, k):
        of_batch = np.array([counts[frame] for frame in batch])
        off = np.square(of_batch - of_batch.mean(axis=0)).sum(axis=1)
        picks.append(batch[np.argmin(off)])
    return np.array(picks)


def histogram(image: np.ndarray) -> np.ndarray:
    """Return (3 * 256,) int64 pixels of an (h, w, 3) uint8 image at each level of a channel."""
    return np.bincount((image + np.array([0, 256, 512])).ravel(), minlength=3 * 256)


METHOD = Method(
    "thumbnail", "ffmpeg thumbnail", "observed", nested=False, select=select, reads=("images",)
)
